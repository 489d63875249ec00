#include <fmt/format.h>

#include <string>

#include "loopstone/odometry/odometry_check.hpp"

namespace loopstone {

namespace {

std::string number(double value, int digits) { return fmt::format("{:.{}f}", value, digits); }

}  // namespace

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
      return "its " + part + " is " + number(episode.ratio, 2) + " times the true one";
    case OdometryFault::kLagging:
      return episode.lag_s >= 0.0
                 ? "it is " + number(episode.lag_s, 2) + " s late"
                 : "it is " + number(-episode.lag_s, 2) + " s early beside the laser";
    case OdometryFault::kWrong:
      return "its " + part + " disagrees with the laser";
  }
  return {};
}

}  // namespace loopstone
