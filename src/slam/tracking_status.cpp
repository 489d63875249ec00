#include "loopstone/slam/tracking_status.hpp"

namespace loopstone {

std::string_view to_string(TrackingStatus status) {
  switch (status) {
    case TrackingStatus::kTracked:
      return "tracked";
    case TrackingStatus::kDegenerate:
      return "degenerate";
    case TrackingStatus::kBridged:
      return "bridged";
    case TrackingStatus::kLost:
      return "lost";
  }
  return "unknown";
}

}  // namespace loopstone
