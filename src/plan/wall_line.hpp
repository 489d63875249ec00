#pragma once

#include <Eigen/Core>
#include <vector>

#include "loopstone/plan/vector_plan.hpp"
#include "loopstone/plan/wall_samples.hpp"

namespace loopstone {

/// A line through samples, before it is cut to a segment.
struct WallLine {
  Eigen::Vector2d centre{0.0, 0.0};  ///< mean of its samples, map frame [m]
  Eigen::Vector2d along{1.0, 0.0};   ///< unit; free space is on its left
  double low_m = 0.0;                ///< its ends, along it from its centre
  double high_m = 0.0;
  double sigma_across_m = 0.0;  ///< at its centre
  double sigma_yaw_rad = 0.0;
  double samples = 0.0;
  double facing = 1.0;  ///< mean cosine between its samples' normals and its own
  bool squared = false;

  [[nodiscard]] double length_m() const { return high_m - low_m; }
  [[nodiscard]] Eigen::Vector2d normal() const { return {-along.y(), along.x()}; }
  [[nodiscard]] Eigen::Vector2d at(double t) const { return centre + t * along; }
  /// Of a point: along it, and to its free side.
  [[nodiscard]] double along_of(const Eigen::Vector2d& point) const {
    return (point - centre).dot(along);
  }
  [[nodiscard]] double across_of(const Eigen::Vector2d& point) const {
    return (point - centre).dot(normal());
  }
};

struct FoundLines {
  std::vector<WallLine> lines{};
  double across_m = 0.0;  ///< samples of a wall lie within this of its line
};

/// Lines through the samples, longest seeds first: regions grow from a piece of wall along its
/// direction, with a least-squares fit after every step, for as long as pieces lie on the line and
/// face as it does. Deterministic.
[[nodiscard]] FoundLines grow_lines(const WallSamples& samples);

/// The directions that walls share.
[[nodiscard]] std::vector<PlanAxis> find_axes(const std::vector<WallLine>& lines);

/// Turns each line about its centre onto the axis from which it can't be told.
void square_lines(const std::vector<PlanAxis>& axes, std::vector<WallLine>& lines);

/// What lies at an end of a segment.
struct EndJoint {
  int segment = -1;     ///< the one it meets; -1: none
  bool convex = false;  ///< the free side is the outer one, as at a jamb
};

/// Segments with the corners in which they meet.
struct JoinedSegments {
  std::vector<PlanSegment> segments{};
  std::vector<EndJoint> at_from{};  ///< of each segment
  std::vector<EndJoint> at_to{};
  double plane_m = 0.01;  ///< lines of one wall may be apart by this, but for their own uncertainty
  std::vector<bool> stands_free{};  ///< and is no wall therefore, or stands before one
};

/// Cuts lines to segments; ends that lie where two lines meet become one corner.
[[nodiscard]] JoinedSegments join_corners(const std::vector<WallLine>& lines, double corner_m,
                                          double end_sigma_m);

}  // namespace loopstone
