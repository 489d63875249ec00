#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "loopstone/formats/image.hpp"
#include "report/coverage.hpp"
#include "report/font.hpp"
#include "report/outline.hpp"

namespace loopstone {

struct Colour {
  double red = 0.0;  ///< [0, 1]
  double green = 0.0;
  double blue = 0.0;
  double alpha = 1.0;
};

[[nodiscard]] Colour hex_colour(unsigned rgb, double alpha = 1.0);

/// From the beginning (0) of a run to its end (1): blue, violet, red, amber. All stand out from
/// white and from black.
[[nodiscard]] Colour time_colour(double share);

/// A picture to draw on, with smooth edges. What lies beyond it is cut. The same calls give the
/// same bytes everywhere. Where curves of one shape lie on each other, its edge is up to half a
/// pixel wider.
class Canvas {
 public:
  Canvas(int width_px, int height_px, const Colour& background);

  /// What the curves go round; what several go round is filled once.
  void fill(std::span<const Contour> contours, const Colour& colour);
  void fill_rectangle(Point corner, double width, double height, const Colour& colour);
  void polygon(const std::vector<Point>& points, const Colour& fill_colour, double edge_width,
               const Colour& edge);
  void disc(Point centre, double radius, const Colour& fill_colour, double edge_width,
            const Colour& edge);
  /// A circle that is not filled.
  void ring(Point centre, double radius, double width, const Colour& colour);
  /// Lines have round joins and ends.
  void line(const std::vector<Point>& points, double width, const Colour& colour);
  void dashed_line(const std::vector<Point>& points, double width, const Colour& colour, double on,
                   double off);
  /// \param x_anchor 0: x is the left end of the text, 0.5: its middle, 1: its right end. y is the
  ///                 base line, and is rounded to whole pixels.
  void text(Point at, std::string_view words, double size_px, const Colour& colour,
            double x_anchor = 0.0, FontWeight weight = FontWeight::kNormal);
  /// Bold; a second text colour behind the first keeps it readable on any ground.
  void text_with_halo(Point at, std::string_view words, double size_px, const Colour& colour,
                      const Colour& halo, double x_anchor = 0.0);
  /// Lays an opaque picture on the canvas, pixel on pixel, over what a clip covers, too.
  void paste(const Image& rgb, int left_px, int top_px);

  /// What is drawn from here on stays inside the rectangle, until unclip().
  void clip(Point corner, double width, double height);
  void unclip();

  [[nodiscard]] const Image& image() const { return image_; }

 private:
  Image image_;
  PixelBox box_{};  ///< what may be drawn on
};

}  // namespace loopstone
