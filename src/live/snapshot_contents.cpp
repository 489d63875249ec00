#include "live/snapshot_contents.hpp"

#include <algorithm>
#include <cmath>

#include "live/hull.hpp"
#include "loopstone/geometry/covariance.hpp"
#include "loopstone/sensor/scan_points.hpp"

namespace loopstone {
namespace {

/// A submap is outlined by what was seen from so near.
constexpr double kNearM = 8.0;
/// Of a submap's scans so many are enough for its outline, and of their beams every so many.
constexpr std::size_t kOutlineScans = 40;
constexpr std::size_t kOutlineStride = 3;

using ScanByStamp = std::unordered_map<std::int64_t, std::shared_ptr<const MappedScan>>;

ScanByStamp key_scans_of(const MapSnapshot& snapshot) {
  ScanByStamp scans;
  for (const SubmapSnapshot& submap : snapshot.submaps) {
    for (const auto& scan : *submap.scans) {
      if (scan->is_key) scans.emplace(scan->scan.stamp.nanoseconds, scan);
    }
  }
  return scans;
}

std::shared_ptr<const MappedScan> find(const ScanByStamp& scans, Stamp stamp) {
  const auto found = scans.find(stamp.nanoseconds);
  return found == scans.end() ? nullptr : found->second;
}

std::vector<Eigen::Vector2f> outline_of(const MappedScans& scans) {
  std::vector<Eigen::Vector2f> points;
  const std::size_t step = 1 + scans.size() / kOutlineScans;
  for (std::size_t i = 0; i < scans.size(); i += step) {
    const MappedScan& mapped = *scans[i];
    const std::vector<Eigen::Vector2d> seen = scan_points(mapped.scan, mapped.robot_T_lidar);
    points.emplace_back(mapped.local_T_robot.translation().cast<float>());
    for (std::size_t k = 0; k < seen.size(); k += kOutlineStride) {
      if (seen[k].squaredNorm() < kNearM * kNearM)
        points.emplace_back((mapped.local_T_robot * seen[k]).cast<float>());
    }
  }
  return convex_hull(std::move(points));
}

std::vector<Eigen::Vector2f> moved(const Pose2& pose, std::vector<Eigen::Vector2f> points) {
  for (Eigen::Vector2f& point : points) point = (pose * point.cast<double>().eval()).cast<float>();
  return points;
}

std::uint32_t drive_at(const MapSnapshot& snapshot, std::size_t scan) {
  return static_cast<std::uint32_t>(std::ranges::count_if(snapshot.breaks, [&](const auto& gap) {
    return gap.cause == BreakCause::kNewDrive && gap.to_scan <= scan;
  }));
}

std::uint32_t drive_at(const MapResult& result, Stamp stamp) {
  return static_cast<std::uint32_t>(std::ranges::count_if(
      result.drives, [&](const MappedDrive& drive) { return drive.begins <= stamp; }));
}

/// The submap of each stamp: the last one that had begun by then.
class SubmapAt {
 public:
  explicit SubmapAt(const MapSnapshot& snapshot) {
    for (const SubmapSnapshot& submap : snapshot.submaps)
      begins_.push_back(submap.scans->front()->scan.stamp);
  }
  [[nodiscard]] std::uint32_t operator()(Stamp stamp) const {
    const auto after = std::ranges::upper_bound(begins_, stamp);
    return static_cast<std::uint32_t>(std::max<std::ptrdiff_t>(after - begins_.begin(), 1) - 1);
  }

 private:
  std::vector<Stamp> begins_{};
};

Pose2 pose_at(const MapResult& result, Stamp stamp) {
  return result.trajectory.at_clamped(stamp).value_or(Pose2{});
}

}  // namespace

std::vector<ViewNode> nodes_of(const MapSnapshot& snapshot, const NodeSigmas& sigmas) {
  std::vector<ViewNode> nodes;
  double sigma_m = 0.0;
  for (const SubmapSnapshot& submap : snapshot.submaps) {
    for (const auto& mapped : *submap.scans) {
      if (!mapped->is_key) continue;
      const auto known = sigmas.find(mapped->scan.stamp.nanoseconds);
      if (known != sigmas.end()) sigma_m = known->second;
      nodes.push_back({.stamp = mapped->scan.stamp,
                       .map_T_robot = submap.map_T_local * mapped->local_T_robot,
                       .sigma_m = sigma_m,
                       .submap = static_cast<std::uint32_t>(submap.id.index),
                       .drive = drive_at(snapshot, mapped->index)});
    }
  }
  return nodes;
}

std::vector<ViewClosure> closures_of(const MapSnapshot& snapshot) {
  std::vector<std::size_t> first_node;  // of each submap
  std::size_t nodes = 0;
  for (const SubmapSnapshot& submap : snapshot.submaps) {
    first_node.push_back(nodes);
    nodes += static_cast<std::size_t>(
        std::ranges::count_if(*submap.scans, [](const auto& scan) { return scan->is_key; }));
  }
  std::vector<ViewClosure> closures;
  for (const LoopClosure& closure : snapshot.closures) {
    ViewClosure shown{.closure = closure};
    const std::size_t from = closure.from_submap.index;
    const std::size_t to = closure.to_submap.index;
    // Its place in the list is its name, so that none is left out.
    if (std::max(from, to) < snapshot.submaps.size()) {
      const SubmapSnapshot& older = snapshot.submaps[from];
      const SubmapSnapshot& newer = snapshot.submaps[to];
      shown.from_node = first_node[from];
      shown.to_node = first_node[to];
      shown.from_scan = older.scans->front();
      shown.to_scan = newer.scans->front();
      shown.from = shown.from_scan->scan.stamp;
      shown.to = shown.to_scan->scan.stamp;
      shown.from_T_to = older.map_T_submap.inverse() * newer.map_T_submap;
    }
    closures.push_back(std::move(shown));
  }
  return closures;
}

std::vector<ViewSubmap> SubmapOutlines::submaps_of(const MapSnapshot& snapshot) {
  std::vector<ViewSubmap> submaps;
  for (const SubmapSnapshot& submap : snapshot.submaps) {
    if (submap.state == SubmapState::kDropped) {
      // Others show all that it saw; of a day's submaps most are such.
      known_.erase(submap.id.index);
      submaps.push_back(
          {.id = submap.id.index, .state = submap.state, .map_T_submap = submap.map_T_submap});
      continue;
    }
    Known& known = known_[submap.id.index];
    if (known.scans < submap.scans->size()) {
      known.outline_local = outline_of(*submap.scans);
      known.scans = submap.scans->size();
    }
    submaps.push_back({.id = submap.id.index,
                       .state = submap.state,
                       .map_T_submap = submap.map_T_submap,
                       .outline = moved(submap.map_T_local, known.outline_local)});
  }
  return submaps;
}

std::vector<ViewNode> nodes_of(const MapResult& result, const MapSnapshot& last) {
  const SubmapAt submap_at(last);
  std::vector<ViewNode> nodes;
  for (std::size_t i = 0; i < result.node_stamps.size(); ++i) {
    const Stamp stamp = result.node_stamps[i];
    const NodeId node{static_cast<std::int32_t>(i)};
    const double sigma_m = result.covariances.available() && i < result.graph.poses.size()
                               ? largest_sigma(result.covariances.of(node).topLeftCorner<2, 2>())
                               : 0.0;
    nodes.push_back({.stamp = stamp,
                     .map_T_robot = pose_at(result, stamp),
                     .sigma_m = sigma_m,
                     .submap = submap_at(stamp),
                     .drive = drive_at(result, stamp)});
  }
  return nodes;
}

std::vector<ViewClosure> closures_of(const MapResult& result, const MapSnapshot& last) {
  const ScanByStamp scans = key_scans_of(last);
  std::vector<ViewClosure> closures;
  for (const LoopClosure& closure : result.loop_closures) {
    ViewClosure shown{.closure = closure};
    const auto from = static_cast<std::size_t>(closure.from.index);
    const auto to = static_cast<std::size_t>(closure.to.index);
    if (std::max(from, to) < result.node_stamps.size()) {
      shown.from_node = from;
      shown.to_node = to;
      shown.from = result.node_stamps[from];
      shown.to = result.node_stamps[to];
      shown.from_T_to = pose_at(result, shown.from).inverse() * pose_at(result, shown.to);
      shown.from_scan = find(scans, shown.from);
      shown.to_scan = find(scans, shown.to);
    }
    closures.push_back(std::move(shown));
  }
  return closures;
}

std::vector<ViewSubmap> moved_to(const MapResult& result, const MapSnapshot& last,
                                 std::vector<ViewSubmap> shown) {
  for (std::size_t i = 0; i < shown.size() && i < last.submaps.size(); ++i) {
    const Pose2 now = pose_at(result, last.submaps[i].scans->front()->scan.stamp);
    shown[i].outline = moved(now * shown[i].map_T_submap.inverse(), std::move(shown[i].outline));
    shown[i].map_T_submap = now;
  }
  return shown;
}

}  // namespace loopstone
