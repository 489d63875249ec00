#include "loopstone/slam/scan_to_scan.hpp"

#include <algorithm>
#include <cmath>
#include <exception>
#include <utility>

#include "loopstone/base/hypotenuse.hpp"
#include "loopstone/base/option_list.hpp"
#include "loopstone/sensor/mounted_scan.hpp"
#include "loopstone/sensor/scan_points.hpp"
#include "slam/scan_edges.hpp"
#include "slam/stopwatch.hpp"

namespace loopstone {

namespace {

constexpr std::size_t kMinPoints = 10;
/// Between two looks at the progress callback.
constexpr std::size_t kBatch = 256;

/// Every point that is not too near to the last one kept.
std::vector<Eigen::Vector2d> thinned(const std::vector<Eigen::Vector2d>& points, double spacing_m) {
  std::vector<Eigen::Vector2d> result;
  for (const Eigen::Vector2d& point : points) {
    if (result.empty() || (point - result.back()).norm() >= spacing_m) result.push_back(point);
  }
  return result;
}

void solve(const SolverOptions& options, MapResult& result) {
  const Stopwatch solving;
  SolveResult solved = optimize(result.graph, options);
  if (solved.status != SolveStatus::kConverged) {
    result.warnings.push_back(
        "The pose graph was not solved: " + std::string(to_string(solved.status)) + ".");
  }
  result.graph.poses = std::move(solved.poses);
  result.statistics.optimisation_s = solving.seconds();
  result.statistics.graph_cost = solved.cost;
}

}  // namespace

/// The motions between nodes.
struct ScanToScanMapper::Links {
  std::vector<PoseWithCovariance2> consecutive;  ///< [i]: from node i - 1 to node i; [0] unused
  std::vector<bool> matched;                     ///< by ICP, not by odometry
  std::vector<RelativePoseEdge> intervals;
  std::size_t nodes = 0;  ///< that were reached before a stop
  bool complete = true;
  double seconds = 0.0;
};

ScanToScanMapper::ScanToScanMapper(const RobotModel& robot, const ScanToScanOptions& options,
                                   Threads threads)
    : robot_(robot), options_(options), threads_(threads), scan_queue_(robot.wheels) {
  require_valid(options);
}

void ScanToScanMapper::add(const SensorMessage& message) {
  const auto mounted = as_mounted(message, robot_);
  scan_queue_.add(mounted ? *mounted : message);
  while (auto scan = scan_queue_.next()) take(std::move(*scan));
}

bool ScanToScanMapper::is_node(const Record& record) const {
  if (nodes_.empty() || !record.odom_T_robot) return true;
  if (options_.node_distance_m <= 0.0 && options_.node_angle_rad <= 0.0) return true;
  const Record& last = records_[nodes_.back().record];
  if (!last.odom_T_robot) return true;
  const Pose2 motion = last.odom_T_robot->inverse() * *record.odom_T_robot;
  const bool moved =
      options_.node_distance_m > 0.0 && hypotenuse(motion.x, motion.y) >= options_.node_distance_m;
  const bool turned =
      options_.node_angle_rad > 0.0 && std::abs(motion.yaw) >= options_.node_angle_rad;
  return moved || turned;
}

void ScanToScanMapper::take(LaserScan scan) {
  Record record{.scan = std::move(scan),
                .robot_T_lidar = {},
                .odom_T_robot = {},
                .velocity = Tangent2::Zero(),
                .node = -1,
                .node_T_robot = {}};
  const Stamp stamp = record.scan.stamp;
  record.robot_T_lidar = mount_of(record.scan, robot_);
  if (const auto pose = scan_queue_.odometer().pose_at(stamp)) record.odom_T_robot = pose->pose;
  if (!records_.empty() && record.odom_T_robot && records_.back().odom_T_robot) {
    const double seconds = (stamp - records_.back().scan.stamp).seconds();
    const Pose2 motion = records_.back().odom_T_robot->inverse() * *record.odom_T_robot;
    if (seconds > 0.0) record.velocity = log(motion) / seconds;
  }
  auto points = thinned(scan_points(record.scan, record.robot_T_lidar, record.velocity),
                        options_.point_spacing_m);
  if (points.size() < kMinPoints) {
    ++dropped_;
  } else if (is_node(record)) {
    Node node{.stamp = stamp,
              .record = records_.size(),
              .points = std::move(points),
              .before_T_node = {}};
    if (!nodes_.empty())
      node.before_T_node = scan_queue_.odometer().motion_between(nodes_.back().stamp, stamp);
    record.node = static_cast<int>(nodes_.size());
    nodes_.push_back(std::move(node));
  } else {
    record.node = static_cast<int>(nodes_.size()) - 1;
    const Record& last = records_[nodes_.back().record];
    record.node_T_robot = last.odom_T_robot->inverse() * *record.odom_T_robot;
  }
  records_.push_back(std::move(record));
}

ScanToScanMapper::Links ScanToScanMapper::match_consecutive(
    const ProgressCallback& progress) const {
  Links links;
  links.consecutive.resize(nodes_.size());
  links.matched.assign(nodes_.size(), false);
  const auto match = [&](std::size_t i, const PoseWithCovariance2& expected) {
    const MatchResult result = match_icp(nodes_[i].points, make_icp_cloud<2>(nodes_[i - 1].points),
                                         expected.pose, options_.icp);
    return believed(result, expected);
  };
  for (std::size_t begin = 0; begin < nodes_.size(); begin += kBatch) {
    const std::size_t end = std::min(begin + kBatch, nodes_.size());
    if (progress && !progress({.step = "matching scans",
                               .done = static_cast<std::int64_t>(begin),
                               .total = static_cast<std::int64_t>(nodes_.size()),
                               .scans = static_cast<std::int64_t>(begin)})) {
      links.complete = false;
      return links;
    }
    // With odometry every pair stands alone; without, one needs the motion of the pair before.
    std::vector<std::optional<PoseWithCovariance2>> found(end - begin);
    parallel_for(end - begin, threads_, [&](std::size_t k) {
      const Node& node = nodes_[begin + k];
      if (begin + k > 0 && node.before_T_node) found[k] = match(begin + k, *node.before_T_node);
    });
    for (std::size_t i = std::max<std::size_t>(begin, 1); i < end; ++i) {
      PoseWithCovariance2 expected = guessed_motion(links.consecutive[i - 1].pose);
      auto& motion = found[i - begin];
      if (nodes_[i].before_T_node) {
        expected = with_floor(*nodes_[i].before_T_node);
      } else {
        motion = match(i, expected);
      }
      links.matched[i] = motion.has_value();
      links.consecutive[i] = motion.value_or(expected);
    }
    links.nodes = end;
  }
  return links;
}

void ScanToScanMapper::match_intervals(Links& links, const ProgressCallback& progress) const {
  const auto interval = static_cast<std::size_t>(options_.interval);
  if (interval == 0 || !links.complete) return;
  std::vector<std::size_t> last_nodes;
  for (std::size_t i = interval; i < links.nodes; i += interval) last_nodes.push_back(i);
  std::vector<std::vector<RelativePoseEdge>> edges(last_nodes.size());

  const auto match_to_last = [&](std::size_t k) {
    const std::size_t last = last_nodes[k];
    // Backwards from the node before the last one; its own edge is there already.
    PoseWithCovariance2 first_T_last = links.consecutive[last];
    const IcpCloud<2> target = make_icp_cloud<2>(nodes_[last].points);
    for (std::size_t first = last - 1; first-- > last - interval;) {
      first_T_last = compound(links.consecutive[first + 1], first_T_last);
      if (first != last - interval && !options_.interval_all) continue;
      const PoseWithCovariance2 expected = inverse(first_T_last);
      const MatchResult match =
          match_icp(nodes_[first].points, target, expected.pose, options_.icp);
      if (const auto last_T_first = believed(match, expected)) {
        edges[k].push_back(edge_between(static_cast<int>(last), static_cast<int>(first),
                                        *last_T_first, EdgeKind::kMatch));
      }
    }
  };
  for (std::size_t begin = 0; begin < last_nodes.size(); begin += kBatch) {
    if (progress && !progress({.step = "matching intervals",
                               .done = static_cast<std::int64_t>(begin),
                               .total = static_cast<std::int64_t>(last_nodes.size()),
                               .scans = scans()})) {
      links.complete = false;
      break;
    }
    parallel_for(std::min(kBatch, last_nodes.size() - begin), threads_,
                 [&](std::size_t k) { match_to_last(begin + k); });
  }
  for (const auto& group : edges) {
    links.intervals.insert(links.intervals.end(), group.begin(), group.end());
  }
}

PoseGraph ScanToScanMapper::graph_of(const Links& links) const {
  PoseGraph graph;
  for (std::size_t i = 0; i < links.nodes; ++i) {
    if (i == 0) {
      graph.poses.emplace_back();
      continue;
    }
    const PoseWithCovariance2& motion = links.consecutive[i];
    graph.poses.push_back(graph.poses.back() * motion.pose);
    graph.edges.push_back(edge_between(static_cast<int>(i) - 1, static_cast<int>(i), motion,
                                       links.matched[i] ? EdgeKind::kMatch : EdgeKind::kOdometry));
  }
  graph.edges.insert(graph.edges.end(), links.intervals.begin(), links.intervals.end());
  return graph;
}

std::vector<PosedScan> ScanToScanMapper::place_scans(const Links& links, MapResult& result) const {
  std::vector<PosedScan> posed;
  for (const Record& record : records_) {
    if (record.odom_T_robot) result.odometry.append(record.scan.stamp, *record.odom_T_robot);
    if (record.node < 0 || static_cast<std::size_t>(record.node) >= links.nodes) continue;
    const Pose2 map_T_robot =
        result.graph.poses[static_cast<std::size_t>(record.node)] * record.node_T_robot;
    const double sweep_s = sweep_seconds(record.scan);
    const Pose2 map_T_robot_end = map_T_robot * exp(Tangent2(record.velocity * sweep_s));
    result.trajectory.append(record.scan.stamp, map_T_robot);
    posed.push_back({&record.scan, map_T_robot * record.robot_T_lidar,
                     map_T_robot_end * record.robot_T_lidar, map_T_robot});
  }
  return posed;
}

void ScanToScanMapper::draw(const std::vector<PosedScan>& posed, MapResult& result) const {
  const Stopwatch rendering;
  try {
    result.map = build_occupancy_map(posed, robot_.footprint_radius_m, options_.map, threads_);
  } catch (const std::exception& error) {
    result.map_failure = error.what();
  }
  result.statistics.rendering_s = rendering.seconds();
  const Stopwatch judging;
  result.graph_quality = assess_graph(result.graph, result.graph.poses, result.loop_closures);
  if (result.map_failure.empty()) {
    result.quality = assess_map(posed, threads_);
    result.ties = find_ties_of(result.graph, {.stamps = result.node_stamps,
                                              .drifts = result.drifts,
                                              .agreeing = result.quality.agreeing,
                                              .contradictions = result.quality.contradictions,
                                              .loops = result.graph_quality.loops,
                                              .reduced_chi2 = result.graph_quality.reduced_chi2});
    result.verdict = judge_map(result);
  }
  result.statistics.judging_s = judging.seconds();
  if (auto coarser = coarser_than_asked(result.map, options_.map))
    result.warnings.push_back(std::move(*coarser));
}

MapResult ScanToScanMapper::assemble(const Links& links) const {
  MapResult result;
  result.complete = links.complete;
  for (std::size_t i = 0; i < links.nodes; ++i) result.node_stamps.push_back(nodes_[i].stamp);
  result.graph = graph_of(links);
  solve(options_.solver, result);
  const std::vector<PosedScan> posed = place_scans(links, result);

  MapStatistics& statistics = result.statistics;
  statistics.front_end_s = links.seconds;
  statistics.scans = scans();
  statistics.scans_dropped = dropped_;
  statistics.key_scans = static_cast<std::int64_t>(links.nodes);
  statistics.path_length_m = result.trajectory.path_length_m();
  if (!result.trajectory.empty()) {
    statistics.duration_s =
        (result.trajectory.back().stamp - result.trajectory.front().stamp).seconds();
  }
  draw(posed, result);
  const auto guessed = std::count(links.matched.begin(), links.matched.end(), false) - 1;
  if (links.complete && guessed > 0) {
    result.warnings.push_back(std::to_string(guessed) + " of " + std::to_string(links.nodes - 1) +
                              " consecutive scans did not match; odometry stood in.");
  }
  return result;
}

MapResult ScanToScanMapper::finish(const ProgressCallback& progress) {
  scan_queue_.finish();
  while (auto scan = scan_queue_.next()) take(std::move(*scan));
  const Stopwatch matching;
  Links links = match_consecutive(progress);
  match_intervals(links, progress);
  links.seconds = matching.seconds();
  return assemble(links);
}

}  // namespace loopstone
