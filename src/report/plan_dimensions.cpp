#include "report/plan_dimensions.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace loopstone {

namespace {

/// Where a line y = height meets the sides of a polygon.
void add_crossings(const Polygon2& polygon, double height, std::vector<double>& at) {
  for (std::size_t i = 0; i < polygon.corners.size(); ++i) {
    const Eigen::Vector2d& a = polygon.corners[i];
    const Eigen::Vector2d& b = polygon.corners[(i + 1) % polygon.corners.size()];
    if ((a.y() > height) == (b.y() > height)) continue;
    at.push_back(a.x() + (height - a.y()) / (b.y() - a.y()) * (b.x() - a.x()));
  }
}

/// The longest stretch of a line y = height inside the room.
RoomSpan longest_at(const PlanRoom& room, double height) {
  std::vector<double> at;
  add_crossings(room.outline.polygon, height, at);
  for (const PlanOutline& hole : room.holes) add_crossings(hole.polygon, height, at);
  std::sort(at.begin(), at.end());
  RoomSpan best{{0.0, height}, {0.0, height}};
  for (std::size_t i = 0; i + 1 < at.size(); i += 2)
    if (at[i + 1] - at[i] > best.length_m()) best = {{at[i], height}, {at[i + 1], height}};
  return best;
}

/// Along x of a room that lies along the axes.
std::optional<RoomSpan> span_along_x(const PlanRoom& room, double label_y) {
  double low = room.outline.polygon.corners.front().y();
  double high = low;
  for (const Eigen::Vector2d& corner : room.outline.polygon.corners) {
    low = std::min(low, corner.y());
    high = std::max(high, corner.y());
  }
  if (high - low < 1.0) return std::nullopt;
  double most = 0.0;
  std::vector<RoomSpan> spans;
  constexpr int kLines = 40;
  for (int i = 0; i < kLines; ++i) {
    spans.push_back(longest_at(room, low + (i + 0.5) / kLines * (high - low)));
    most = std::max(most, spans.back().length_m());
  }
  // Of those as long as the longest one, that nearest to 15 % from below.
  const double wanted = low + std::clamp(0.15 * (high - low), 0.35, 1.2);
  std::optional<RoomSpan> best;
  double least = 1e9;
  for (const RoomSpan& span : spans) {
    const double off =
        std::abs(span.from.y() - wanted) + (std::abs(span.from.y() - label_y) < 0.45 ? 10.0 : 0.0);
    if (span.length_m() < most - 0.02 || off >= least) continue;
    least = off;
    best = span;
  }
  return best;
}

}  // namespace

std::vector<RoomSpan> room_spans(const PlanRoom& room, const VectorPlan& plan) {
  std::vector<RoomSpan> spans;
  if (!room.is_closed() || room.outline.polygon.corners.size() < 3) return spans;
  const double yaw = plan.axes.empty() ? 0.0 : plan.axes.front().yaw_rad;
  for (const double turn : {yaw, yaw + 0.5 * kPi}) {
    const Pose2 straight{0.0, 0.0, wrap_angle(-turn)};
    PlanRoom turned = room;
    turned.outline.polygon = straight * room.outline.polygon;
    for (PlanOutline& hole : turned.holes) hole.polygon = straight * hole.polygon;
    const auto span = span_along_x(turned, (straight * label_place(room)).y());
    if (!span) continue;
    spans.push_back({straight.inverse() * span->from, straight.inverse() * span->to});
  }
  return spans;
}

}  // namespace loopstone
