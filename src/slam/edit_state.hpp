#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <memory>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "loopstone/geometry/polygon.hpp"
#include "loopstone/mapping/filter_mask.hpp"
#include "loopstone/slam/map_editor.hpp"
#include "loopstone/slam/settled_map.hpp"

namespace loopstone {

/// A point or a polygon that goes where a key scan goes. A polygon keeps its shape: it is held by
/// one key scan alone, since two that see it may part.
struct Anchored {
  std::size_t key = 0;
  Pose2 key_T_point{};
  Polygon2 key_polygon{};
};

/// The map that points and polygons are told on.
struct EditReference {
  std::vector<Pose2> map_T_keys{};  ///< in the frame that is shown
  Pose2 shown_T_map{};              ///< of that frame
};

/// How the map is to lie in its frame, beside that of the reference.
struct FrameWish {
  bool straighten = false;
  std::optional<Anchored> origin{};
  bool origin_turns = false;  ///< its yaw is asked for as well
};

/// Scans of the path from one to another, both included.
struct ScanRange {
  std::size_t first = 0;
  std::size_t last = 0;
};

/// All that a list of edits has led to.
struct EditState {
  SettledGraph settled{};
  std::set<std::pair<NodeId, NodeId>> forced{};  ///< closures that are never revoked
  std::vector<ScanRange> ignored{};
  /// A group for each MapAsEdited that came between: what lies outside of all of a group goes.
  std::vector<std::vector<Anchored>> crops{{}};
  std::vector<Anchored> erased{};
  std::vector<std::pair<KeepOut, Anchored>> keep_out{};
  std::vector<std::pair<LimitSpeed, Anchored>> speed{};
  std::optional<Anchored> newest{};  ///< of the last edit, where it has a polygon
  FrameWish frame{};
  std::shared_ptr<const EditReference> reference{};
  GraphQuality quality{};
  Verdict verdict = Verdict::kUnknown;

  [[nodiscard]] bool ignores(std::size_t scan) const;
};

/// Why an edit can't be done, in words for its report.
class EditRefusal : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// The path of a map by the nodes of its graph.
struct EditedPath {
  const SettledMap* map = nullptr;
  std::vector<KeyScan> keys{};                 ///< one a node
  std::vector<const MappedScan*> key_scans{};  ///< of each
  std::vector<NodeId> first_nodes{};           ///< of each submap's stretch

  explicit EditedPath(const SettledMap& settled);
  [[nodiscard]] SubmapId submap_of(std::size_t node) const;
  /// In words: "12.30 s" after the first scan.
  [[nodiscard]] std::string told(std::size_t node) const;
};

/// The node that a place means. Throws EditRefusal when it lies beside the path.
[[nodiscard]] std::size_t node_of(const PathPlace& place, const EditedPath& path);

/// By the place that the edit names, else the key scan nearest to the point.
[[nodiscard]] Anchored anchor_point(const Pose2& map_T_point, const PathPlace& at,
                                    const EditReference& reference, const EditedPath& path);
/// Of a polygon that is told by its middle. Throws EditRefusal when it is none.
[[nodiscard]] Anchored anchor_polygon(const Polygon2& polygon, const PathPlace& at,
                                      const EditReference& reference, const EditedPath& path);

}  // namespace loopstone
