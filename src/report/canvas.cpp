#include "report/canvas.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>

namespace loopstone {
namespace {

std::array<std::uint8_t, 3> bytes_of(const Colour& colour) {
  const auto byte = [](double value) {
    return static_cast<std::uint8_t>(std::lround(255.0 * std::clamp(value, 0.0, 1.0)));
  };
  return {byte(colour.red), byte(colour.green), byte(colour.blue)};
}

/// Where the left end of a text and its base line are.
Point anchored(Point at, double x_anchor, double width) {
  return {at.x - x_anchor * width, std::round(at.y)};
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
    : image_(make_image(width_px, height_px, 3)) {
  const auto rgb = bytes_of(background);
  for (std::size_t i = 0; i < image_.bytes.size(); i += 3)
    std::ranges::copy(rgb, image_.bytes.begin() + static_cast<std::ptrdiff_t>(i));
  unclip();
}

void Canvas::fill(std::span<const Contour> contours, const Colour& colour) {
  Coverage coverage(box_);
  coverage.add(contours);
  const auto rgb = bytes_of(colour);
  const auto alpha = static_cast<std::uint32_t>(std::lround(65536.0 * colour.alpha));
  for (const CoveredRun& run : coverage.runs()) {
    const auto weight = static_cast<std::uint32_t>(std::uint64_t{run.share} * alpha >> 16);
    std::uint8_t* pixel = image_.bytes.data() + 3 * (static_cast<std::size_t>(run.row) *
                                                         static_cast<std::size_t>(image_.width) +
                                                     static_cast<std::size_t>(run.column));
    for (int i = 0; i < run.length; ++i) {
      for (const std::uint8_t to : rgb) {
        *pixel =
            static_cast<std::uint8_t>((*pixel * (65536U - weight) + to * weight + 32768U) >> 16);
        ++pixel;
      }
    }
  }
}

void Canvas::fill_rectangle(Point corner, double width, double height, const Colour& colour) {
  const Contour edge{corner,
                     {corner.x + width, corner.y},
                     {corner.x + width, corner.y + height},
                     {corner.x, corner.y + height}};
  fill({&edge, 1}, colour);
}

void Canvas::polygon(const std::vector<Point>& points, const Colour& fill_colour, double edge_width,
                     const Colour& edge) {
  fill({&points, 1}, fill_colour);
  fill(edge_outline(points, edge_width), edge);
}

void Canvas::disc(Point centre, double radius, const Colour& fill_colour, double edge_width,
                  const Colour& edge) {
  const Contour whole = circle(centre, radius);
  fill({&whole, 1}, fill_colour);
  ring(centre, radius, edge_width, edge);
}

void Canvas::ring(Point centre, double radius, double width, const Colour& colour) {
  fill(ring_outline(centre, radius, width), colour);
}

void Canvas::line(const std::vector<Point>& points, double width, const Colour& colour) {
  fill(line_outline(points, width), colour);
}

void Canvas::dashed_line(const std::vector<Point>& points, double width, const Colour& colour,
                         double on, double off) {
  fill(dashed_outline(points, width, {on, off}), colour);
}

void Canvas::text(Point at, std::string_view words, double size_px, const Colour& colour,
                  double x_anchor, FontWeight weight) {
  const Point from = anchored(at, x_anchor, text_width(words, size_px, weight));
  fill(text_outline(words, from, size_px, weight), colour);
}

void Canvas::text_with_halo(Point at, std::string_view words, double size_px, const Colour& colour,
                            const Colour& halo, double x_anchor) {
  const Point from = anchored(at, x_anchor, text_width(words, size_px, FontWeight::kBold));
  const std::vector<Contour> letters = text_outline(words, from, size_px, FontWeight::kBold);
  std::vector<Contour> around;
  for (const Contour& letter : letters)
    std::ranges::move(edge_outline(letter, 0.28 * size_px), std::back_inserter(around));
  fill(around, halo);
  fill(letters, colour);
}

void Canvas::paste(const Image& rgb, int left_px, int top_px) {
  const int left = std::max(left_px, 0);
  const int right = std::min(left_px + rgb.width, image_.width);
  const int bottom = std::min(top_px + rgb.height, image_.height);
  const auto pixel = [](const Image& of, int row, int column) {
    return static_cast<std::ptrdiff_t>(row) * of.width * 3 + column * std::ptrdiff_t{3};
  };
  for (int row = std::max(top_px, 0); row < bottom && left < right; ++row) {
    std::copy_n(rgb.bytes.begin() + pixel(rgb, row - top_px, left - left_px),
                3 * static_cast<std::ptrdiff_t>(right - left),
                image_.bytes.begin() + pixel(image_, row, left));
  }
}

void Canvas::clip(Point corner, double width, double height) {
  const auto within = [](double px, int side) {
    return std::clamp(px, 0.0, static_cast<double>(side));
  };
  box_ = {within(corner.x, image_.width), within(corner.y, image_.height),
          within(corner.x + std::max(width, 0.0), image_.width),
          within(corner.y + std::max(height, 0.0), image_.height)};
}

void Canvas::unclip() {
  box_ = {0.0, 0.0, static_cast<double>(image_.width), static_cast<double>(image_.height)};
}

}  // namespace loopstone
