#pragma once

#include <span>
#include <string>

#include "loopstone/formats/site_file.hpp"
#include "loopstone/grid/grid.hpp"
#include "loopstone/slam/map_result.hpp"

namespace loopstone {

/// Which of a site's results belong to which session, as a table: its trajectory, by what its
/// clock is shifted in those that hold all sessions, and its nodes of graph.g2o, which follow one
/// another.
/// \param sessions  that are joined, in order
[[nodiscard]] std::string format_site_sessions(const MapResult& result,
                                               std::span<const SiteSession> sessions);
/// sessions.csv, into a folder that is made where it is missing. Throws DataError.
void write_site_sessions(const MapResult& result, std::span<const SiteSession> sessions,
                         const std::string& folder);

/// The map of a site as an MCAP recording of ROS 2, to be looked at in Foxglove, Lichtblick or
/// RViz. It appears whole or not at all. Times are those of the map's trajectory: session after
/// session.
///
///   /map                nav_msgs/OccupancyGrid: as map.pgm has it
///   /movable            nav_msgs/OccupancyGrid: where visits are not of one mind [%]
///   /session_ID/path    nav_msgs/Path: of each session, by the ids of `site show`
///   /loop_closures      visualization_msgs/MarkerArray: as MapRecording has them
///   /verdict            diagnostic_msgs/DiagnosticArray: how good the map is
///   /tf                 tf2_msgs/TFMessage: map to base_link at every scan
///
/// All but /tf stand at the first scan. Throws DataError when it can't be written, MessageError for
/// stamps that ROS 2 has no place for.
/// \param movable  of the cells of the map
void write_site_recording(const MapResult& result, std::span<const SiteSession> sessions,
                          const Grid<float>& movable, const std::string& path);

}  // namespace loopstone
