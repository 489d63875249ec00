#pragma once

#include <Eigen/Core>
#include <span>
#include <string>

#include "loopstone/formats/image.hpp"
#include "loopstone/formats/ros_map.hpp"
#include "loopstone/geometry/rigid_motion.hpp"

namespace loopstone {

/// A match as it is drawn: what was aligned to what, from which guess to which pose.
template <int kDimension>
struct MatchScene {
  using Pose = typename RigidMotion<kDimension>::Pose;
  using Point = Eigen::Matrix<double, kDimension, 1>;

  std::span<const Point> source{};  ///< source frame [m]; points that are not finite are left out
  std::span<const Point> target{};  ///< target frame [m]; the walls, when there is a map
  const CellStates* map = nullptr;  ///< lies under the points; in the plane only
  Pose guess_target_T_source{};
  Pose target_T_source{};
  std::string before = "before: the guess";  ///< what stands above the pictures
  std::string after = "after";
  bool shows_robot = false;  ///< the source's origin is a robot: draw it
};

struct MatchPictureOptions {
  int panel_px = 900;  ///< longer side of one picture; the whole has two in the plane, six in space
  /// Residual that has the last colour; 0: six times the median, rounded up.
  double far_m = 0.0;
};

/// Before and after side by side at one scale: the target grey, the source by the guess blue, by
/// the match coloured by the distance to the nearest target point (green to red). With a map, the
/// map underneath. In space three views, from above, from the side and from the front. With a scale
/// bar, axes and legend. 8-bit RGB.
/// Throws UsageError when there are no finite points.
template <int kDimension>
[[nodiscard]] Image draw_match_picture(const MatchScene<kDimension>& scene,
                                       const MatchPictureOptions& options = {});

extern template Image draw_match_picture<2>(const MatchScene<2>&, const MatchPictureOptions&);
extern template Image draw_match_picture<3>(const MatchScene<3>&, const MatchPictureOptions&);

}  // namespace loopstone
