#include "report/canvas.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <stdexcept>

namespace loopstone {
namespace {

void require_ok(cairo_status_t status) {
  if (status != CAIRO_STATUS_SUCCESS) {
    throw std::runtime_error(std::string("cannot draw: ") + cairo_status_to_string(status));
  }
}

}  // namespace

Colour hex_colour(unsigned rgb, double alpha) {
  return {((rgb >> 16) & 255U) / 255.0, ((rgb >> 8) & 255U) / 255.0, (rgb & 255U) / 255.0, alpha};
}

Colour time_colour(double share) {
  static const Colour kStops[] = {hex_colour(0x1d4ed8), hex_colour(0x7c3aed), hex_colour(0xdb2777),
                                  hex_colour(0xf97316)};
  const double position = std::clamp(share, 0.0, 1.0) * static_cast<double>(std::size(kStops) - 1);
  const std::size_t i = std::min(static_cast<std::size_t>(position), std::size(kStops) - 2);
  const double t = position - static_cast<double>(i);
  const auto mix = [t](double a, double b) { return a + t * (b - a); };
  return {mix(kStops[i].red, kStops[i + 1].red), mix(kStops[i].green, kStops[i + 1].green),
          mix(kStops[i].blue, kStops[i + 1].blue), 1.0};
}

Canvas::Canvas(int width_px, int height_px, const Colour& background)
    : surface_(cairo_image_surface_create(CAIRO_FORMAT_RGB24, width_px, height_px)),
      context_(cairo_create(surface_.get())) {
  require_ok(cairo_surface_status(surface_.get()));
  require_ok(cairo_status(context_.get()));
  cairo_set_line_cap(context_.get(), CAIRO_LINE_CAP_ROUND);
  cairo_set_line_join(context_.get(), CAIRO_LINE_JOIN_ROUND);
  set(background);
  cairo_paint(context_.get());
}

void Canvas::set(const Colour& colour) {
  cairo_set_source_rgba(context_.get(), colour.red, colour.green, colour.blue, colour.alpha);
}

void Canvas::trace(const std::vector<Point>& points) {
  cairo_new_path(context_.get());
  for (const Point& point : points) cairo_line_to(context_.get(), point.x, point.y);
}

void Canvas::fill_rectangle(Point corner, double width, double height, const Colour& colour) {
  set(colour);
  cairo_rectangle(context_.get(), corner.x, corner.y, width, height);
  cairo_fill(context_.get());
}

void Canvas::line(const std::vector<Point>& points, double width, const Colour& colour) {
  if (points.size() < 2) return;
  trace(points);
  set(colour);
  cairo_set_line_width(context_.get(), width);
  cairo_stroke(context_.get());
}

void Canvas::disc(Point centre, double radius, const Colour& fill, double edge_width,
                  const Colour& edge) {
  cairo_new_path(context_.get());
  cairo_arc(context_.get(), centre.x, centre.y, radius, 0.0, 2.0 * std::numbers::pi);
  set(fill);
  cairo_fill_preserve(context_.get());
  set(edge);
  cairo_set_line_width(context_.get(), edge_width);
  cairo_stroke(context_.get());
}

void Canvas::polygon(const std::vector<Point>& points, const Colour& fill, double edge_width,
                     const Colour& edge) {
  trace(points);
  cairo_close_path(context_.get());
  set(fill);
  cairo_fill_preserve(context_.get());
  set(edge);
  cairo_set_line_width(context_.get(), edge_width);
  cairo_stroke(context_.get());
}

void Canvas::select_font(double size_px, bool bold) {
  cairo_select_font_face(context_.get(), "sans-serif", CAIRO_FONT_SLANT_NORMAL,
                         bold ? CAIRO_FONT_WEIGHT_BOLD : CAIRO_FONT_WEIGHT_NORMAL);
  cairo_set_font_size(context_.get(), size_px);
}

double Canvas::text_width(const std::string& words, double size_px, bool bold) {
  select_font(size_px, bold);
  cairo_text_extents_t extents;
  cairo_text_extents(context_.get(), words.c_str(), &extents);
  return extents.x_advance;
}

void Canvas::text(Point at, const std::string& words, double size_px, const Colour& colour,
                  double x_anchor, bool bold) {
  const double width = text_width(words, size_px, bold);
  set(colour);
  cairo_move_to(context_.get(), at.x - x_anchor * width, at.y);
  cairo_show_text(context_.get(), words.c_str());
}

void Canvas::text_with_halo(Point at, const std::string& words, double size_px,
                            const Colour& colour, const Colour& halo, double x_anchor) {
  const double width = text_width(words, size_px, true);
  cairo_move_to(context_.get(), at.x - x_anchor * width, at.y);
  cairo_text_path(context_.get(), words.c_str());
  set(halo);
  cairo_set_line_width(context_.get(), 0.28 * size_px);
  cairo_stroke_preserve(context_.get());
  set(colour);
  cairo_fill(context_.get());
}

void Canvas::clip(Point corner, double width, double height) {
  cairo_new_path(context_.get());
  cairo_rectangle(context_.get(), corner.x, corner.y, width, height);
  cairo_clip(context_.get());
}

void Canvas::unclip() { cairo_reset_clip(context_.get()); }

void Canvas::dashed_line(const std::vector<Point>& points, double width, const Colour& colour,
                         double on, double off) {
  const double dashes[] = {on, off};
  cairo_set_dash(context_.get(), dashes, 2, 0.0);
  line(points, width, colour);
  cairo_set_dash(context_.get(), nullptr, 0, 0.0);
}

void Canvas::ring(Point centre, double radius, double width, const Colour& colour) {
  cairo_new_path(context_.get());
  cairo_arc(context_.get(), centre.x, centre.y, radius, 0.0, 2.0 * std::numbers::pi);
  set(colour);
  cairo_set_line_width(context_.get(), width);
  cairo_stroke(context_.get());
}

void Canvas::paste(const Image& rgb, int left_px, int top_px) {
  cairo_surface_flush(surface_.get());
  unsigned char* const pixels = cairo_image_surface_get_data(surface_.get());
  const int stride = cairo_image_surface_get_stride(surface_.get());
  const int width = std::min(rgb.width, cairo_image_surface_get_width(surface_.get()) - left_px);
  const int height = std::min(rgb.height, cairo_image_surface_get_height(surface_.get()) - top_px);
  for (int row = 0; row < height; ++row) {
    auto* to = reinterpret_cast<std::uint32_t*>(
                   static_cast<void*>(pixels + std::ptrdiff_t{stride} * (top_px + row))) +
               left_px;
    const std::uint8_t* from =
        rgb.bytes.data() + static_cast<std::size_t>(row) * static_cast<std::size_t>(rgb.width) * 3;
    for (int column = 0; column < width; ++column, from += 3) {
      to[column] = std::uint32_t{from[0]} << 16 | std::uint32_t{from[1]} << 8 | from[2];
    }
  }
  cairo_surface_mark_dirty(surface_.get());
}

Image Canvas::image() const {
  require_ok(cairo_status(context_.get()));
  cairo_surface_flush(surface_.get());
  Image image = make_image(cairo_image_surface_get_width(surface_.get()),
                           cairo_image_surface_get_height(surface_.get()), 3);
  const unsigned char* const pixels = cairo_image_surface_get_data(surface_.get());
  const int stride = cairo_image_surface_get_stride(surface_.get());
  std::uint8_t* to = image.bytes.data();
  for (int row = 0; row < image.height; ++row) {
    const auto* from = reinterpret_cast<const std::uint32_t*>(
        static_cast<const void*>(pixels + std::ptrdiff_t{stride} * row));
    for (int column = 0; column < image.width; ++column) {
      *to++ = static_cast<std::uint8_t>(from[column] >> 16 & 255U);
      *to++ = static_cast<std::uint8_t>(from[column] >> 8 & 255U);
      *to++ = static_cast<std::uint8_t>(from[column] & 255U);
    }
  }
  return image;
}

}  // namespace loopstone
