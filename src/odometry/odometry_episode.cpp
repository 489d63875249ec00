#include <fmt/format.h>

#include <string>

#include "loopstone/odometry/odometry_check.hpp"

namespace loopstone {

std::string what_is_wrong(const OdometryEpisode& episode) {
  const bool turns = episode.part == OdometryPart::kRotation;
  const std::string part = turns ? "heading" : "distance";
  switch (episode.fault) {
    case OdometryFault::kStuck:
      return turns ? "its heading stands still while the robot turns"
                   : "it stands still while the robot drives";
    case OdometryFault::kSpinning:
      return turns ? "its heading turns while the robot does not"
                   : "it drives while the robot stands still";
    case OdometryFault::kMirrored:
      return turns ? "it turns the other way" : "it drives the other way";
    case OdometryFault::kScaled:
      return fmt::format("its {} is {:.2f} times the true one", part, episode.ratio);
    case OdometryFault::kLagging:
      return episode.lag_s >= 0.0
                 ? fmt::format("it is {:.2f} s late", episode.lag_s)
                 : fmt::format("it is {:.2f} s early beside the laser", -episode.lag_s);
    case OdometryFault::kWrong:
      return "its " + part + " disagrees with the laser";
  }
  return {};
}

}  // namespace loopstone
