#include "slam/edit_state.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace loopstone {

namespace {

std::size_t nearest_in_time(Stamp stamp, const std::vector<KeyScan>& keys) {
  const auto off = [&](const KeyScan& key) { return std::abs((key.stamp - stamp).nanoseconds); };
  const auto nearest = std::ranges::min_element(keys, {}, off);
  return static_cast<std::size_t>(nearest - keys.begin());
}

/// On the map's clock.
Stamp stamp_of(const PathPlace& place, const SettledMap& map) {
  if (place.stamp) return *place.stamp;
  return map.track.front().stamp + Duration::from_seconds(*place.drive_s);
}

}  // namespace

bool EditState::ignores(std::size_t scan) const {
  return std::ranges::any_of(ignored, [scan](const ScanRange& range) {
    return scan >= range.first && scan <= range.last;
  });
}

EditedPath::EditedPath(const SettledMap& settled)
    : map(&settled), keys(settled.chain.keys()), first_nodes(settled.chain.first_nodes()) {
  for (const SubmapRecord& submap : settled.chain.submaps()) {
    submap.scans.for_each([&](const MappedScan& mapped) {
      if (mapped.is_key) key_scans.push_back(&mapped);
    });
  }
}

SubmapId EditedPath::submap_of(std::size_t node) const {
  const auto after = std::ranges::upper_bound(first_nodes, NodeId{static_cast<int>(node)});
  return {static_cast<std::size_t>(after - first_nodes.begin()) - 1};
}

std::string EditedPath::told(std::size_t node) const {
  return fmt::format("{:.2f} s", (keys[node].stamp - map->track.front().stamp).seconds());
}

std::size_t node_of(const PathPlace& place, const EditedPath& path) {
  if (path.keys.empty()) throw EditRefusal("the map has no path");
  if (place.node) {
    if (*place.node < 0 || *place.node >= static_cast<std::int64_t>(path.keys.size())) {
      throw EditRefusal(fmt::format("there is no node {}: they go from 0 to {}", *place.node,
                                    path.keys.size() - 1));
    }
    return static_cast<std::size_t>(*place.node);
  }
  const Stamp stamp = stamp_of(place, *path.map);
  const Stamp first = path.map->track.front().stamp;
  const Stamp last = path.map->track.back().stamp;
  const Duration slack = Duration::from_seconds(kMapEditor.same_closure_s);
  if (stamp < first - slack || stamp > last + slack) {
    throw EditRefusal(
        fmt::format("{:.3f} s is no moment of the path: its stamps go from {:.3f} to {:.3f}, which "
                    "is {:.3f} s of driving",
                    place.drive_s.value_or(stamp.seconds()), first.seconds(), last.seconds(),
                    (last - first).seconds()));
  }
  return nearest_in_time(stamp, path.keys);
}

Anchored anchor_point(const Pose2& map_T_point, const PathPlace& at, const EditReference& reference,
                      const EditedPath& path) {
  Anchored anchored;
  if (at == PathPlace{}) {
    if (reference.map_T_keys.empty()) throw EditRefusal("the map has no path");
    const auto off = [&](const Pose2& pose) {
      return (pose.translation() - map_T_point.translation()).squaredNorm();
    };
    const auto nearest = std::ranges::min_element(reference.map_T_keys, {}, off);
    anchored.key = static_cast<std::size_t>(nearest - reference.map_T_keys.begin());
  } else {
    anchored.key = node_of(at, path);
  }
  anchored.key_T_point = reference.map_T_keys[anchored.key].inverse() * map_T_point;
  return anchored;
}

Anchored anchor_polygon(const Polygon2& polygon, const PathPlace& at,
                        const EditReference& reference, const EditedPath& path) {
  if (const auto fault = fault_of(polygon)) throw EditRefusal("its polygon must " + *fault);
  const Eigen::Vector2d middle = centroid_of(polygon);
  Anchored anchored = anchor_point({middle.x(), middle.y(), 0.0}, at, reference, path);
  anchored.key_polygon = reference.map_T_keys[anchored.key].inverse() * polygon;
  return anchored;
}

}  // namespace loopstone
