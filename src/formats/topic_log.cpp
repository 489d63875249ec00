#include "formats/topic_log.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "formats/imu_mount.hpp"
#include "formats/message_scan.hpp"
#include "formats/picture_stream.hpp"
#include "formats/recorded_pictures.hpp"
#include "formats/recording_plan.hpp"
#include "formats/ros_geometry.hpp"
#include "formats/skip_tally.hpp"
#include "formats/stamp_order.hpp"
#include "formats/told_transforms.hpp"
#include "formats/topic_counts.hpp"
#include "formats/topic_decoders.hpp"
#include "formats/wheel_stream.hpp"
#include "loopstone/geometry/angle.hpp"

namespace loopstone {
namespace {

/// Messages that came over a network may be late by so much, and frames of tf as well.
constexpr Duration kReorderWindow{10'000'000'000};

/// Stamps that are made up from the order of the messages.
class MadeUpTime {
 public:
  /// \param stream  scans of one laser: each moves on by a period
  Stamp of_scan(int stream, double period_s) {
    Stamp& last = last_[stream];
    last = std::max(last + Duration::from_seconds(period_s), now_);
    now_ = last;
    return now_;
  }
  /// Of anything else: evenly between the scans.
  /// \param step_s  usual time from reading to reading
  Stamp of_reading(std::size_t stream, double step_s, double period_s) {
    const auto [found, is_first] = others_.try_emplace(stream, now_);
    if (is_first) return now_;
    const Stamp last = found->second;
    const Stamp next =
        std::min(last + Duration::from_seconds(step_s), now_ + Duration::from_seconds(period_s));
    found->second = std::max({next, now_, last + Duration{1}});
    return found->second;
  }

 private:
  std::map<int, Stamp> last_{};
  std::map<std::size_t, Stamp> others_{};  ///< by the topic in the survey
  Stamp now_{};
};

class TopicLogReader final : public LogReader {
 public:
  TopicLogReader(std::string format, const OpenRecording& open, const LogOptions& options)
      : format_(std::move(format)),
        options_(options),
        recording_(open(
            recording_options(options_, [this](const Problem& problem) { take_damage(problem); }))),
        decoders_(*recording_),
        known_(plan_recording(*recording_, options_)),
        frames_(known_.survey.frames.standing()),
        order_(
            false, {},
            [this](const OrderedRecord& record, const std::string& reason) {
              skip({where(record), reason}, std::holds_alternative<LaserScan>(record.message));
            },
            options_.live ? StampOrder::kNone : kReorderWindow),
        pictures_(
            std::make_shared<RecordedPictures>(open, RecordingOptions{.memory = options_.memory})) {
    if (known_.choice.camera) {
      frames_of_camera_.emplace(known_.survey.topics[known_.choice.camera->depth].name,
                                known_.survey.topics[known_.choice.camera->colour].name);
    }
    place_topics();
    mount_imu();
    if (!known_.wheels.empty()) wheels_.emplace(known_.wheels, *recording_, known_.survey);
    recording_->want([this](const RecordedTopic& topic) { return is_wanted(topic); });
  }

  std::optional<SensorMessage> next() override {
    for (;;) {
      if (auto record = order_.pop()) {
        if (auto* scan = std::get_if<LaserScan>(&record->message)) {
          if (!mount(*scan, *record)) continue;
        }
        if (auto* frame = std::get_if<RgbdFrame>(&record->message)) {
          if (!mount(*frame, *record)) continue;
        }
        return std::move(record->message);
      }
      if (at_end_) return std::nullopt;
      try {
        if (const auto message = recording_->next()) {
          take(*message);
          continue;
        }
        push_frames(true);
        order_.close();
      } catch (const ReadingStopped&) {
      }
      at_end_ = true;
    }
  }

  ReadProgress progress() const override { return recording_->progress(); }
  std::string format() const override { return format_; }
  const SkippedRecords& skipped() const override { return tally_.skipped(); }
  std::vector<std::string> choices() const override { return known_.choice.choices; }
  RobotModel robot(RobotModel base) const override;
  WheelModel wheels(WheelModel base) const override {
    return known_.wheels.empty() ? base : known_.wheels.model;
  }
  std::shared_ptr<const PictureStore> pictures() const override { return pictures_; }
  std::string camera_fault() const override {
    return known_.choice.camera ? known_.choice.camera->fault : "";
  }
  std::vector<std::string> notes() const override;
  std::vector<std::string> warnings() const override;
  std::vector<TopicSummary> topics() const override {
    return counts_.summaries(*recording_, known_.survey, known_.choice);
  }

 private:
  /// What a recorded topic is to the reader.
  struct Place {
    std::size_t topic = 0;  ///< in the survey
    TopicRole role = TopicRole::kNone;
    int lidar = 0;
    double period_s = 0.0;  ///< usual, from scan to scan; of lasers
  };

  void take_damage(const Problem& problem) { skip(problem, false); }

  void skip(const Problem& problem, bool is_scan) {
    if (options_.strict) throw DataError(problem.location, problem.reason);
    const LogProblem told{problem, is_scan};
    tally_.add(told);
    if (options_.on_problem) options_.on_problem(told);
  }

  [[nodiscard]] Location where(const OrderedRecord& record) const {
    Location location{file_};
    if (record.line >= 0) location.byte_offset = record.line;
    return location;
  }

  bool is_wanted(const RecordedTopic& topic) const {
    if (options_.topics.count_all) return true;
    const TopicKind kind = kind_of(topic.type);
    if (kind == TopicKind::kTransforms) return true;
    const auto place = known_.survey.find(topic);
    return place && known_.choice.roles[*place] != TopicRole::kNone;
  }

  static bool shows_pictures(TopicRole role) {
    return role == TopicRole::kDepth || role == TopicRole::kColour;
  }

  /// Of every topic that the recording has told of.
  void place_topics() {
    for (std::size_t recorded = places_.size(); recorded < recording_->topics().size();
         ++recorded) {
      places_.push_back(place_of(recorded));
    }
  }

  [[nodiscard]] Place place_of(std::size_t recorded) {
    const RecordedTopic& told = recording_->topics()[recorded];
    const auto found = known_.survey.find(told);
    Place place{.topic = found.value_or(known_.survey.topics.size())};
    if (found) place.role = known_.choice.roles[*found];
    for (std::size_t k = 0; k < known_.choice.lasers.size(); ++k) {
      if (known_.choice.lasers[k].topic != place.topic) continue;
      place.lidar = static_cast<int>(k);
      place.period_s = known_.survey.topics[place.topic].stamps.period_s();
    }
    if (kind_of(told.type) == TopicKind::kTransforms) place.role = TopicRole::kTransforms;
    if (shows_pictures(place.role)) pictures_->add_topic(recorded, told);
    return place;
  }

  void mount_imu() {
    if (!known_.choice.imu) return;
    const TopicFacts& facts = known_.survey.topics[*known_.choice.imu];
    const auto base_T_imu = known_.choice.base_frame.empty()
                                ? std::nullopt
                                : known_.survey.frames.find(known_.choice.base_frame, facts.frame);
    const auto by_tf =
        base_T_imu ? std::optional(base_T_imu->rotation) : std::optional<Eigen::Quaterniond>();
    const double seen = std::max<double>(1.0, static_cast<double>(facts.seen));
    imu_mount_ = imu_mount(by_tf, facts.force / seen);
    if (!imu_mount_.warning.empty()) imu_mount_.warning = facts.name + ": " + imu_mount_.warning;
    if (!imu_mount_.note.empty()) imu_mount_.note = facts.name + ": " + imu_mount_.note;
  }

  void take(const RecordedMessage& message) {
    if (message.topic >= places_.size()) place_topics();
    counts_.add(message);
    if (message.file != nullptr && file_ != *message.file) file_ = *message.file;
    const Place& place = places_[message.topic];
    if (place.role == TopicRole::kNone) return;
    try {
      decode(message, place);
    } catch (const MessageError& error) {
      skip({message.where(), recording_->topics()[message.topic].name + ": " + error.what()},
           place.role == TopicRole::kLaser);
    }
  }

  void decode(const RecordedMessage& message, const Place& place) {
    switch (place.role) {
      case TopicRole::kLaser:
        return take_scan(message, place);
      case TopicRole::kOdometry:
        return take_odometry(message, place);
      case TopicRole::kImu:
        return take_imu(message, place);
      case TopicRole::kWheels:
        return take_wheels(message, place);
      case TopicRole::kTransforms:
        return take_transforms(message);
      case TopicRole::kDepth:
      case TopicRole::kColour:
        return take_picture(message, place);
      case TopicRole::kNone:
      case TopicRole::kTruth:
        return;
    }
  }

  Stamp time(const RecordedMessage& message, const Place& place, Stamp own) {
    const TopicClock& clock = known_.clock_of[place.topic];
    if (clock.source == TopicClock::Source::kOrder) {
      return place.role == TopicRole::kLaser
                 ? made_up_.of_scan(place.lidar, clock.period_s)
                 : made_up(place.topic, clock.period_s, known_.survey.topics[place.topic].seen);
    }
    if (place.role == TopicRole::kLaser && place.lidar == 0) drift_.add(own, message.recorded);
    return clock.time(own, message.recorded);
  }

  /// \param seen  so many of these messages were in the survey
  Stamp made_up(std::size_t stream, double period_s, std::int64_t seen) {
    const auto& lasers = known_.choice.lasers;
    const std::int64_t scans = lasers.empty() ? seen : known_.survey.topics[lasers[0].topic].seen;
    const double share = static_cast<double>(scans) / static_cast<double>(std::max(seen, scans));
    return made_up_.of_reading(stream, share * period_s, period_s);
  }

  void push(SensorMessage sensor, const RecordedMessage& message) {
    order_.push({.message = std::move(sensor), .line = message.offset});
  }

  void take_scan(const RecordedMessage& message, const Place& place) {
    const TopicFacts& facts = known_.survey.topics[place.topic];
    LaserScan scan;
    if (facts.kind == TopicKind::kCloud) {
      decoders_.decode(message, cloud_);
      const auto& mount = known_.choice.lasers[static_cast<std::size_t>(place.lidar)].base_T_laser;
      const Pose3 base_T_laser = mount.value_or(Pose3{});
      scan = slice(cloud_, base_T_laser, options_.topics.slice.value_or(slice_about(base_T_laser)));
      if (!mount) scan.robot_T_lidar.reset();
    } else if (facts.kind == TopicKind::kEchoScan) {
      decoders_.decode(message, echoes_);
      check_frame(echoes_.header, facts);
      scan = to_laser_scan(echoes_, options_.topics.echo, place.period_s, remarks_);
    } else {
      decoders_.decode(message, scan_);
      check_frame(scan_.header, facts);
      scan = to_laser_scan(scan_, place.period_s, remarks_);
      if (options_.intensities && scan_.intensities.size() == scan.ranges_m.size()) {
        scan.intensities = scan_.intensities;
      }
    }
    scan.lidar = place.lidar;
    scan.stamp = time(message, place, scan.stamp);
    push(std::move(scan), message);
  }

  /// Two lasers may share a topic; only the first one's place is known.
  static void check_frame(const msg::Header& header, const TopicFacts& facts) {
    if (header.frame_id.empty() || facts.frame.empty()) return;
    if (frame_name(header.frame_id) == facts.frame) return;
    throw MessageError(
        0, "a scan of the frame '" + header.frame_id + "' among those of '" + facts.frame + "'");
  }

  void take_odometry(const RecordedMessage& message, const Place& place) {
    decoders_.decode(message, odometry_);
    const auto pose = to_pose3(odometry_.pose.pose);
    if (!pose) throw MessageError(0, "the pose is no pose");
    const Stamp stamp = time(message, place, odometry_.header.stamp);
    const bool has_child = !known_.choice.odometry->child.empty();
    push_pose(stamp, *pose, has_child ? frame_name(odometry_.child_frame_id) : "", message);
  }

  /// A pose of a frame on the robot becomes one of the robot's own.
  void push_pose(Stamp stamp, const Pose3& odom_T_child, const std::string& child,
                 const RecordedMessage& message) {
    const Pose3 odom_T_base = frames_.pose_of(known_.choice.base_frame, child, odom_T_child);
    push(OdometryPose{stamp, to_pose2(odom_T_base)}, message);
  }

  void take_imu(const RecordedMessage& message, const Place& place) {
    decoders_.decode(message, imu_);
    if (imu_.angular_velocity_covariance[0] == -1.0) {
      throw MessageError(0, "says of itself that it does not measure turning");
    }
    const Eigen::Matrix3d rotation = imu_mount_.robot_R_imu.toRotationMatrix();
    const ImuSample sample{
        .stamp = time(message, place, imu_.header.stamp),
        .angular_velocity_rad_s = rotation * to_eigen(imu_.angular_velocity),
        .linear_acceleration_m_s2 = rotation * to_eigen(imu_.linear_acceleration)};
    if (!sample.angular_velocity_rad_s.allFinite() ||
        !sample.linear_acceleration_m_s2.allFinite()) {
      throw MessageError(0, "what it measured is no number");
    }
    push(sample, message);
  }

  void take_wheels(const RecordedMessage& message, const Place& place) {
    if (known_.survey.topics[place.topic].kind != TopicKind::kTicks) {
      const Stamp own = wheels_->read(message, place.topic);
      for (WheelTicks& ticks : wheels_->add(time(message, place, own))) {
        order_.push({.message = ticks, .line = message.offset, .is_brought_together = true});
      }
      return;
    }
    const auto ticks = decoders_.decode<msg::WheelTicks>(message);
    push(WheelTicks{time(message, place, ticks.header.stamp), ticks.counts}, message);
  }

  /// Only its stamp and its place are kept.
  void take_picture(const RecordedMessage& message, const Place& place) {
    const RecordedTopic& topic = recording_->topics()[message.topic];
    const auto header = decode_header(topic.format, message.bytes);
    if (!header) throw MessageError(0, "the picture is cut off");
    const Stamp stamp = time(message, place, header->stamp);
    const std::int64_t number = pictures_->add(message.topic, message.place);
    if (place.role == TopicRole::kDepth) {
      frames_of_camera_->add_depth(stamp, number);
    } else {
      frames_of_camera_->add_colour(stamp, number);
    }
    push_frames(false);
  }

  void push_frames(bool at_end) {
    if (!frames_of_camera_) return;
    for (RgbdFrame& frame : frames_of_camera_->take(at_end)) {
      order_.push({.message = std::move(frame), .line = -1, .is_brought_together = true});
    }
  }

  void take_transforms(const RecordedMessage& message) {
    decoders_.decode(message, transforms_);
    const bool fixed = is_static_tf(recording_->topics()[message.topic]);
    for_each_transform(transforms_, [&](const ToldTransform& told) {
      if (!told.parent_T_child) {
        skip({message.where(), "tf of " + told.child + ": the pose is no pose"}, false);
      } else if (fixed) {
        frames_.add_fixed(told.parent, told.child, *told.parent_T_child);
      } else {
        const Stamp stamp = known_.tf_clock.time(told.stamp, message.recorded);
        frames_.add(told.parent, told.child, stamp, *told.parent_T_child);
        take_odometry_of_tf(told.parent, told.child, stamp, *told.parent_T_child, message);
      }
    });
  }

  void take_odometry_of_tf(const std::string& parent, const std::string& child, Stamp stamp,
                           const Pose3& pose, const RecordedMessage& message) {
    const auto& odometry = known_.choice.odometry;
    if (!odometry || odometry->topic || parent != odometry->parent || child != odometry->child) {
      return;
    }
    if (known_.tf_clock.source == TopicClock::Source::kOrder) {
      const std::size_t stream = known_.survey.topics.size();
      const std::int64_t seen = seen_of(child);
      return push_pose(made_up(stream, known_.tf_clock.period_s, seen), pose, child, message);
    }
    // Programs publish a pose again until they have the next.
    if (last_of_tf_ == stamp) return;
    last_of_tf_ = stamp;
    push_pose(stamp, pose, child, message);
  }

  [[nodiscard]] std::int64_t seen_of(const std::string& child) const {
    std::int64_t seen = 1;
    for (const MovingFrame& frame : known_.survey.moving) {
      if (frame.child == child) seen = std::max(seen, frame.stamps.count());
    }
    return seen;
  }

  /// Where the laser sat when it took the scan. False: it can't be told, or the scan is no use.
  bool mount(LaserScan& scan, const OrderedRecord& record) {
    const ChosenLaser& laser = known_.choice.lasers[static_cast<std::size_t>(scan.lidar)];
    const TopicFacts& facts = known_.survey.topics[laser.topic];
    if (!laser.base_T_laser || facts.kind == TopicKind::kCloud) return true;
    const auto base_T_laser =
        frames_.find(known_.choice.base_frame, facts.frame, record_time(scan.stamp));
    if (!base_T_laser) {
      skip({where(record), facts.name + ": tf does not tell where the laser was at that time"},
           true);
      return false;
    }
    if (degrees(tilt_of(*base_T_laser)) > kMostTiltDeg) {
      ++tilted_[facts.name];
      return false;
    }
    place(*base_T_laser, scan);
    return true;
  }

  /// The same for a camera that moves on the robot.
  bool mount(RgbdFrame& frame, const OrderedRecord& record) {
    const ChosenCamera& camera = *known_.choice.camera;
    if (!camera.mount_moves || !camera.fault.empty()) return true;
    const auto base_T_frame =
        frames_.find(known_.choice.base_frame, camera.frame, record_time(frame.stamp));
    if (!base_T_frame) {
      skip({where(record), "tf does not tell where the camera was when a picture was taken"},
           false);
      return false;
    }
    frame.robot_T_camera = robot_T_camera(camera, *base_T_frame);
    return true;
  }

  /// Frames that move are asked by the log's clock; made-up stamps know nothing of it.
  [[nodiscard]] std::optional<Stamp> record_time(Stamp stamp) const {
    if (known_.tf_clock.source == TopicClock::Source::kOrder) return std::nullopt;
    return stamp;
  }

  std::string format_;
  LogOptions options_;
  SkipTally tally_{};
  std::unique_ptr<Recording> recording_;
  TopicDecoders decoders_;
  RecordingPlan known_;
  FrameTree frames_;
  StampOrder order_;
  std::shared_ptr<RecordedPictures> pictures_;
  std::optional<PictureStream> frames_of_camera_{};
  std::vector<Place> places_{};  ///< of the recorded topics
  TopicCounts counts_{};
  ImuMount imu_mount_{};
  std::optional<WheelStream> wheels_{};  ///< by other messages than our own
  ScanRemarks remarks_{};
  ClockDrift drift_{};
  MadeUpTime made_up_{};
  std::optional<Stamp> last_of_tf_{};             ///< odometry by tf
  std::map<std::string, std::int64_t> tilted_{};  ///< scans, by topic
  std::string file_{};                            ///< of the last message
  bool at_end_ = false;

  // Memory that is used again for each message.
  msg::LaserScan scan_{};
  msg::MultiEchoLaserScan echoes_{};
  msg::PointCloud2 cloud_{};
  msg::Odometry odometry_{};
  msg::Imu imu_{};
  msg::TFMessage transforms_{};
};

RobotModel TopicLogReader::robot(RobotModel base) const {
  base.wheels = wheels(base.wheels);
  base.lidars.resize(std::max<std::size_t>(1, known_.choice.lasers.size()));
  for (std::size_t i = 0; i < known_.choice.lasers.size(); ++i) {
    const ChosenLaser& laser = known_.choice.lasers[i];
    const Pose3 base_T_laser = laser.base_T_laser.value_or(Pose3{});
    base.lidars[i].name = known_.survey.topics[laser.topic].name;
    base.lidars[i].robot_T_lidar = to_pose2(base_T_laser);
    base.lidars[i].height_m = base_T_laser.translation.z();
  }
  if (known_.choice.camera && known_.choice.camera->fault.empty()) {
    base.camera = known_.choice.camera->model;
  }
  return base;
}

std::vector<std::string> TopicLogReader::notes() const {
  std::vector<std::string> notes = recording_->notes();
  for (const std::string& note : known_.clocks.notes) notes.push_back(note);
  if (!imu_mount_.note.empty()) notes.push_back(imu_mount_.note);
  if (wheels_) {
    for (const std::string& note : wheels_->notes()) notes.push_back(note);
  }
  for (const auto& [what, count] : remarks_.counts()) {
    notes.push_back(fmt::format("{} ({} scans)", what, count));
  }
  if (order_.records_out_of_order() > 0) {
    notes.push_back(fmt::format(
        "{} messages stood out of the order of their stamps, by up to {:.3f} s; they were put in "
        "order",
        order_.records_out_of_order(), order_.largest_step_back().seconds()));
  }
  constexpr double kDriftWorthAWordS = 0.01;
  if (const auto drift_s = drift_.drift_s(); drift_s && std::abs(*drift_s) > kDriftWorthAWordS) {
    notes.push_back(
        fmt::format("the laser's clock and the recorder's ran {:.0f} ms apart over the recording",
                    1e3 * *drift_s));
  }
  for (const std::string& frame : frames_.contested()) {
    notes.push_back("tf names two parents of " + frame + ": the first is believed");
  }
  return notes;
}

std::vector<std::string> TopicLogReader::warnings() const {
  std::vector<std::string> warnings = known_.choice.warnings;
  for (const std::string& warning : known_.clocks.warnings) warnings.push_back(warning);
  if (!imu_mount_.warning.empty()) warnings.push_back(imu_mount_.warning);
  for (const auto& [name, count] : tilted_) {
    warnings.push_back(
        fmt::format("{}: {} scans are not used: the laser was tilted by more than {:.0f} deg", name,
                    count, kMostTiltDeg));
  }
  return warnings;
}

}  // namespace

std::unique_ptr<LogReader> open_topic_log(const std::string& format, const OpenRecording& open,
                                          const LogOptions& options) {
  return std::make_unique<TopicLogReader>(format, open, options);
}

}  // namespace loopstone
