#include "loopstone/live/folder_view.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "live/pace_meter.hpp"
#include "live/snapshot_contents.hpp"
#include "live/timer.hpp"
#include "loopstone/base/thinned.hpp"
#include "loopstone/geometry/covariance.hpp"
#include "loopstone/report/peak_memory.hpp"
#include "loopstone/sensor/mounted_scan.hpp"
#include "loopstone/slam/calibration.hpp"
#include "loopstone/slam/robot_correction.hpp"
#include "loopstone/slam/tracking_status.hpp"

namespace loopstone {
namespace {

using Json = nlohmann::ordered_json;

/// A path is shown by poses that are so far apart, and by those of closures.
constexpr double kNodeStepM = 0.25;
constexpr double kNodeStepRad = 0.25;
constexpr double kRobotPeriodS = 0.033;
constexpr double kStatusPeriodS = 0.1;

/// A time during which the laser did not hold the pose, after the beginning of the path.
struct Gap {
  double from_s = 0.0;
  double to_s = 0.0;
  bool is_lost = false;
};

std::vector<Gap> gaps_in(const Json& summary) {
  std::vector<Gap> gaps;
  const auto list = summary.find("path_breaks");
  if (list == summary.end() || !list->is_array()) return gaps;
  for (const Json& one : *list) {
    if (!one.is_object()) continue;
    const auto from = one.find("from_s");
    const auto to = one.find("to_s");
    if (from == one.end() || to == one.end() || !from->is_number() || !to->is_number()) continue;
    gaps.push_back({from->get<double>(), to->get<double>(),
                    one.value("bridged_by", Json("")) == Json("nothing")});
  }
  return gaps;
}

/// What the drive told of the laser, as far as the map was made with it.
Calibration used_calibration(const Json& summary) {
  Calibration used;
  const auto at = [&](const char* pointer) {
    const Json::json_pointer place(pointer);
    return summary.contains(place) ? summary[place] : Json();
  };
  const auto is_so = [&](const char* pointer) { return at(pointer) == Json(true); };
  const auto take = [&](const char* pointer, CalibratedValue& value) {
    const Json told = at(pointer);
    if (told.is_number()) value.value = told.get<double>();
    return told.is_number();
  };
  constexpr double kMostLasers = 64.0;
  const Json index = at("/calibration/lidar/index");
  if (index.is_number())
    used.lidar = static_cast<int>(std::clamp(index.get<double>(), 0.0, kMostLasers));
  if (is_so("/calibration/beams/corrected")) {
    used.laser_is_mirrored = is_so("/calibration/beams/laser_is_mirrored");
    used.sweep_is_off = is_so("/calibration/beams/sweep_is_off") &&
                        take("/calibration/beams/sweep_s/value", used.sweep_s);
  }
  if (!is_so("/calibration/mount_corrected")) return used;
  used.yaw_is_off = is_so("/calibration/lidar/yaw_is_off") &&
                    take("/calibration/lidar/yaw_rad/value", used.lidar_yaw_rad);
  used.place_is_off = is_so("/calibration/lidar/place_is_off") &&
                      take("/calibration/lidar/x_m/value", used.lidar_x_m) &&
                      take("/calibration/lidar/y_m/value", used.lidar_y_m);
  return used;
}

/// Shows each pose once, and not too often.
class Showing {
 public:
  explicit Showing(double period_s) : timer_(period_s) {}
  [[nodiscard]] bool is_due(std::size_t pose) {
    if (shown_ == pose || !timer_.is_due()) return false;
    shown_ = pose;
    return true;
  }

 private:
  Timer timer_;
  std::optional<std::size_t> shown_{};
};

ViewLayer layer_of(const PlacedPicture& picture) {
  return {picture.corner, picture.resolution_m, picture.png};
}

}  // namespace

class FolderView::Impl {
 public:
  Impl(MapFolder folder, const RobotModel& robot, ViewBoard& board)
      : folder_(std::move(folder)), robot_(robot), board_(board) {
    summary_ = Json::parse(folder_.summary_json, nullptr, /*allow_exceptions=*/false);
    if (!summary_.is_object()) summary_ = Json::object();
    gaps_ = gaps_in(summary_);
    correct_robot();
    for (const StampedClosure& one : folder_.closures) {
      for (const auto& stamp : {one.from, one.to}) {
        if (stamp) closure_stamps_.insert(*stamp);
      }
    }
    choose_nodes();
    measure_path();
  }

  [[nodiscard]] const std::vector<StampedPose2>& poses() const {
    return folder_.trajectory.poses();
  }
  void add_scan(const LaserScan& scan, std::size_t most_bytes);
  [[nodiscard]] std::size_t scans() const { return scans_.size(); }
  void show_map();
  void play(ReplayClock& clock, const std::function<bool()>& go_on);

 private:
  void correct_robot();
  void correct(Pose2& robot_T_lidar);
  void choose_nodes();
  void measure_path();
  [[nodiscard]] std::size_t node_at(Stamp stamp) const;
  [[nodiscard]] std::vector<ViewClosure> closures() const;
  [[nodiscard]] std::shared_ptr<const MappedScan> scan_at(const std::optional<Stamp>& stamp) const;
  void show_warnings(Stamp stamp);
  void show_robot(std::size_t index);
  void show_status(std::size_t index);
  [[nodiscard]] std::string status_at(Stamp stamp) const;

  MapFolder folder_;
  RobotModel robot_;
  ViewBoard& board_;
  Json summary_{};
  Calibration used_{};
  std::vector<Gap> gaps_{};
  std::set<Stamp> closure_stamps_{};
  std::vector<std::size_t> nodes_{};   ///< which poses are nodes
  std::vector<double> travelled_m_{};  ///< up to each pose
  std::map<Stamp, std::shared_ptr<const MappedScan>> scans_{};
  std::size_t scan_bytes_ = 0;
  PaceMeter pace_{};
};

void FolderView::Impl::correct_robot() {
  used_ = used_calibration(summary_);
  robot_ = corrected_robot(robot_, used_);
  const auto index = static_cast<std::size_t>(used_.lidar);
  while (robot_.lidars.size() <= index) robot_.lidars.push_back({.robot_T_lidar = Pose2{}});
  correct(robot_.lidars[index].robot_T_lidar);
}

void FolderView::Impl::correct(Pose2& robot_T_lidar) {
  used_.robot_T_lidar_given = robot_T_lidar;
  robot_T_lidar = used_.robot_T_lidar();
}

void FolderView::Impl::choose_nodes() {
  for (std::size_t i = 0; i < poses().size(); ++i) {
    const StampedPose2& pose = poses()[i];
    bool is_node =
        nodes_.empty() || i + 1 == poses().size() || closure_stamps_.contains(pose.stamp);
    if (!is_node) {
      const Pose2 moved = poses()[nodes_.back()].pose.inverse() * pose.pose;
      is_node = moved.translation().norm() >= kNodeStepM || std::abs(moved.yaw) >= kNodeStepRad;
    }
    if (is_node) nodes_.push_back(i);
  }
}

void FolderView::Impl::measure_path() {
  double sum_m = 0.0;
  for (std::size_t i = 0; i < poses().size(); ++i) {
    if (i > 0) sum_m += (poses()[i].pose.translation() - poses()[i - 1].pose.translation()).norm();
    travelled_m_.push_back(sum_m);
  }
}

void FolderView::Impl::add_scan(const LaserScan& scan, std::size_t most_bytes) {
  const auto pose = std::ranges::lower_bound(poses(), scan.stamp, {}, &StampedPose2::stamp);
  if (pose == poses().end() || pose->stamp != scan.stamp) return;
  const std::size_t bytes = sizeof(MappedScan) + scan.ranges_m.size() * sizeof(float);
  if (!closure_stamps_.contains(scan.stamp) && scan_bytes_ + bytes > most_bytes) return;
  MappedScan mapped{.scan = as_mounted(scan, robot_).value_or(scan),
                    .index = static_cast<std::size_t>(pose - poses().begin())};
  mapped.scan.intensities.clear();
  if (mapped.scan.robot_T_lidar && scan.lidar == used_.lidar) correct(*mapped.scan.robot_T_lidar);
  mapped.robot_T_lidar = mount_of(mapped.scan, robot_);
  if (scans_.try_emplace(scan.stamp, std::make_shared<const MappedScan>(std::move(mapped))).second)
    scan_bytes_ += bytes;
}

std::shared_ptr<const MappedScan> FolderView::Impl::scan_at(
    const std::optional<Stamp>& stamp) const {
  if (!stamp) return nullptr;
  const auto found = scans_.find(*stamp);
  return found == scans_.end() ? nullptr : found->second;
}

std::size_t FolderView::Impl::node_at(Stamp stamp) const {
  const auto after =
      std::ranges::lower_bound(nodes_, stamp, {}, [&](std::size_t i) { return poses()[i].stamp; });
  const auto place = static_cast<std::size_t>(after - nodes_.begin());
  return std::min(place, nodes_.size() - 1);
}

std::vector<ViewClosure> FolderView::Impl::closures() const {
  std::vector<ViewClosure> all;
  for (const StampedClosure& one : folder_.closures) {
    ViewClosure shown{.closure = one.closure};
    if (one.from && one.to) {
      shown.from = *one.from;
      shown.to = *one.to;
      shown.from_node = node_at(*one.from);
      shown.to_node = node_at(*one.to);
      const Pose2 map_T_from = folder_.trajectory.at_clamped(*one.from).value_or(Pose2{});
      const Pose2 map_T_to = folder_.trajectory.at_clamped(*one.to).value_or(Pose2{});
      shown.from_T_to = map_T_from.inverse() * map_T_to;
      shown.from_scan = scan_at(one.from);
      shown.to_scan = scan_at(one.to);
    }
    all.push_back(std::move(shown));
  }
  return all;
}

void FolderView::Impl::show_map() {
  const Stamp stamp = poses().back().stamp;
  std::vector<ViewNode> nodes;
  for (const std::size_t i : nodes_) {
    nodes.push_back({.stamp = poses()[i].stamp,
                     .map_T_robot = poses()[i].pose,
                     .sigma_m = folder_.covariances.empty()
                                    ? 0.0
                                    : largest_sigma(folder_.covariances[i].topLeftCorner<2, 2>())});
  }
  board_.show_nodes(stamp, std::move(nodes));
  board_.show_submaps(stamp, {});
  board_.show_closures(stamp, closures());
  if (folder_.cells) {
    board_.replace_tiles(stamp, *folder_.cells);
    board_.show_grid(stamp, *folder_.cells);
  }
  board_.show_path(stamp, thinned(poses(), kMostPathPoses));
  board_.show_graph(stamp);
  const auto quality = summary_.find("quality");
  board_.show_verdict(stamp, verdict_of(quality == summary_.end() ? Json() : *quality,
                                        summary_.value("complete", Json(false)) == Json(true)));
  show_warnings(stamp);
  if (folder_.quality) board_.show_quality(stamp, layer_of(*folder_.quality));
  if (folder_.texture) board_.show_texture(stamp, layer_of(*folder_.texture));
}

void FolderView::Impl::show_warnings(Stamp stamp) {
  std::vector<ViewWarning> warnings;
  if (const auto list = summary_.find("warnings"); list != summary_.end() && list->is_array()) {
    for (const Json& one : *list) {
      if (one.is_string()) warnings.push_back({std::nullopt, one.get<std::string>()});
    }
  }
  for (const std::string& reason : folder_.left_out)
    warnings.push_back({std::nullopt, "not shown: " + reason});
  board_.show_warnings(stamp, warnings);
}

void FolderView::Impl::show_robot(std::size_t index) {
  const StampedPose2& pose = poses()[index];
  const auto scan = scan_at(pose.stamp);
  board_.show_robot(
      pose.stamp, pose.pose,
      folder_.covariances.empty() ? Eigen::Matrix3d::Zero().eval() : folder_.covariances[index],
      scan ? &scan->scan : nullptr, robot_);
}

std::string FolderView::Impl::status_at(Stamp stamp) const {
  const double time_s = (stamp - poses().front().stamp).seconds();
  for (const Gap& gap : gaps_) {
    if (time_s > gap.from_s && time_s < gap.to_s)
      return std::string(to_string(gap.is_lost ? TrackingStatus::kLost : TrackingStatus::kBridged));
  }
  return std::string(to_string(TrackingStatus::kTracked));
}

void FolderView::Impl::show_status(std::size_t index) {
  constexpr double kBytesPerMb = 1e6;
  const auto count = [&](ClosureState state) {
    return static_cast<std::size_t>(std::ranges::count_if(
        folder_.closures, [&](const auto& one) { return one.closure.state == state; }));
  };
  ViewStatus status{.stamp = poses()[index].stamp,
                    .status = status_at(poses()[index].stamp),
                    .scans = static_cast<std::int64_t>(index) + 1,
                    .travelled_m = travelled_m_[index],
                    .closures = count(ClosureState::kStanding),
                    .rejected = count(ClosureState::kRejected) + count(ClosureState::kRevoked),
                    .map_m2 = board_.known_area_m2(),
                    .realtime = pace_.at(poses()[index].stamp),
                    .memory_mb = static_cast<double>(memory_bytes()) / kBytesPerMb};
  if (const auto submaps = summary_.find("submaps");
      submaps != summary_.end() && submaps->is_number_unsigned())
    status.submaps = submaps->get<std::size_t>();
  if (!folder_.covariances.empty())
    status.figures["sigma_m"] = largest_sigma(folder_.covariances[index].topLeftCorner<2, 2>());
  board_.show_status(status);
}

void FolderView::Impl::play(ReplayClock& clock, const std::function<bool()>& go_on) {
  show_map();
  std::size_t next = 0;
  // Asked while nothing is due, too, so that a robot that stops is shown where it stopped.
  Showing robot(kRobotPeriodS);
  Showing status(kStatusPeriodS);
  const auto show_last = [&] {
    if (next == 0) return;
    if (robot.is_due(next - 1)) show_robot(next - 1);
    if (status.is_due(next - 1)) show_status(next - 1);
  };
  const auto goes_on = [&] {
    show_last();
    return go_on();
  };
  while (true) {
    const bool is_over = next == poses().size();
    const auto turn =
        is_over ? clock.wait_at_end(goes_on) : clock.wait_for(poses()[next].stamp, goes_on);
    if (turn == ReplayClock::Turn::kStopped) return;
    if (turn == ReplayClock::Turn::kSeekBack) {
      const Stamp goal = clock.goal().value_or(poses().front().stamp);
      const auto at = std::ranges::lower_bound(poses(), goal, {}, &StampedPose2::stamp);
      next = std::min(static_cast<std::size_t>(at - poses().begin()), poses().size() - 1);
      continue;
    }
    ++next;
    show_last();
  }
}

FolderView::FolderView(MapFolder folder, const RobotModel& robot, ViewBoard& board)
    : impl_(std::make_unique<Impl>(std::move(folder), robot, board)) {}
FolderView::~FolderView() = default;

PlaybackRange FolderView::range() const {
  return {impl_->poses().front().stamp, impl_->poses().back().stamp};
}
void FolderView::add_scan(const LaserScan& scan, std::size_t most_bytes) {
  impl_->add_scan(scan, most_bytes);
}
std::size_t FolderView::scans() const { return impl_->scans(); }
void FolderView::play(ReplayClock& clock, const std::function<bool()>& go_on) {
  impl_->play(clock, go_on);
}

}  // namespace loopstone
