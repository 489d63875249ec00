#include "loopstone/registration/match_sweep.hpp"

#include <Eigen/Geometry>
#include <algorithm>

namespace loopstone {

namespace {

/// How far a point at the source's radius can be apart between two poses, at most.
template <int kDimension>
double distance(const typename RigidMotion<kDimension>::Pose& a,
                const typename RigidMotion<kDimension>::Pose& b,
                const CloudExtent<kDimension>& source) {
  using Motion = RigidMotion<kDimension>;
  const auto moved_centre = (a * source.centre - b * source.centre).eval();
  const typename Motion::Tangent motion = Motion::difference(a, b);
  return moved_centre.norm() +
         source.radius_m * motion.template tail<Motion::kDof - kDimension>().norm();
}

Eigen::Matrix2d turn_about_vertical(double angle_rad, const Eigen::Vector2d& /*of the plane*/) {
  return Eigen::Rotation2Dd(angle_rad).toRotationMatrix();
}
Eigen::Matrix3d turn_about_vertical(double angle_rad, const Eigen::Vector3d& /*of space*/) {
  return Eigen::AngleAxisd(angle_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
}

}  // namespace

template <int kDimension>
bool is_better(const BasicMatchResult<kDimension>& a, const BasicMatchResult<kDimension>& b) {
  if (has_supported_pose(a.status) != has_supported_pose(b.status))
    return has_supported_pose(a.status);
  if (a.score != b.score) return a.score > b.score;
  return a.rmse_m < b.rmse_m;
}

template <int kDimension>
SweepResult<kDimension> match_from(std::span<const typename RigidMotion<kDimension>::Pose> starts,
                                   const Matcher<kDimension>& matcher,
                                   const CloudExtent<kDimension>& source, double same_m) {
  using Ending = typename SweepResult<kDimension>::Ending;
  SweepResult<kDimension> sweep;
  sweep.starts = static_cast<int>(starts.size());
  std::vector<Ending> matches;
  for (std::size_t i = 0; i < starts.size(); ++i) matches.push_back({matcher(starts[i]), i, 1});
  std::stable_sort(matches.begin(), matches.end(), [](const Ending& a, const Ending& b) {
    return is_better<kDimension>(a.match, b.match);
  });
  // Best first, so that each place is represented by the best match that ended there.
  for (const Ending& ending : matches) {
    const auto same =
        std::find_if(sweep.endings.begin(), sweep.endings.end(), [&](const Ending& other) {
          return distance<kDimension>(ending.match.target_T_source, other.match.target_T_source,
                                      source) <= same_m;
        });
    if (same == sweep.endings.end()) {
      sweep.endings.push_back(ending);
    } else {
      ++same->count;
    }
  }
  if (!sweep.endings.empty()) sweep.agreeing = sweep.endings.front().count;
  return sweep;
}

template <int kDimension>
std::vector<typename RigidMotion<kDimension>::Pose> headings_from(
    const typename RigidMotion<kDimension>::Pose& guess, const CloudExtent<kDimension>& source,
    int count) {
  using Motion = RigidMotion<kDimension>;
  const typename Motion::Vector centre = guess * source.centre;
  std::vector<typename Motion::Pose> starts;
  for (int i = 0; i < count; ++i) {
    const double angle_rad = 2.0 * kPi * i / count;
    const typename Motion::Matrix rotation =
        turn_about_vertical(angle_rad, centre) * Motion::rotation(guess);
    starts.push_back(Motion::pose(rotation, centre - rotation * source.centre));
  }
  return starts;
}

template bool is_better<2>(const MatchResult&, const MatchResult&);
template bool is_better<3>(const MatchResult3&, const MatchResult3&);
template SweepResult<2> match_from<2>(std::span<const Pose2>, const Matcher<2>&,
                                      const CloudExtent<2>&, double);
template SweepResult<3> match_from<3>(std::span<const Pose3>, const Matcher<3>&,
                                      const CloudExtent<3>&, double);
template std::vector<Pose2> headings_from<2>(const Pose2&, const CloudExtent<2>&, int);
template std::vector<Pose3> headings_from<3>(const Pose3&, const CloudExtent<3>&, int);

}  // namespace loopstone
