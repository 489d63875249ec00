#pragma once

#include <optional>
#include <span>
#include <string>

#include "loopstone/base/memory_budget.hpp"
#include "loopstone/base/parallel_for.hpp"
#include "loopstone/geometry/polygon.hpp"
#include "loopstone/plan/vector_plan.hpp"
#include "loopstone/slam/map_result.hpp"
#include "loopstone/slam/mapped_scan.hpp"
#include "loopstone/slam/session.hpp"

namespace loopstone {

/// Where a map lies on the earth.
struct GeoAnchor {
  double latitude_deg = 0.0;   ///< of the map's origin, WGS 84
  double longitude_deg = 0.0;  ///< the same, east positive
  double bearing_deg = 0.0;    ///< of the map's x axis, clockwise from true north
};

/// Latitude within 89.9, longitude within 180, bearing within 360 degrees.
[[nodiscard]] bool is_on_earth(const GeoAnchor& anchor);

/// What stands on the sheet beside the plan.
struct PlanTitle {
  std::string name{};                 ///< what it is a plan of
  double map_yaw_rad = 0.0;           ///< of the map's x axis in the plan's frame
  std::optional<double> north_rad{};  ///< of true north in the plan's frame
};

/// Of a map that lies in its plan by `plan_T_map`, and on the earth by an anchor, if it is known.
[[nodiscard]] PlanTitle plan_title(std::string name, const Pose2& plan_T_map,
                                   const std::optional<GeoAnchor>& anchor);

/// The plan of a map, as extract_plan() finds it: through what the laser measured where the folder
/// has a state (map --keep-state) and a trajectory, else through the cells of the map.
/// \param path  a folder of `loopstone map`, a map_server YAML file, or a site
/// Throws DataError with the file at fault.
[[nodiscard]] VectorPlan read_plan(const std::string& path, const MemoryBudget& budget = {},
                                   Threads threads = {});

/// The same of a map in memory: what read_plan() makes of the folder that write_map_outputs() would
/// leave of it.
/// \param state  that it was kept with; null: none, and lines go through the cells
/// Throws UsageError where there is nothing to draw.
[[nodiscard]] VectorPlan plan_of(const MapResult& map, const Session* state, Threads threads = {});
/// The same through scans that the map was drawn from, stamped as its trajectory is: a site's.
/// \param walls  that were drawn on it by hand (walls_of())
[[nodiscard]] VectorPlan plan_of(const MapResult& map, const MappedScans& scans,
                                 std::span<const Polygon2> walls, Threads threads = {});

/// What a plan is called where nobody says so: the name of the map's file or folder.
[[nodiscard]] std::string plan_name(const std::string& path);

/// A sheet of paper, ISO A4 to A0, with the plan at a round scale, rooms with their areas and
/// dimensions, a scale bar and what the lines mean. In millimetres; layers are groups whose ids are
/// their words. Text is text.
[[nodiscard]] std::string format_plan_svg(const VectorPlan& plan, const PlanTitle& title);
/// The same sheet as one page of PDF 1.4, lines as lines and text as text.
[[nodiscard]] std::string format_plan_pdf(const VectorPlan& plan, const PlanTitle& title);

/// Drawing exchange format, release 12 (AC1009), ASCII, in metres. Layers: STRUCTURE, HIDDEN
/// (dashed), MOVABLE as LINE; ROOMS as closed POLYLINE; DOORS as LINE from jamb to jamb; AREAS as
/// TEXT.
/// Source: Autodesk, "DXF Reference", release 12.
[[nodiscard]] std::string format_plan_dxf(const VectorPlan& plan);

/// A FeatureCollection: LineString for segments and doors, Polygon for rooms; "layer" tells them
/// apart, others carry units in their names. Nine digits: 0.1 mm.
/// \param plan  in the frame of the map
/// Source: RFC 7946; the local plane is the tangent one of the WGS 84 ellipsoid at the anchor.
[[nodiscard]] std::string format_plan_geojson(const VectorPlan& plan, const GeoAnchor& anchor);

/// Of a point on the tangent plane: longitude and latitude [deg].
[[nodiscard]] Eigen::Vector2d longitude_latitude(const GeoAnchor& anchor,
                                                 const Eigen::Vector2d& in_map);

}  // namespace loopstone
