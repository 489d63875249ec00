#include "initial_pose.hpp"

#include <vector>

#include "loopstone/base/error.hpp"
#include "parse_pose.hpp"

namespace loopstone::app {

std::optional<InitialPose> initial_pose(const std::string& initial, const std::string& sigma) {
  if (initial.empty()) return std::nullopt;
  InitialPose pose{.map_T_robot = parse_pose2("--initial", initial)};
  if (sigma.empty()) return pose;
  const std::vector<double> sigmas = parse_numbers("--initial-sigma", sigma);
  if (sigmas.size() != 2 || !(sigmas[0] > 0.0) || !(sigmas[1] > 0.0)) {
    throw UsageError("--initial-sigma " + sigma +
                     ": must be M,RAD, both above 0, such as 0.5,0.26");
  }
  pose.sigma_m = sigmas[0];
  pose.sigma_rad = sigmas[1];
  return pose;
}

}  // namespace loopstone::app
