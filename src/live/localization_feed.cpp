#include "loopstone/live/localization_feed.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "live/pace_meter.hpp"
#include "live/timer.hpp"
#include "live/waiting_scans.hpp"
#include "live/warning_list.hpp"
#include "loopstone/base/thinned.hpp"
#include "loopstone/geometry/covariance.hpp"
#include "loopstone/report/peak_memory.hpp"

namespace loopstone {
namespace {

/// More arrows than these show no more.
constexpr std::size_t kMostParticles = 2000;
/// The path is shown by a pose each so many metres, of the last so many.
constexpr double kNodeStepM = 0.2;
constexpr std::size_t kMostNodes = 20000;

}  // namespace

class LocalizationFeed::Impl {
 public:
  Impl(ViewBoard& board, RobotModel robot, const LocalizationMap& map, const ViewPeriods& periods)
      : board_(board),
        robot_(std::move(robot)),
        robot_timer_(periods.robot_s),
        status_timer_(periods.status_s),
        belief_timer_(periods.map_s) {
    const Grid<std::int8_t>& cells = map.occupancy();
    board_.begin_anew({}, cells.frame().resolution);
    board_.replace_tiles({}, cells);
    board_.show_grid({}, cells);
  }

  void add(const SensorMessage& message) { scans_.add(message, robot_); }
  void add(const LocalizationEstimate& estimate, const Localizer& localizer);
  void add_warning(const std::string& text) {
    const Stamp now = last_ ? last_->stamp : Stamp{};
    warnings_.add(last_ ? std::optional(now) : std::nullopt, text);
    board_.show_warnings(now, warnings_.shown());
  }
  void catch_up(const Localizer& localizer);

 private:
  void show_robot();
  void show_status();
  void show_belief(const Localizer& localizer);

  ViewBoard& board_;
  RobotModel robot_;
  Timer robot_timer_;
  Timer status_timer_;
  Timer belief_timer_;
  std::optional<LocalizationEstimate> last_{};
  struct Waits {
    bool robot = false;
    bool status = false;
    bool belief = false;
  } waits_{};  ///< what of the last estimate is still to be shown
  WaitingScans scans_{};
  std::vector<ViewNode> nodes_{};
  WarningList warnings_{};
  std::int64_t estimates_ = 0;
  PaceMeter pace_{};
};

void LocalizationFeed::Impl::add(const LocalizationEstimate& estimate, const Localizer& localizer) {
  ++estimates_;
  last_ = estimate;
  const Pose2& pose = estimate.map_T_robot;
  if (nodes_.empty() ||
      (pose.translation() - nodes_.back().map_T_robot.translation()).norm() > kNodeStepM) {
    if (nodes_.size() >= kMostNodes) nodes_.erase(nodes_.begin(), nodes_.begin() + kMostNodes / 2);
    nodes_.push_back({.stamp = estimate.stamp,
                      .map_T_robot = pose,
                      .sigma_m = largest_sigma(estimate.covariance.topLeftCorner<2, 2>())});
  }
  waits_ = {.robot = true, .status = true, .belief = true};
  catch_up(localizer);
}

void LocalizationFeed::Impl::catch_up(const Localizer& localizer) {
  if (!last_) return;
  if (!board_.is_watched()) {
    scans_.drop_before(last_->stamp);
    return;
  }
  if (waits_.robot && robot_timer_.is_due()) {
    show_robot();
    waits_.robot = false;
  }
  if (waits_.belief && belief_timer_.is_due()) {
    show_belief(localizer);
    waits_.belief = false;
  }
  if (waits_.status && status_timer_.is_due()) {
    show_status();
    waits_.status = false;
  }
  scans_.drop_before(last_->stamp);
}

void LocalizationFeed::Impl::show_robot() {
  board_.show_robot(last_->stamp, last_->map_T_robot, last_->covariance, scans_.at(last_->stamp),
                    robot_);
}

void LocalizationFeed::Impl::show_belief(const Localizer& localizer) {
  board_.show_particles(last_->stamp, thinned(localizer.particles(), kMostParticles));
  board_.show_nodes(last_->stamp, nodes_);
}

void LocalizationFeed::Impl::show_status() {
  constexpr double kBytesPerMb = 1e6;
  const LocalizationEstimate& now = *last_;
  ViewStatus status{.stamp = now.stamp,
                    .status = std::string(to_string(now.state)),
                    .scans = estimates_,
                    .travelled_m = now.travelled_m,
                    .map_m2 = board_.known_area_m2(),
                    .realtime = pace_.at(now.stamp),
                    .memory_mb = static_cast<double>(memory_bytes()) / kBytesPerMb};
  status.figures["probability"] = now.probability;
  status.figures["sigma_m"] = largest_sigma(now.covariance.topLeftCorner<2, 2>());
  status.figures["explained"] = now.evidence.explained;
  status.figures["particles"] = now.particles;
  board_.show_status(status);
}

LocalizationFeed::LocalizationFeed(ViewBoard& board, const RobotModel& robot,
                                   const LocalizationMap& map, const ViewPeriods& periods)
    : impl_(std::make_unique<Impl>(board, robot, map, periods)) {}
LocalizationFeed::~LocalizationFeed() = default;
void LocalizationFeed::add(const SensorMessage& message) { impl_->add(message); }
void LocalizationFeed::add(const LocalizationEstimate& estimate, const Localizer& localizer) {
  impl_->add(estimate, localizer);
}
void LocalizationFeed::add_warning(const std::string& text) { impl_->add_warning(text); }
void LocalizationFeed::catch_up(const Localizer& localizer) { impl_->catch_up(localizer); }

}  // namespace loopstone
