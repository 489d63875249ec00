#include "live/hull.hpp"

#include <algorithm>
#include <cstddef>

namespace loopstone {
namespace {

/// Positive when c lies left of the way from a to b.
float turn(const Eigen::Vector2f& a, const Eigen::Vector2f& b, const Eigen::Vector2f& c) {
  const Eigen::Vector2f u = b - a;
  const Eigen::Vector2f v = c - a;
  return u.x() * v.y() - u.y() * v.x();
}

}  // namespace

std::vector<Eigen::Vector2f> convex_hull(std::vector<Eigen::Vector2f> points) {
  const auto before = [](const Eigen::Vector2f& a, const Eigen::Vector2f& b) {
    return a.x() != b.x() ? a.x() < b.x() : a.y() < b.y();
  };
  std::ranges::sort(points, before);
  points.erase(std::unique(points.begin(), points.end()), points.end());
  if (points.size() < 3) return points;
  std::vector<Eigen::Vector2f> hull;
  // The lower half from left to right, then the upper one back.
  for (const bool is_upper : {false, true}) {
    const std::size_t first = hull.size();
    for (const Eigen::Vector2f& point : points) {
      while (hull.size() >= first + 2 && turn(hull[hull.size() - 2], hull.back(), point) <= 0.0F)
        hull.pop_back();
      hull.push_back(point);
    }
    hull.pop_back();  // where the other half begins
    if (!is_upper) std::ranges::reverse(points);
  }
  return hull;
}

}  // namespace loopstone
