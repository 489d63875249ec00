#include "formats/rawlog_reader.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "formats/order_stamps.hpp"
#include "formats/rawlog_objects.hpp"
#include "formats/skip_tally.hpp"
#include "formats/stamp_order.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/geometry/angle.hpp"

namespace loopstone {
namespace {

/// Of scans that are looked at before the first is given, of objects and of unpacked bytes.
constexpr int kScansOfSurvey = 240;
constexpr int kObjectsOfSurvey = 4000;
constexpr std::int64_t kBytesOfSurvey = std::int64_t{1} << 24;
constexpr double kUsualRateHz = 10.0;
constexpr double kBeyondAnyScanner_m = 1000.0;
/// As in other logs.
constexpr double kFarthestPoseM = 1e7;
constexpr double kTiltWorthAWarning_rad = 2.0 * kPi / 180.0;

/// A laser's place in the plane, and what a plane leaves out of it.
struct PlanarMount {
  Pose2 robot_T_lidar;
  bool upside_down = false;  ///< its beams run the other way round
  double tilt_rad = 0.0;     ///< of its plane against the robot's
};

PlanarMount planar(const RawlogPose3& pose) {
  const auto& r = pose.rotation;
  PlanarMount mount;
  mount.robot_T_lidar = {pose.position_m[0], pose.position_m[1], std::atan2(r[3], r[0])};
  mount.upside_down = r[8] < 0.0;
  mount.tilt_rad = std::acos(std::min(std::abs(r[8]), 1.0));
  return mount;
}

/// Beams that are marked as bad and nearly reach the maximum saw nothing; others that are marked,
/// and 0, say nothing. Nearly: a simulator's noise takes the maximum back by up to 5 %.
void translate_ranges(RawlogScan& scan) {
  constexpr float kNearTheMaximum = 0.95F;
  scan.max_range_m = std::min(scan.max_range_m, kBeyondAnyScanner_m);
  const auto most_m = static_cast<float>(scan.max_range_m);
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
    float& range_m = scan.ranges_m[i];
    if (range_m >= (scan.valid[i] ? most_m : kNearTheMaximum * most_m)) {
      range_m = std::numeric_limits<float>::infinity();
    } else if (!scan.valid[i] || !(range_m > 0.0F)) {
      range_m = std::numeric_limits<float>::quiet_NaN();
    }
  }
}

LaserScan to_laser_scan(RawlogScan&& scan, Stamp stamp, int lidar, const PlanarMount& mount) {
  translate_ranges(scan);
  LaserScan result;
  result.stamp = stamp;
  result.lidar = lidar;
  result.robot_T_lidar = mount.robot_T_lidar;
  result.range_max_m = scan.max_range_m;
  const auto beams = scan.ranges_m.size();
  const double turn = scan.right_to_left == mount.upside_down ? -1.0 : 1.0;
  result.angle_min_rad = -0.5 * turn * scan.aperture_rad;
  if (beams > 1) {
    result.angle_increment_rad = turn * scan.aperture_rad / static_cast<double>(beams - 1);
  }
  result.ranges_m = std::move(scan.ranges_m);
  return result;
}

/// Lasers are told apart by their labels, and where they have none by their places.
class Lidars {
 public:
  /// The index of a scan's laser; nothing when there are too many.
  std::optional<int> of(const RawlogScan& scan) {
    const auto& at = scan.robot_T_lidar.position_m;
    const auto& turned = scan.robot_T_lidar.rotation;
    const std::string key = !scan.label.empty() ? scan.label
                                                : fmt::format("{:.2f} {:.2f} {:.2f} {:.1f}", at[0],
                                                              at[1], turned[0], turned[3]);
    const auto known = indices_.find(key);
    if (known != indices_.end()) return known->second;
    if (indices_.size() >= static_cast<std::size_t>(kRawlogLidars)) return std::nullopt;
    const int index = static_cast<int>(indices_.size());
    indices_.emplace(key, index);
    labels_.push_back(scan.label.empty() ? fmt::format("laser {}", index + 1) : scan.label);
    mounts_.push_back(planar(scan.robot_T_lidar));
    return index;
  }
  [[nodiscard]] const std::vector<std::string>& labels() const { return labels_; }
  /// As first stated.
  [[nodiscard]] const std::vector<PlanarMount>& mounts() const { return mounts_; }

 private:
  std::map<std::string, int> indices_{};
  std::vector<std::string> labels_{};
  std::vector<PlanarMount> mounts_{};
};

/// What must be known before the first message.
struct Survey {
  Lidars lidars{};
  bool any_scan = false;
  bool has_observed_odometry = false;  ///< else it is in the actions
  bool any_motion = false;
  std::vector<double> stamps_s{};  ///< of the first laser's scans
  std::int64_t scans_without_stamp = 0;
  bool saw_all = false;  ///< of the file
  std::string first_other{};
  std::string first_problem{};

  [[nodiscard]] bool is_empty() const { return !any_scan && !has_observed_odometry && !any_motion; }
  /// Neighbours that have different stamps.
  [[nodiscard]] bool clock_was_set() const {
    return std::adjacent_find(stamps_s.begin(), stamps_s.end(), std::not_equal_to<>()) !=
           stamps_s.end();
  }
  [[nodiscard]] std::optional<double> mean_step_s() const {
    double sum_s = 0.0;
    int steps = 0;
    for (std::size_t i = 1; i < stamps_s.size(); ++i) {
      const double step_s = stamps_s[i] - stamps_s[i - 1];
      if (step_s < 0.001 || step_s > 2.0) continue;
      sum_s += step_s;
      ++steps;
    }
    return steps >= 4 ? std::optional(sum_s / steps) : std::nullopt;
  }
};

Survey survey_of(const ReadableBytes& log) {
  Survey survey;
  RawlogObjects objects(first_bytes(log.look(0), kBytesOfSurvey));
  int scans = 0;
  for (int i = 0; i < kObjectsOfSurvey && scans < kScansOfSurvey; ++i) {
    std::optional<RawlogObject> object;
    try {
      object = objects.next();
    } catch (const DataError&) {  // the reader comes there, too, and tells
      break;
    }
    if (!object) {
      survey.saw_all = objects.offset() < kBytesOfSurvey;
      break;
    }
    if (const auto* scan = std::get_if<RawlogScan>(&object->content)) {
      ++scans;
      survey.any_scan = true;
      const auto lidar = survey.lidars.of(*scan);
      if (!scan->stamp) ++survey.scans_without_stamp;
      if (lidar == 0 && scan->stamp) survey.stamps_s.push_back(scan->stamp->seconds());
    } else if (std::holds_alternative<RawlogOdometry>(object->content)) {
      survey.has_observed_odometry = true;
    } else if (std::holds_alternative<RawlogMotion>(object->content)) {
      survey.any_motion = true;
    } else if (const auto* other = std::get_if<RawlogOther>(&object->content)) {
      if (survey.first_other.empty()) survey.first_other = other->name;
    } else if (const auto* broken = std::get_if<RawlogBroken>(&object->content)) {
      if (survey.first_problem.empty()) survey.first_problem = broken->reason;
    }
  }
  return survey;
}

class RawlogReader final : public LogReader {
 public:
  RawlogReader(const ReadableBytes& log, LogOptions options)
      : path_(log.name),
        options_(std::move(options)),
        survey_(survey_of(log)),
        objects_(log.read()),
        by_order_(options_.stamps == StampUse::kOrder || must_go_by_order()),
        order_(
            false, std::nullopt,
            [this](const OrderedRecord& record, const std::string& reason) {
              skip(record.line, reason, std::holds_alternative<LaserScan>(record.message));
            },
            options_.live ? StampOrder::kNone : StampOrder::kWindow),
        order_stamps_(Duration::from_seconds(survey_.mean_step_s().value_or(1.0 / kUsualRateHz)),
                      survey_.any_scan) {
    if (!survey_.is_empty() || !survey_.saw_all) return;
    std::string found = "it ends before that";
    if (!survey_.first_problem.empty()) found = survey_.first_problem;
    if (!survey_.first_other.empty()) found = "there is " + survey_.first_other;
    throw DataError(
        {path_}, "a rawlog without laser scans (CObservation2DRangeScan) and odometry; " + found);
  }

  std::optional<SensorMessage> next() override {
    for (;;) {
      if (auto record = by_order_ ? order_stamps_.pop() : order_.pop()) {
        return std::move(record->message);
      }
      if (at_end_) {
        if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
        return std::nullopt;
      }
      read_object();
    }
  }

  ReadProgress progress() const override {
    return {objects_.source().bytes_done(), objects_.source().bytes_total()};
  }
  std::string format() const override { return "rawlog"; }
  const SkippedRecords& skipped() const override { return tally_.skipped(); }

  RobotModel robot(RobotModel base) const override {
    const auto& mounts = survey_.lidars.mounts();
    if (base.lidars.size() < mounts.size()) base.lidars.resize(mounts.size());
    for (std::size_t i = 0; i < mounts.size(); ++i) {
      base.lidars[i].robot_T_lidar = mounts[i].robot_T_lidar;
      base.lidars[i].name = survey_.lidars.labels()[i];
    }
    return base;
  }

  std::vector<std::string> notes() const override {
    std::vector<std::string> notes;
    if (order_.records_out_of_order() > 0) {
      notes.push_back(fmt::format(
          "{} records stood out of the order of their stamps, by up to {:.3f} s; they were put in "
          "order",
          order_.records_out_of_order(), order_.largest_step_back().seconds()));
    }
    if (estimates_ > 0) {
      notes.push_back(
          fmt::format("{} motions are estimates by matching of scans, not odometry", estimates_));
    }
    if (options_.stamps == StampUse::kOrder) notes.push_back(rate_text() + ", as asked for");
    const auto& mounts = survey_.lidars.mounts();
    for (std::size_t i = 0; i < mounts.size(); ++i) {
      if (mounts[i].upside_down) {
        notes.push_back(survey_.lidars.labels()[i] + " is mounted upside down");
      }
    }
    for (const auto& [name, count] : unread_) {
      notes.push_back(fmt::format("{} objects of {} are not read", count, name));
    }
    return notes;
  }

  std::vector<std::string> warnings() const override {
    std::vector<std::string> warnings;
    const auto& labels = lidars_.labels();
    for (std::size_t i = 0; i < labels.size(); ++i) {
      const double tilt_rad = tilt_rad_[i];
      if (tilt_rad <= kTiltWorthAWarning_rad) continue;
      warnings.push_back(
          fmt::format("{} is tilted by {:.1f} deg against the robot's plane: its ranges are taken "
                      "as if it were "
                      "not",
                      labels[i], degrees(tilt_rad)));
    }
    if (by_order_ && options_.stamps == StampUse::kAuto) {
      warnings.push_back("the scans have no stamps or all the same: " + rate_text() +
                         "; speeds and pauses can't be trusted");
    }
    return warnings;
  }

 private:
  /// No stamps, or all the same.
  [[nodiscard]] bool must_go_by_order() const {
    constexpr std::size_t kFewest = 5;
    if (options_.stamps != StampUse::kAuto || !survey_.any_scan) return false;
    const bool none = survey_.stamps_s.empty() && survey_.scans_without_stamp > 0;
    return none || (survey_.stamps_s.size() >= kFewest && !survey_.clock_was_set());
  }
  [[nodiscard]] std::string rate_text() const {
    const auto step_s = survey_.mean_step_s();
    return fmt::format(
        "the objects come in the order of the file, with stamps made up for {:.3g} scans a second "
        "({})",
        1.0 / step_s.value_or(1.0 / kUsualRateHz),
        step_s ? "the mean step of their stamps" : "a usual rate of lasers; the log does not tell");
  }

  void skip(std::int64_t offset, const std::string& reason, bool is_scan) {
    const LogProblem problem{{{path_, {}, offset}, reason}, is_scan};
    if (options_.strict) throw DataError(problem.location, reason);
    tally_.add(problem);
    if (options_.on_problem) options_.on_problem(problem);
  }

  void read_object() {
    std::optional<RawlogObject> object;
    try {
      object = objects_.next();
    } catch (const ReadingStopped&) {
      at_end_ = true;
      return;
    } catch (const DataError&) {
      failure_ = std::current_exception();
    }
    if (object) {
      take(std::move(*object));
      return;
    }
    at_end_ = true;
    order_.close();
    order_stamps_.close();
  }

  void take(RawlogObject&& object) {
    if (auto* scan = std::get_if<RawlogScan>(&object.content)) {
      take_scan(std::move(*scan), object.offset);
    } else if (const auto* odometry = std::get_if<RawlogOdometry>(&object.content)) {
      take_odometry(*odometry, object.offset);
    } else if (const auto* motion = std::get_if<RawlogMotion>(&object.content)) {
      take_motion(*motion, object.offset);
    } else if (const auto* other = std::get_if<RawlogOther>(&object.content)) {
      if (unread_.size() < 50 || unread_.count(other->name) > 0) ++unread_[other->name];
    } else if (const auto* broken = std::get_if<RawlogBroken>(&object.content)) {
      skip(object.offset, broken->reason, broken->is_scan);
    }
  }

  void push(OrderedRecord record) {
    if (by_order_) {
      order_stamps_.push(std::move(record));
    } else {
      order_.push(std::move(record));
    }
  }

  void take_scan(RawlogScan&& scan, std::int64_t offset) {
    if (!scan.stamp && !by_order_) {
      skip(offset, "the scan has no stamp", true);
      return;
    }
    const auto lidar = lidars_.of(scan);
    if (!lidar) {
      skip(offset, fmt::format("a scan of more than {} lasers", kRawlogLidars), true);
      return;
    }
    const PlanarMount mount = planar(scan.robot_T_lidar);
    tilt_rad_.resize(std::max(tilt_rad_.size(), static_cast<std::size_t>(*lidar) + 1));
    double& tilt_rad = tilt_rad_[static_cast<std::size_t>(*lidar)];
    tilt_rad = std::max({tilt_rad, mount.tilt_rad, std::abs(scan.pitch_change_rad)});
    const Pose2& place = mount.robot_T_lidar;
    if (std::max(std::abs(place.x), std::abs(place.y)) > kFarthestMountM) {
      skip(offset, "the laser sits more than 100 m from its robot", true);
      return;
    }
    const Stamp stamp = scan.stamp.value_or(Stamp{});
    if (motion_waits_) push({OdometryPose{stamp, odom_T_robot_}, offset});
    motion_waits_ = false;
    push({to_laser_scan(std::move(scan), stamp, *lidar, mount), offset});
  }

  void take_odometry(const RawlogOdometry& odometry, std::int64_t offset) {
    if (!odometry_label_) odometry_label_ = odometry.label;
    if (odometry.label != *odometry_label_) {
      ++unread_["CObservationOdometry of another label"];
    } else if (!odometry.stamp && !by_order_) {
      skip(offset, "the odometry has no stamp", false);
    } else {
      push({OdometryPose{odometry.stamp.value_or(Stamp{}), odometry.odom_T_robot}, offset});
    }
  }

  /// Increments add up. One without a stamp leads to the scan after it.
  void take_motion(const RawlogMotion& motion, std::int64_t offset) {
    if (survey_.has_observed_odometry) {
      ++unread_["CActionRobotMovement2D beside observed odometry"];
      return;
    }
    if (!motion.is_odometry) ++estimates_;
    const Pose2 moved = odom_T_robot_ * motion.increment;
    if (std::max(std::abs(moved.x), std::abs(moved.y)) > kFarthestPoseM) {
      skip(offset, "the motions lead more than 10,000 km away", false);
      return;
    }
    odom_T_robot_ = moved;
    if (motion.stamp || by_order_) {
      push({OdometryPose{motion.stamp.value_or(Stamp{}), odom_T_robot_}, offset});
    } else {
      motion_waits_ = true;
    }
  }

  std::string path_;
  LogOptions options_;
  Survey survey_;
  RawlogObjects objects_;
  bool by_order_;
  StampOrder order_;
  OrderStamps order_stamps_;
  Lidars lidars_{};
  std::vector<double> tilt_rad_{};  ///< the most of each laser
  std::optional<std::string> odometry_label_{};
  Pose2 odom_T_robot_{};  ///< the sum of the motions
  bool motion_waits_ = false;
  std::int64_t estimates_ = 0;
  std::map<std::string, std::int64_t> unread_{};
  SkipTally tally_{};
  std::exception_ptr failure_{};
  bool at_end_ = false;
};

}  // namespace

std::unique_ptr<LogReader> open_rawlog(const ReadableBytes& log, const LogOptions& options) {
  return std::make_unique<RawlogReader>(log, options);
}

std::unique_ptr<LogReader> read_rawlog(std::string_view bytes, const LogOptions& options,
                                       const std::string& name) {
  return open_rawlog(readable_memory(bytes, name), options);
}

}  // namespace loopstone
