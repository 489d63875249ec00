#pragma once

#include <cairo.h>

#include <memory>
#include <string>
#include <vector>

#include "loopstone/formats/image.hpp"

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

struct Point {
  double x = 0.0;  ///< [px], to the right
  double y = 0.0;  ///< [px], down
};

/// A picture to draw on.
class Canvas {
 public:
  Canvas(int width_px, int height_px, const Colour& background);

  void fill_rectangle(Point corner, double width, double height, const Colour& colour);
  void line(const std::vector<Point>& points, double width, const Colour& colour);
  void disc(Point centre, double radius, const Colour& fill, double edge_width, const Colour& edge);
  void polygon(const std::vector<Point>& points, const Colour& fill, double edge_width,
               const Colour& edge);
  /// \param x_anchor 0: x is the left end of the text, 0.5: its middle, 1: its right end. y is the
  ///                 base line.
  void text(Point at, const std::string& words, double size_px, const Colour& colour,
            double x_anchor = 0.0, bool bold = false);
  [[nodiscard]] double text_width(const std::string& words, double size_px, bool bold = false);
  /// A second text colour behind the first keeps it readable on any ground.
  void text_with_halo(Point at, const std::string& words, double size_px, const Colour& colour,
                      const Colour& halo, double x_anchor = 0.0);
  /// What is drawn from here on stays inside the rectangle, until unclip().
  void clip(Point corner, double width, double height);
  void unclip();
  void dashed_line(const std::vector<Point>& points, double width, const Colour& colour, double on,
                   double off);
  /// A circle that is not filled.
  void ring(Point centre, double radius, double width, const Colour& colour);
  /// Lays an opaque picture on the canvas, pixel on pixel; what reaches beyond the right and lower
  /// edge is cut.
  void paste(const Image& rgb, int left_px, int top_px);

  [[nodiscard]] Image image() const;

 private:
  struct Destroy {
    void operator()(cairo_t* context) const { cairo_destroy(context); }
    void operator()(cairo_surface_t* surface) const { cairo_surface_destroy(surface); }
  };
  void set(const Colour& colour);
  void select_font(double size_px, bool bold);
  void trace(const std::vector<Point>& points);

  std::unique_ptr<cairo_surface_t, Destroy> surface_;
  std::unique_ptr<cairo_t, Destroy> context_;
};

}  // namespace loopstone
