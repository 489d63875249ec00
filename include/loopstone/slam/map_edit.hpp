#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "loopstone/base/stamp.hpp"
#include "loopstone/geometry/polygon.hpp"
#include "loopstone/geometry/pose2.hpp"
#include "loopstone/mapping/filter_mask.hpp"

// What a hand may do to a finished map, as data: docs/editing.md says it for users. Places, points
// and polygons are told in the frame of the map as it was before the first edit, whatever their
// order; what follows a MapAsEdited is told in that of the map with all edits before it.

namespace loopstone {

/// A moment of the path; the key scan nearest to it is meant. One of the three is given.
struct PathPlace {
  std::optional<Stamp> stamp{};        ///< on the map's clock, as trajectory.tum has it
  std::optional<double> drive_s{};     ///< seconds after the first scan
  std::optional<std::int64_t> node{};  ///< of graph.g2o and loop_closures.csv
  friend bool operator==(const PathPlace&, const PathPlace&) = default;
};

/// A closure that stands is taken out, whatever found it. Named by its two places, or by its two
/// submaps as loop_closures.csv has them.
struct DeleteClosure {
  PathPlace from{};
  PathPlace to{};
  std::optional<std::int64_t> from_submap{};
  std::optional<std::int64_t> to_submap{};
  friend bool operator==(const DeleteClosure&, const DeleteClosure&) = default;
};

/// Two places are one. The scans around both are registered; what does not fit is refused.
struct AddClosure {
  PathPlace from{};
  PathPlace to{};
  std::optional<Pose2> guess_from_T_to{};
  std::optional<double> half_window_m{};  ///< of the search about the guess, or about the map
  std::optional<double> half_window_rad{};
  bool force = false;  ///< it is taken however little fits, and never revoked
  friend bool operator==(const AddClosure&, const AddClosure&) = default;
};

/// A stretch of the path whose scans are not used: not drawn, and part of no closure.
struct IgnoreStretch {
  PathPlace from{};
  PathPlace to{};
  friend bool operator==(const IgnoreStretch&, const IgnoreStretch&) = default;
};

/// What lies outside becomes unknown. Of several, what lies outside of all.
struct CropMap {
  Polygon2 polygon{};
  friend bool operator==(const CropMap&, const CropMap&) = default;
};

/// What stands inside becomes free.
struct EraseInside {
  Polygon2 polygon{};
  friend bool operator==(const EraseInside&, const EraseInside&) = default;
};

/// The map is turned until its walls lie along x and y, by 45 degrees at most.
struct StraightenMap {
  friend bool operator==(const StraightenMap&, const StraightenMap&) = default;
};

/// A point becomes (0, 0), and a direction that of x where one is given.
struct SetOrigin {
  Eigen::Vector2d point = Eigen::Vector2d::Zero();
  std::optional<double> yaw_rad{};
  friend bool operator==(const SetOrigin&, const SetOrigin&) = default;
};

struct KeepOut {
  std::string name{};
  Polygon2 polygon{};
  friend bool operator==(const KeepOut&, const KeepOut&) = default;
};

struct LimitSpeed {
  std::string name{};
  Polygon2 polygon{};
  double limit = 0.0;
  SpeedUnit unit = SpeedUnit::kPercent;
  friend bool operator==(const LimitSpeed&, const LimitSpeed&) = default;
};

/// What follows is told in the frame of the map with all edits so far.
struct MapAsEdited {
  friend bool operator==(const MapAsEdited&, const MapAsEdited&) = default;
};

/// One edit.
struct MapEdit {
  std::variant<DeleteClosure, AddClosure, IgnoreStretch, CropMap, EraseInside, StraightenMap,
               SetOrigin, KeepOut, LimitSpeed, MapAsEdited>
      what{};
  /// The part of the map that a point or polygon belongs to: it goes where this place of the path
  /// goes. Nothing: the key scan nearest to the point, or to the polygon's middle.
  PathPlace anchor{};
  std::optional<std::int64_t> line{};  ///< in the file it was read from
  friend bool operator==(const MapEdit& a, const MapEdit& b) {
    return a.what == b.what && a.anchor == b.anchor;
  }
};

/// As files call it: "delete_closure".
[[nodiscard]] std::string_view kind_of(const MapEdit& edit);

}  // namespace loopstone
