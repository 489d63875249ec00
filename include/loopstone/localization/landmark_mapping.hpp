#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "loopstone/graph/pose_graph.hpp"
#include "loopstone/localization/landmark_map.hpp"
#include "loopstone/localization/landmark_mapping_options.hpp"
#include "loopstone/sensor/landmark_reading.hpp"
#include "loopstone/slam/decision_numbers.hpp"

namespace loopstone {

/// A landmark whose place was found.
struct FoundLandmark {
  int id = 0;  ///< what it calls itself; of those without a name 1, 2, ... as they were first seen
  Eigen::Vector2d position{0.0, 0.0};  ///< of its centre, map frame [m]
  /// Against the first pose [m^2].
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
  /// Among the other landmarks: the same once the motion of all of them together, which nobody
  /// notices who goes by them, is taken out; along the axis on which it is largest.
  double sigma_m = 0.0;
  double radius_m = 0.0;  ///< 0: flat, or seen from one side only
  int sightings = 0;      ///< that agree with it
  int visits = 0;         ///< how often it came into view
};

/// What became of all that was seen.
struct LandmarkMappingFigures {
  std::int64_t observations = 0;
  std::int64_t used = 0;         ///< of a landmark
  std::int64_t tracks = 0;       ///< things that were followed for more than one reading
  std::int64_t too_few = 0;      ///< of them, seen too seldom or from one place only
  std::int64_t moving = 0;       ///< that did not stay where they were
  std::int64_t see_through = 0;  ///< through which the laser saw too often: they were carried away
  std::int64_t merged = 0;       ///< that are of a landmark known before
  double chi2 = 0.0;             ///< of the sightings used, at the solution, a degree of freedom
};

/// A graph with landmarks, solved.
struct LandmarkMapping {
  PoseGraph graph{};  ///< landmarks and their edges in it, softened by the kernel's weights
  std::vector<FoundLandmark> landmarks{};  ///< in the graph's order
  LandmarkMappingFigures figures{};
};

/// Tells of a point, in the robot's frame at a node, whether the sensor saw beyond it there.
/// Nothing: it was not to be seen from there, or something nearer hid it.
using SeenThrough =
    std::function<std::optional<bool>(std::size_t node, const Eigen::Vector2d& point)>;

/// Finds landmarks of unknown places, and solves the graph with them in it.
///
/// 1. What is seen from each pose is paired with what was seen just before, all of it judged
///    together (landmark_tracks.hpp). What was seen several times, from several places, is a
///    candidate; all else is clutter.
/// 2. Candidates enter the graph, each sighting as an edge between pose and landmark: its range and
///    bearing, as a point with their covariance.
/// 3. Candidates that came into view along the next metres of the path are paired with landmarks
///    known before, by name, or jointly by where the graph expects them and how well it knows
///    that. A pairing counts where no other is nearly as probable; after each that moves something
///    the graph is solved again. So the landmarks close loops.
/// 4. A sighting that disagrees loses weight (Cauchy's kernel); what does not stay in its place, or
///    is seen through, is dropped.
///
/// \param graph  a chain along the path, edges i -> i + 1, with loop closures or without; its poses
///               are the start
/// \param seen   from each of the graph's poses, in the robot's frame
/// \return without anything seen the graph as it was. Deterministic; one thread.
/// Throws UsageError unless there are as many readings as poses, and as check_graph does.
/// Cost: for each few metres of the path a factorisation of the graph, where landmarks are seen
/// again also a solution. Source: Neira and Tardos 2001; Folkesson and Christensen 2004, "Graphical
/// SLAM - a self-correcting map", for landmarks in a graph of poses.
[[nodiscard]] LandmarkMapping map_landmarks(const PoseGraph& graph,
                                            std::span<const std::vector<LandmarkObservation>> seen,
                                            const LandmarkMappingOptions& options,
                                            const SeenThrough& seen_through = {});

/// What the algorithm decides by, for the record.
[[nodiscard]] NumberGroup landmark_numbers();

/// Covariance of points among themselves: that part of their joint one that moves and turns them
/// all together is taken out (Baarda's S-transformation, all points being the datum).
/// \param joint  of (x, y) of the first point, of the second and so on
/// Source: Baarda 1973, "S-transformations and criterion matrices".
[[nodiscard]] Eigen::MatrixXd without_common_motion(const Eigen::MatrixXd& joint,
                                                    std::span<const Eigen::Vector2d> points);

/// As a map to localise on.
[[nodiscard]] std::vector<MappedLandmark> as_mapped(std::span<const FoundLandmark> landmarks);

}  // namespace loopstone
