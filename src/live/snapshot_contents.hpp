#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include "loopstone/live/view_board.hpp"
#include "loopstone/live/view_contents.hpp"
#include "loopstone/slam/map_result.hpp"
#include "loopstone/slam/map_snapshot.hpp"

// What a mapper's snapshot and its result hold, as a view shows it.

namespace loopstone {

/// Of a path that is sent whole, again and again.
inline constexpr std::size_t kMostPathPoses = 5000;

/// Of the key scans' positions, by stamp [m].
using NodeSigmas = std::unordered_map<std::int64_t, double>;

/// In order. Nodes of which nothing is known have the sigma of those before.
[[nodiscard]] std::vector<ViewNode> nodes_of(const MapSnapshot& snapshot, const NodeSigmas& sigmas);
[[nodiscard]] std::vector<ViewClosure> closures_of(const MapSnapshot& snapshot);

/// Outlines are kept from one snapshot to the next: only submaps that grew are looked at.
class SubmapOutlines {
 public:
  [[nodiscard]] std::vector<ViewSubmap> submaps_of(const MapSnapshot& snapshot);
  void clear() { known_.clear(); }

 private:
  struct Known {
    std::size_t scans = 0;
    std::vector<Eigen::Vector2f> outline_local{};
  };
  std::map<std::size_t, Known> known_{};
};

/// Of a finished map. \param last  the mapper's last snapshot, which knows scans and submaps
[[nodiscard]] std::vector<ViewNode> nodes_of(const MapResult& result, const MapSnapshot& last);
[[nodiscard]] std::vector<ViewClosure> closures_of(const MapResult& result,
                                                   const MapSnapshot& last);
/// Submaps as they lie in the finished map: \param shown  where they lay in the last snapshot
[[nodiscard]] std::vector<ViewSubmap> moved_to(const MapResult& result, const MapSnapshot& last,
                                               std::vector<ViewSubmap> shown);
[[nodiscard]] ViewVerdict verdict_of(const MapResult& result);
/// \param quality  the object of summary.json; what is missing in it is not told
[[nodiscard]] ViewVerdict verdict_of(const nlohmann::ordered_json& quality, bool complete);
/// Places where visits agree and where not; nothing when there are none.
[[nodiscard]] std::optional<ViewLayer> quality_layer_of(const MapResult& result);

/// Shows the path and its closures. Of the result only its poses are asked.
void show_poses(ViewBoard& board, Stamp stamp, const MapResult& result, const MapSnapshot& last);
/// Shows a finished map: path, closures, cells, verdict, and where visits agree. Returns whether
/// there was anything to show of the last.
bool show_result(ViewBoard& board, Stamp stamp, const MapResult& result, const MapSnapshot& last);

}  // namespace loopstone
