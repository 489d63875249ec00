#include "loopstone/geometry/polygon.hpp"

#include <cmath>
#include <cstddef>

namespace loopstone {

namespace {

/// Less than a square centimetre is a line.
constexpr double kLeastArea_m2 = 1e-4;

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

/// Positive when the corners go round counter-clockwise.
double signed_area(const Polygon2& polygon) {
  const auto& corners = polygon.corners;
  double twice = 0.0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    // From the first corner on, so that a far origin costs no digits.
    const Eigen::Vector2d a = corners[i] - corners.front();
    const Eigen::Vector2d b = corners[(i + 1) % corners.size()] - corners.front();
    twice += cross(a, b);
  }
  return 0.5 * twice;
}

struct Side {
  Eigen::Vector2d from;
  Eigen::Vector2d to;
};

/// On which side of a line a point is.
int side_of(const Side& line, const Eigen::Vector2d& point) {
  const double turn = cross(line.to - line.from, point - line.from);
  return turn > 0.0 ? 1 : (turn < 0.0 ? -1 : 0);
}

bool cross_each_other(const Side& a, const Side& b) {
  return side_of(a, b.from) * side_of(a, b.to) < 0 && side_of(b, a.from) * side_of(b, a.to) < 0;
}

Side side(const Polygon2& polygon, std::size_t i) {
  return {polygon.corners[i], polygon.corners[(i + 1) % polygon.corners.size()]};
}

}  // namespace

Polygon2 box_polygon(const Eigen::Vector2d& low, const Eigen::Vector2d& high) {
  return {{low, {high.x(), low.y()}, high, {low.x(), high.y()}}};
}

std::optional<std::string> fault_of(const Polygon2& polygon) {
  const std::size_t count = polygon.corners.size();
  if (count < 3) return "have three corners at least";
  for (const Eigen::Vector2d& corner : polygon.corners)
    if (!corner.allFinite()) return "have corners that are numbers";
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t j = i + 2; j < count; ++j) {
      if (i == 0 && j + 1 == count) continue;  // neighbours
      if (cross_each_other(side(polygon, i), side(polygon, j)))
        return "have sides that do not cross one another";
    }
  }
  if (!(area_of(polygon) > kLeastArea_m2)) return "enclose an area";
  return {};
}

bool contains(const Polygon2& polygon, const Eigen::Vector2d& point) {
  bool inside = false;
  for (std::size_t i = 0; i < polygon.corners.size(); ++i) {
    const auto& [a, b] = side(polygon, i);
    if ((a.y() > point.y()) == (b.y() > point.y())) continue;
    const double x = a.x() + (point.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x());
    if (point.x() < x) inside = !inside;
  }
  return inside;
}

Eigen::Vector2d centroid_of(const Polygon2& polygon) {
  const auto& corners = polygon.corners;
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Eigen::Vector2d a = corners[i] - corners.front();
    const Eigen::Vector2d b = corners[(i + 1) % corners.size()] - corners.front();
    sum += cross(a, b) * (a + b);
  }
  return corners.front() + sum / (6.0 * signed_area(polygon));
}

double area_of(const Polygon2& polygon) { return std::abs(signed_area(polygon)); }

Polygon2 operator*(const Pose2& b_T_a, const Polygon2& in_a) {
  Polygon2 in_b = in_a;
  for (Eigen::Vector2d& corner : in_b.corners) corner = b_T_a * corner;
  return in_b;
}

}  // namespace loopstone
