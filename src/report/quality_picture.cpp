#include "loopstone/report/quality_picture.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>

#include "loopstone/mapping/map_quality.hpp"
#include "report/canvas.hpp"
#include "report/map_view.hpp"
#include "report/picture_parts.hpp"

namespace loopstone {
namespace {

// The report's colours of trust (state_style.hpp): told apart by hue, and by lightness where eyes
// tell no hues.
const Colour kTogether = hex_colour(0x0072b2, 0.42);
const Colour kBeside = hex_colour(0xe69f00, 0.62);
const Colour kApart = hex_colour(0xb0004e, 0.66);
const Colour kCrossed = hex_colour(0xb0004e);
const Colour kSeenOnce = hex_colour(0x6b7280, 0.22);

Colour colour_of(const QualityPlace& place) {
  if (place.is_doubled() || place.is_crossed()) return kApart;
  if (place.compared == 0 && place.beams == 0) return kSeenOnce;
  return static_cast<double>(place.offset_m) > 0.5 * kMapQuality.doubled_m ? kBeside : kTogether;
}

void draw_cross(Point low, double side, double width, Canvas& canvas) {
  canvas.line({low, {low.x + side, low.y + side}}, width, kCrossed);
  canvas.line({{low.x + side, low.y}, {low.x, low.y + side}}, width, kCrossed);
}

/// The box of a contradiction, framed.
void draw_frame(const MapView& view, const VisitContradiction& region, double width,
                Canvas& canvas) {
  const Point low = view.pixel_of(region.low);
  const Point high = view.pixel_of(region.high);
  canvas.line({low, {high.x, low.y}, high, {low.x, high.y}, low}, width, kCrossed);
}

void add_legend(const PictureSizes& sizes, Footer& footer) {
  const double side = 0.9 * sizes.text;
  footer.add_swatch(kTogether, "visits agree");
  footer.add_swatch(kBeside, "5 to 10 cm apart");
  footer.add_swatch(kApart, "more, or crossed");
  footer.add("", side, "beams went through", [=](Canvas& canvas, Point at) {
    draw_cross({at.x, at.y - 0.5 * side}, side, 0.3 * sizes.path, canvas);
  });
  footer.add_swatch(kSeenOnce, "seen once");
}

}  // namespace

Image draw_quality_picture(const MapResult& result, const MapPictureOptions& options) {
  const MapView view =
      view_of(result.map, result.trajectory, options.target_side_px, options.most_side_px);
  const PictureSizes sizes(std::max(view.width_px, view.height_px));
  const int width = std::max(view.width_px, static_cast<int>(16.0 * sizes.text));
  Footer footer(sizes, width);
  footer.add_scale_bar(view.pixels_per_metre());
  add_legend(sizes, footer);

  Canvas canvas(width, view.height_px + static_cast<int>(footer.height()), kUnseenGround);
  canvas.paste(paled(shade_map(result.map, view)), 0, 0);
  const double side = kMapQuality.place_m * view.pixels_per_metre();
  canvas.clip({0.0, 0.0}, view.width_px, view.height_px);
  for (const QualityPlace& place : result.quality.places) {
    const Point centre = view.pixel_of(place.centre.cast<double>());
    const Point low{centre.x - 0.5 * side, centre.y - 0.5 * side};
    canvas.fill_rectangle(low, side, side, colour_of(place));
    if (place.is_crossed()) {
      draw_cross({low.x + 0.15 * side, low.y + 0.15 * side}, 0.7 * side,
                 std::max(1.0, 0.3 * sizes.path), canvas);
    }
  }
  for (const VisitContradiction& region : result.quality.contradictions) {
    if (is_contradiction(region)) draw_frame(view, region, std::max(2.0, sizes.path), canvas);
  }
  canvas.unclip();
  footer.draw(canvas, view.height_px);
  return canvas.image();
}

std::optional<QualityLayer> draw_quality_layer(const MapQuality& quality) {
  // Beyond, stray beams would make a picture of nothing.
  constexpr double kMostSidePx = 8192.0;
  if (quality.places.empty()) return {};
  Eigen::Vector2f low = quality.places.front().centre;
  Eigen::Vector2f high = low;
  for (const QualityPlace& place : quality.places) {
    low = low.cwiseMin(place.centre);
    high = high.cwiseMax(place.centre);
  }
  const double side = kMapQuality.place_m;
  const Eigen::Vector2d extent = (high - low).cast<double>() / side;
  if (extent.maxCoeff() >= kMostSidePx) return {};
  QualityLayer layer{.image = make_image(1 + static_cast<int>(std::lround(extent.x())),
                                         1 + static_cast<int>(std::lround(extent.y())), 4),
                     .corner = low.cast<double>() - Eigen::Vector2d::Constant(0.5 * side),
                     .resolution_m = side};
  for (const QualityPlace& place : quality.places) {
    const Eigen::Vector2d at = (place.centre - low).cast<double>() / side;
    const auto column = static_cast<std::size_t>(std::lround(at.x()));
    const auto row = static_cast<std::size_t>(layer.image.height - 1 - std::lround(at.y()));
    const Colour colour = colour_of(place);
    const std::size_t pixel = 4 * (row * static_cast<std::size_t>(layer.image.width) + column);
    std::size_t channel = pixel;
    for (const double value : {colour.red, colour.green, colour.blue, colour.alpha})
      layer.image.bytes[channel++] = static_cast<std::uint8_t>(std::lround(255.0 * value));
  }
  return layer;
}

}  // namespace loopstone
