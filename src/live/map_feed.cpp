#include "loopstone/live/map_feed.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <mutex>
#include <thread>
#include <utility>
#include <variant>

#include "live/pace_meter.hpp"
#include "live/snapshot_contents.hpp"
#include "live/timer.hpp"
#include "live/waiting_scans.hpp"
#include "live/warning_list.hpp"
#include "loopstone/base/thinned.hpp"
#include "loopstone/geometry/covariance.hpp"
#include "loopstone/report/peak_memory.hpp"
#include "loopstone/slam/live_map.hpp"
#include "report/live_grid.hpp"
#include "report/map_messages.hpp"

namespace loopstone {
namespace {

/// A robot that stands does not travel, whatever its pose does.
constexpr double kTravelStepM = 0.02;
/// Of a map, and of a graph's markers, that are sent whole, again and again.
constexpr double kCellsPerS = 4e6;
constexpr double kMarkerPointsPerS = 2e4;
/// Of the time that passes, what drawing takes at most: the rest is for the mapper. A robot's own
/// pace is far from that; a recording that is mapped in seconds is not.
constexpr double kDrawingShare = 0.1;

/// What the drawing thread is given.
struct Drawing {
  Stamp stamp{};
  MapSnapshot snapshot{};
  StampedPose2 robot{};
};

/// Draws snapshots, at leisure: of those that come meanwhile only the last one.
class Drawer {
 public:
  Drawer(ViewBoard& board, const OccupancyOptions& map, double footprint_radius_m,
         const ViewPeriods& periods)
      : board_(board),
        map_(map),
        footprint_radius_m_(footprint_radius_m),
        period_s_(std::max(periods.map_s, 0.005)),
        standard_s_(periods.standard_s),
        closures_timer_(periods.closures_s),
        standard_timer_(periods.standard_s) {
    begin_anew();
    thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
  }

  /// \param sigmas  of key scans that came since the drawing before
  void draw(Drawing drawing, NodeSigmas sigmas) {
    const std::scoped_lock lock(mutex_);
    next_ = std::move(drawing);
    next_sigmas_.merge(sigmas);
    changed_.notify_all();
  }
  void flush() {
    std::unique_lock lock(mutex_);
    is_hurried_ = true;
    changed_.notify_all();
    changed_.wait(lock, [&] { return !next_ && !is_busy_ && is_done_; });
    is_hurried_ = false;
  }
  /// Nothing is drawn when it returns, nor later. What waited is given up.
  void drop() {
    std::unique_lock lock(mutex_);
    next_.reset();
    is_done_ = true;
    changed_.wait(lock, [&] { return !is_busy_; });
    is_done_ = true;
    is_standard_old_ = false;
  }

  // While nothing is drawn:

  void begin_anew() {
    live_.emplace(map_, footprint_radius_m_);
    grid_.emplace(map_.most_cells);
    shown_ = 0;
    outlines_.clear();
    sigmas_.clear();
    next_sigmas_.clear();
    current_ = {};
    is_standard_old_ = false;
    closures_timer_.begin_anew();
    standard_timer_.begin_anew();
  }
  [[nodiscard]] const Drawing& last() const { return current_; }
  [[nodiscard]] std::vector<ViewSubmap> submaps_of(const MapSnapshot& snapshot) {
    return outlines_.submaps_of(snapshot);
  }

 private:
  void run(const std::stop_token& stop) {
    std::unique_lock lock(mutex_);
    const std::stop_callback wake(stop, [this] { changed_.notify_all(); });
    while (!stop.stop_requested()) {
      wait(lock, stop);
      changed_.wait_until(lock, rest_until_, [&] { return stop.stop_requested() || is_hurried_; });
      if (stop.stop_requested()) return;
      if (!next_ && is_done_ && !(is_standard_old_ && board_.is_standard_wanted())) continue;
      if (next_) current_ = *std::exchange(next_, std::nullopt);
      sigmas_.merge(std::exchange(next_sigmas_, {}));
      is_busy_ = true;
      lock.unlock();
      const Clock::time_point begin = Clock::now();
      const bool is_done = show();
      const Clock::duration took = Clock::now() - begin;
      lock.lock();
      rest_until_ = begin + std::chrono::duration_cast<Clock::duration>(took / kDrawingShare);
      is_busy_ = false;
      is_done_ = is_done;
      changed_.notify_all();
    }
  }

  /// Until there is something to draw, or it is time to look again.
  void wait(std::unique_lock<std::mutex>& lock, const std::stop_token& stop) {
    const auto has_work = [&] { return stop.stop_requested() || next_.has_value(); };
    if (is_done_ && !is_standard_old_) return changed_.wait(lock, has_work);
    const double period_s = is_done_ ? std::max(standard_s_, period_s_) : period_s_;
    (void)changed_.wait_for(lock, std::chrono::duration<double>(period_s), has_work);
  }

  /// False while something of the present snapshot has still to be shown.
  bool show() {
    const Stamp stamp = current_.stamp;
    live_->refresh(current_.snapshot);
    board_.change_tiles(stamp, live_->tiles_since(shown_));
    shown_ = live_->revision();
    board_.show_nodes(stamp, nodes_of(current_.snapshot, sigmas_));
    const bool closures = closures_timer_.is_due();
    if (closures) show_closures(stamp);
    // Of no use to our own page, and the larger the longer a drive is.
    is_standard_old_ = !board_.is_standard_wanted();
    if (is_standard_old_) return live_->is_current() && closures;
    const bool standard = standard_timer_.is_due();
    if (standard) show_standard(stamp);
    return live_->is_current() && closures && standard;
  }

  void show_closures(Stamp stamp) {
    board_.show_closures(stamp, closures_of(current_.snapshot));
    board_.show_submaps(stamp, outlines_.submaps_of(current_.snapshot));
  }

  void show_standard(Stamp stamp) {
    if (grid_->update(*live_)) board_.show_grid(stamp, grid_->cells());
    // What is large is sent less often.
    const auto cells = static_cast<double>(grid_->cells().cells().size());
    const auto points = static_cast<double>(current_.snapshot.submaps.size() +
                                            2 * current_.snapshot.closures.size());
    standard_timer_.set_period(
        std::max({standard_s_, cells / kCellsPerS, points / kMarkerPointsPerS}));
    std::vector<StampedPose2> path;
    for (const KeyScanSnapshot& key : current_.snapshot.key_scans())
      path.push_back({key.stamp, key.map_T_robot});
    path = thinned(path, kMostPathPoses);
    path.push_back(current_.robot);
    board_.show_path(stamp, path);
    board_.show_graph(stamp);
  }

  using Clock = std::chrono::steady_clock;

  ViewBoard& board_;
  OccupancyOptions map_;
  double footprint_radius_m_;
  double period_s_;
  double standard_s_;
  Timer closures_timer_;
  Timer standard_timer_;

  // Of whoever draws.
  std::optional<LiveMap> live_{};
  std::optional<LiveGrid> grid_{};
  std::int64_t shown_ = 0;
  SubmapOutlines outlines_{};
  NodeSigmas sigmas_{};
  Drawing current_{};
  bool is_standard_old_ = false;  ///< /map, /path and /graph are, since nobody takes them

  std::mutex mutex_{};
  std::condition_variable changed_{};
  std::optional<Drawing> next_{};
  NodeSigmas next_sigmas_{};
  Clock::time_point rest_until_{};
  bool is_hurried_ = false;  ///< somebody waits for it
  bool is_busy_ = false;
  bool is_done_ = true;
  std::jthread thread_{};  ///< last, so that it ends first
};

}  // namespace

class MapFeed::Impl {
 public:
  Impl(ViewBoard& board, const RobotModel& robot, const OccupancyOptions& map,
       const ViewPeriods& periods)
      : board_(board),
        robot_(robot),
        resolution_m_(map.resolution_m),
        drawer_(board, map, robot.footprint_radius_m, periods),
        robot_timer_(periods.robot_s),
        status_timer_(periods.status_s),
        map_timer_(periods.map_s) {
    board_.begin_anew({}, resolution_m_);
  }

  void begin_anew(const RobotModel& robot);
  void add(const SensorMessage& message) { scans_.add(message, robot_); }
  void add(const MapUpdate& update, const Mapper& mapper);
  void catch_up(const Mapper& mapper);
  void end(const Mapper& mapper) {
    final_ = mapper.snapshot();
    if (last_ && board_.is_watched()) draw(*last_, mapper);
  }
  void finish(const MapResult& result);
  void add_warning(const std::string& text) {
    const Stamp now = last_ ? last_->stamp : Stamp{};
    warnings_.add(last_ ? std::optional(now) : std::nullopt, text);
    board_.show_warnings(now, warnings_.shown());
  }
  void note_front_end(double seconds) { front_end_s_ = std::max(front_end_s_, seconds); }
  void flush() { drawer_.flush(); }

 private:
  void show_robot(const MapUpdate& update);
  void show_status(Stamp stamp);
  void draw(const MapUpdate& update, const Mapper& mapper);
  void note(const MapUpdate& update);

  ViewBoard& board_;
  RobotModel robot_;
  double resolution_m_;
  Drawer drawer_;
  Timer robot_timer_;
  Timer status_timer_;
  Timer map_timer_;

  std::optional<MapUpdate> last_{};
  struct Waits {
    bool robot = false;
    bool map = false;
    bool status = false;
  } waits_{};  ///< what of the last update is still to be shown
  std::optional<MapSnapshot> final_{};
  WaitingScans scans_{};  ///< whose updates are still to come
  NodeSigmas sigmas_{};   ///< since the last drawing
  WarningList warnings_{};
  ViewStatus status_{};
  std::optional<Pose2> travelled_to_{};  ///< odom frame
  double front_end_s_ = 0.0;             ///< the longest since the last status
  PaceMeter pace_{};
};

void MapFeed::Impl::begin_anew(const RobotModel& robot) {
  drawer_.drop();
  drawer_.begin_anew();
  robot_ = robot;
  last_.reset();
  final_.reset();
  scans_.clear();
  sigmas_.clear();
  warnings_.clear();
  status_ = {};
  travelled_to_.reset();
  pace_ = {};
  for (Timer* timer : {&robot_timer_, &status_timer_, &map_timer_}) timer->begin_anew();
  board_.begin_anew({}, resolution_m_);
}

void MapFeed::Impl::add(const MapUpdate& update, const Mapper& mapper) {
  note(update);
  last_ = update;
  waits_ = {.robot = true, .map = true, .status = true};
  catch_up(mapper);
}

void MapFeed::Impl::catch_up(const Mapper& mapper) {
  if (!last_) return;
  if (!board_.is_watched()) {
    // Who comes later is shown what waits.
    scans_.drop_before(last_->stamp);
    return;
  }
  if (waits_.robot && robot_timer_.is_due()) {
    show_robot(*last_);
    waits_.robot = false;
  }
  if (waits_.map && map_timer_.is_due()) {
    draw(*last_, mapper);
    waits_.map = false;
  }
  if (waits_.status && status_timer_.is_due()) {
    status_.status = to_string(last_->status);
    status_.figures["sigma_m"] = largest_sigma(last_->covariance.topLeftCorner<2, 2>());
    show_status(last_->stamp);
    waits_.status = false;
  }
  scans_.drop_before(last_->stamp);
}

void MapFeed::Impl::note(const MapUpdate& update) {
  ++status_.scans;
  if (!travelled_to_) travelled_to_ = update.odom_T_robot;
  const double step_m = (update.odom_T_robot.translation() - travelled_to_->translation()).norm();
  if (step_m >= kTravelStepM) {
    status_.travelled_m += step_m;
    travelled_to_ = update.odom_T_robot;
  }
  if (update.key_scan)
    sigmas_[update.stamp.nanoseconds] = largest_sigma(update.covariance.topLeftCorner<2, 2>());
  bool is_news = false;
  for (const MapEvent& event : update.events) {
    const auto told = diagnostic_of(event);
    if (!told || told->level == msg::DiagnosticStatus::kOk) continue;
    warnings_.add(update.stamp, told->name + ": " + told->message);
    is_news = true;
  }
  if (is_news) board_.show_warnings(update.stamp, warnings_.shown());
}

void MapFeed::Impl::show_robot(const MapUpdate& update) {
  board_.show_robot(update.stamp, update.map_T_robot(), update.covariance, scans_.at(update.stamp),
                    robot_);
}

void MapFeed::Impl::draw(const MapUpdate& update, const Mapper& mapper) {
  Drawing drawing{.stamp = update.stamp,
                  .snapshot = mapper.snapshot(),
                  .robot = {update.stamp, update.map_T_robot()}};
  const auto& closures = drawing.snapshot.closures;
  const auto stand =
      static_cast<std::size_t>(std::ranges::count_if(closures, &LoopClosure::stands));
  const auto wait = static_cast<std::size_t>(
      std::ranges::count(closures, ClosureState::kWaiting, &LoopClosure::state));
  status_.submaps = drawing.snapshot.submaps.size();
  status_.closures = stand;
  status_.rejected = closures.size() - stand - wait;
  drawer_.draw(std::move(drawing), std::exchange(sigmas_, {}));
}

void MapFeed::Impl::show_status(Stamp stamp) {
  constexpr double kBytesPerMb = 1e6;
  status_.stamp = stamp;
  status_.map_m2 = board_.known_area_m2();
  status_.realtime = pace_.at(stamp);
  status_.memory_mb = static_cast<double>(memory_bytes()) / kBytesPerMb;
  status_.figures["front_end_ms"] = 1e3 * std::exchange(front_end_s_, 0.0);
  board_.show_status(status_);
}

void MapFeed::Impl::finish(const MapResult& result) {
  drawer_.drop();
  const Stamp stamp = result.trajectory.empty() ? Stamp{} : result.trajectory.back().stamp;
  const MapSnapshot last = final_ ? *std::exchange(final_, std::nullopt) : drawer_.last().snapshot;
  board_.show_submaps(stamp, moved_to(result, last, drawer_.submaps_of(last)));
  (void)show_result(board_, stamp, result, last);
  for (const std::string& warning : result.warnings) warnings_.add({}, warning);
  board_.show_warnings(stamp, warnings_.shown());
  const MapStatistics& statistics = result.statistics;
  status_.submaps = static_cast<std::size_t>(statistics.submaps);
  status_.closures = static_cast<std::size_t>(statistics.loop_closures_accepted);
  status_.rejected = static_cast<std::size_t>(statistics.loop_closures_rejected);
  if (last_) status_.status = to_string(last_->status);
  show_status(stamp);
  if (!result.trajectory.empty()) {
    board_.show_robot(stamp, result.trajectory.back().pose, Eigen::Matrix3d::Zero(),
                      scans_.at(stamp), robot_);
  }
  last_.reset();
}

MapFeed::MapFeed(ViewBoard& board, const RobotModel& robot, const OccupancyOptions& map,
                 const ViewPeriods& periods)
    : impl_(std::make_unique<Impl>(board, robot, map, periods)) {}
MapFeed::~MapFeed() = default;

void MapFeed::begin_anew(const RobotModel& robot) { impl_->begin_anew(robot); }
void MapFeed::add(const SensorMessage& message) { impl_->add(message); }
void MapFeed::add(const MapUpdate& update, const Mapper& mapper) { impl_->add(update, mapper); }
void MapFeed::add_warning(const std::string& text) { impl_->add_warning(text); }
void MapFeed::note_front_end(double seconds) { impl_->note_front_end(seconds); }
void MapFeed::end(const Mapper& mapper) { impl_->end(mapper); }
void MapFeed::finish(const MapResult& result) { impl_->finish(result); }
void MapFeed::catch_up(const Mapper& mapper) { impl_->catch_up(mapper); }
void MapFeed::flush() { impl_->flush(); }

}  // namespace loopstone
