#include "report/outline.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "loopstone/base/hypotenuse.hpp"

namespace loopstone {
namespace {

constexpr double kFlatness = 0.015;    // [px] between an arc and the straight pieces drawn for it
constexpr double kMostDashes = 20000;  // more than pixels on the longest line of a picture

Point plus(Point a, Point b) { return {a.x + b.x, a.y + b.y}; }
Point times(double s, Point a) { return {s * a.x, s * a.y}; }
/// To the left of a direction, as seen on a picture.
Point left_of(Point d) { return {d.y, -d.x}; }

/// How many straight pieces stand for an arc [rad].
int pieces_of(double radius, double angle) {
  const double step = 2.0 * std::acos(std::max(1.0 - kFlatness / std::max(radius, kFlatness), 0.0));
  return std::max(1, static_cast<int>(std::ceil(angle / step)));
}

/// Without points that repeat the one before.
std::vector<Point> distinct(std::span<const Point> points) {
  std::vector<Point> kept;
  for (const Point& point : points) {
    if (kept.empty() || hypotenuse(point.x - kept.back().x, point.y - kept.back().y) > 1e-6)
      kept.push_back(point);
  }
  return kept;
}

/// From one normal to another around a corner, clockwise as seen on a picture.
void add_arc(Point corner, Point from, double angle, double radius, Contour& to) {
  const int pieces = pieces_of(radius, angle);
  for (int i = 0; i <= pieces; ++i) {
    const double at = angle * i / pieces;
    const double c = std::cos(at);
    const double s = std::sin(at);
    to.push_back(plus(corner, times(radius, {c * from.x - s * from.y, s * from.x + c * from.y})));
  }
}

/// The curve at this distance to the left of a closed one. Where the corner is on this side, it
/// goes by the corner itself: the sum of this curve and of the one on the other side goes round
/// each piece's rectangle and each corner's wedge once, none of them backwards.
Contour beside(const std::vector<Point>& loop, double distance) {
  const std::size_t count = loop.size();
  std::vector<Point> directions(count);
  for (std::size_t i = 0; i < count; ++i) {
    const Point& from = loop[i];
    const Point& to = loop[(i + 1) % count];
    const double length = hypotenuse(to.x - from.x, to.y - from.y);
    directions[i] = {(to.x - from.x) / length, (to.y - from.y) / length};
  }
  Contour found;
  for (std::size_t i = 0; i < count; ++i) {
    const Point before = directions[(i + count - 1) % count];
    const Point after = directions[i];
    const double cross = before.x * after.y - before.y * after.x;
    const double dot = before.x * after.x + before.y * after.y;
    const bool turns_back = std::abs(cross) < 1e-9 && dot < 0.0;
    if (turns_back || cross >= 0.0) {
      const double angle = turns_back ? std::numbers::pi : std::atan2(cross, dot);
      add_arc(loop[i], left_of(before), angle, distance, found);
    } else {
      found.push_back(plus(loop[i], times(distance, left_of(before))));
      found.push_back(loop[i]);
      found.push_back(plus(loop[i], times(distance, left_of(after))));
    }
  }
  return found;
}

/// Adds what a line covers: the curve beside its way there and back.
void add_line(const std::vector<Point>& points, double width, std::vector<Contour>& to) {
  if (points.size() < 2) {
    if (!points.empty()) to.push_back(circle(points.front(), 0.5 * width));
    return;
  }
  std::vector<Point> loop = points;
  loop.insert(loop.end(), points.rbegin() + 1, points.rend() - 1);
  to.push_back(beside(loop, 0.5 * width));
}

}  // namespace

Contour circle(Point centre, double radius) {
  const int pieces = std::max(8, pieces_of(radius, 2.0 * std::numbers::pi));
  Contour found;
  for (int i = 0; i < pieces; ++i) {
    const double at = 2.0 * std::numbers::pi * i / pieces;
    found.push_back(plus(centre, times(radius, {std::cos(at), std::sin(at)})));
  }
  return found;
}

std::vector<Contour> ring_outline(Point centre, double radius, double width) {
  if (width <= 0.0) return {};
  std::vector<Contour> found{circle(centre, radius + 0.5 * width)};
  if (radius > 0.5 * width) {
    found.push_back(circle(centre, radius - 0.5 * width));
    std::ranges::reverse(found.back());
  }
  return found;
}

std::vector<Contour> line_outline(std::span<const Point> points, double width) {
  std::vector<Contour> found;
  if (points.size() >= 2 && width > 0.0) add_line(distinct(points), width, found);
  return found;
}

std::vector<Contour> edge_outline(std::span<const Point> polygon, double width) {
  if (width <= 0.0) return {};
  std::vector<Point> loop = distinct(polygon);
  while (loop.size() > 1 && distinct(std::vector{loop.back(), loop.front()}).size() == 1)
    loop.pop_back();
  if (loop.size() < 3) return line_outline(polygon, width);
  std::vector<Contour> found{beside(loop, 0.5 * width)};
  std::ranges::reverse(loop);
  found.push_back(beside(loop, 0.5 * width));
  return found;
}

std::vector<Contour> dashed_outline(std::span<const Point> points, double width,
                                    const Dashes& dashes) {
  const std::vector<Point> line = distinct(points);
  double length = 0.0;
  for (std::size_t i = 1; i < line.size(); ++i)
    length += hypotenuse(line[i].x - line[i - 1].x, line[i].y - line[i - 1].y);
  const double period = dashes.on + dashes.off;
  if (!(period > 0.0) || !(length / period < kMostDashes)) return line_outline(points, width);
  if (points.size() < 2 || width <= 0.0) return {};

  std::vector<Contour> found;
  std::vector<Point> dash{line.front()};
  bool is_on = true;
  double left = dashes.on;  // of the dash or the gap, from here on
  for (std::size_t i = 1; i < line.size(); ++i) {
    const Point from = line[i - 1];
    const Point to = line[i];
    const double piece = hypotenuse(to.x - from.x, to.y - from.y);
    double done = 0.0;
    while (piece - done > left) {
      done += left;
      const double share = done / piece;
      const Point at{from.x + share * (to.x - from.x), from.y + share * (to.y - from.y)};
      dash.push_back(at);
      if (is_on) add_line(dash, width, found);
      dash = {at};
      is_on = !is_on;
      left = is_on ? dashes.on : dashes.off;
    }
    left -= piece - done;
    dash.push_back(to);
  }
  if (is_on) add_line(distinct(dash), width, found);
  return found;
}

}  // namespace loopstone
