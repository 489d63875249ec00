#include "formats/wheel_geometry.hpp"

#include <algorithm>
#include <string>
#include <vector>

#include "formats/wheel_names.hpp"

namespace loopstone {
namespace {

constexpr double kFarthestM = 5.0;
constexpr double kLeastTrackM = 0.02;
constexpr double kLeastRadiusM = 0.005;
constexpr double kMostRadiusM = 1.0;
/// Axles of one robot's wheels are as high as one another, but for this share of the radius.
constexpr double kSameHeight = 0.1;

/// "robot1/" of "robot1/base_link".
std::string_view prefix_of(std::string_view frame) { return frame.substr(0, frame.rfind('/') + 1); }

double mean(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

/// The frame on the floor below a robot; empty when there is none.
std::string footprint_of(const FrameTree& frames, std::string_view base) {
  for (const std::string& frame : frames.names()) {
    if (prefix_of(frame) != prefix_of(base)) continue;
    if (frame.find("footprint") != std::string::npos && frames.find(frame, base)) return frame;
  }
  return {};
}

}  // namespace

WheelGeometry wheel_geometry(const FrameTree& frames, std::string_view base) {
  if (base.empty()) return {};
  const std::string footprint = footprint_of(frames, base);
  std::vector<double> left_m;
  std::vector<double> right_m;
  std::vector<double> heights_m;
  for (const std::string& frame : frames.names()) {
    const auto spot = wheel_spot(frame);
    if (!spot || prefix_of(frame) != prefix_of(base)) continue;
    const auto base_T_wheel = frames.find(base, frame);
    if (!base_T_wheel || base_T_wheel->translation.norm() > kFarthestM) continue;
    const double y_m = base_T_wheel->translation.y();
    if ((y_m > 0.0) != spot->is_left) return {};
    (spot->is_left ? left_m : right_m).push_back(y_m);
    if (footprint.empty()) continue;
    if (const auto floor_T_wheel = frames.find(footprint, frame)) {
      heights_m.push_back(floor_T_wheel->translation.z());
    }
  }
  if (left_m.empty() || right_m.empty()) return {};
  WheelGeometry geometry;
  const double track_m = mean(left_m) - mean(right_m);
  if (track_m >= kLeastTrackM) geometry.track_width_m = track_m;
  if (heights_m.empty()) return geometry;
  const double radius_m = mean(heights_m);
  const auto [lowest, highest] = std::ranges::minmax(heights_m);
  const bool is_level = highest - lowest <= kSameHeight * radius_m;
  if (is_level && radius_m >= kLeastRadiusM && radius_m <= kMostRadiusM) {
    geometry.radius_m = radius_m;
  }
  return geometry;
}

}  // namespace loopstone
