#pragma once

#include <span>
#include <vector>

// Shapes as closed curves in pixels: lines with their width, circles. They go round in one
// direction and holes in the other, and may overlap: what any curve goes round is inside.

namespace loopstone {

struct Point {
  double x = 0.0;  ///< [px], to the right
  double y = 0.0;  ///< [px], down
};

/// A closed curve of straight pieces; the last point is joined to the first.
using Contour = std::vector<Point>;

/// On and off along a line [px].
struct Dashes {
  double on;
  double off;
};

[[nodiscard]] Contour circle(Point centre, double radius);
/// What a circle of this radius leaves when it is drawn with this width.
[[nodiscard]] std::vector<Contour> ring_outline(Point centre, double radius, double width);

/// A line with round joins and ends. Nothing of fewer than two points, a dot where all are one.
[[nodiscard]] std::vector<Contour> line_outline(std::span<const Point> points, double width);
/// The line along the edge of a polygon.
[[nodiscard]] std::vector<Contour> edge_outline(std::span<const Point> polygon, double width);
/// The line's dashes. A line of very many is drawn through.
[[nodiscard]] std::vector<Contour> dashed_outline(std::span<const Point> points, double width,
                                                  const Dashes& dashes);

}  // namespace loopstone
