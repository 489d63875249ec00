#include "report/picture_parts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "loopstone/base/hypotenuse.hpp"
#include "report/round_length.hpp"

namespace loopstone {
namespace {

const Colour kStart = hex_colour(0x16a34a);
const Colour kEnd = hex_colour(0xdc2626);

void draw_arrow(Canvas& canvas, Point from, Point to, double text_px) {
  canvas.line({from, to}, 0.11 * text_px, kInk);
  const double length = hypotenuse(to.x - from.x, to.y - from.y);
  const Point u{(to.x - from.x) / length * 0.4 * text_px, (to.y - from.y) / length * 0.4 * text_px};
  canvas.polygon({{to.x + 0.5 * u.x, to.y + 0.5 * u.y},
                  {to.x - u.x - 0.6 * u.y, to.y - u.y + 0.6 * u.x},
                  {to.x - u.x + 0.6 * u.y, to.y - u.y - 0.6 * u.x}},
                 kInk, 0.0, kInk);
}

}  // namespace

PictureSizes::PictureSizes(int side_px)
    : text(std::clamp(side_px / 70.0, 13.0, 34.0)),
      path(text / 9.0),
      marker(text * 0.5),
      padding(text * 1.1) {}

void draw_start_and_end(const Pose2& first, const Pose2& last, const MapView& view,
                        const PictureSizes& sizes, Canvas& canvas) {
  const Point start = view.pixel_of(first.translation());
  const Point end = view.pixel_of(last.translation());
  const double r = sizes.marker;
  const auto ahead = [&](double forward, double left) -> Point {
    const double c = std::cos(first.yaw);
    const double s = std::sin(first.yaw);
    return {start.x + r * (c * forward - s * left), start.y - r * (s * forward + c * left)};
  };
  const double edge = 0.25 * r;
  canvas.polygon({{end.x - 0.8 * r, end.y - 0.8 * r},
                  {end.x + 0.8 * r, end.y - 0.8 * r},
                  {end.x + 0.8 * r, end.y + 0.8 * r},
                  {end.x - 0.8 * r, end.y + 0.8 * r}},
                 kEnd, edge, kPaper);
  canvas.polygon({ahead(1.6, 0.0), ahead(-1.0, 1.0), ahead(-0.5, 0.0), ahead(-1.0, -1.0)}, kStart,
                 edge, kPaper);
  // Labels go to opposite sides when the two places coincide.
  const bool close = hypotenuse(start.x - end.x, start.y - end.y) < 4.0 * sizes.text;
  const bool start_above = !close || start.y <= end.y;
  const auto label = [&](Point at, const char* words, const Colour& colour, bool above) {
    at.y += above ? -1.6 * r : 1.6 * r + 0.75 * sizes.text;
    const double edge_px = 1.6 * sizes.text;
    at.x = std::clamp(at.x, edge_px, std::max(edge_px, view.width_px - edge_px));
    at.y = std::clamp(at.y, sizes.text, std::max(sizes.text, view.height_px - 0.4 * sizes.text));
    canvas.text_with_halo(at, words, 0.95 * sizes.text, colour, kPaper, 0.5);
  };
  label(start, "start", kStart, start_above);
  label(end, "end", kEnd, close && !start_above);
}

Footer::Footer(const PictureSizes& sizes, double width)
    : sizes_(sizes), width_(width), x_(sizes.padding) {}

void Footer::place(double width, std::function<void(Canvas&, Point)> draw) {
  if (x_ > sizes_.padding && x_ + width > width_ - sizes_.padding) {
    x_ = sizes_.padding;
    ++row_;
  }
  items_.push_back({x_, row_, std::move(draw)});
  x_ += width + 2.0 * sizes_.text;
}

void Footer::add_scale_bar(double pixels_per_metre) {
  const double text = sizes_.text;
  const double length_m = round_down(std::max(0.16 * width_, 3.0 * text) / pixels_per_metre);
  const double length = length_m * pixels_per_metre;
  place(length, [=](Canvas& canvas, Point at) {
    const double y = at.y + 0.25 * text;
    canvas.line(
        {{at.x, y - 0.35 * text}, {at.x, y}, {at.x + length, y}, {at.x + length, y - 0.35 * text}},
        0.13 * text, kInk);
    canvas.text({at.x + 0.5 * length, y - 0.45 * text}, fmt::format("{:g} m", length_m), text, kInk,
                0.5);
  });
}

void Footer::add_axes() {
  const double text = sizes_.text;
  const double size = 1.5 * text;
  place(size + 1.4 * text, [=](Canvas& canvas, Point at) {
    const Point corner{at.x + 0.4 * text, at.y + 0.55 * text};
    draw_arrow(canvas, corner, {corner.x + size, corner.y}, text);
    draw_arrow(canvas, corner, {corner.x, corner.y - size}, text);
    canvas.text({corner.x + size + 0.35 * text, corner.y + 0.3 * text}, "x", text, kInk);
    canvas.text({corner.x + 0.4 * text, corner.y - size + 0.3 * text}, "y", text, kInk);
  });
}

void Footer::add_swatch(const Colour& colour, const std::string& words) {
  const double side = 0.9 * sizes_.text;
  add("", side, words, [=](Canvas& canvas, Point at) {
    canvas.fill_rectangle({at.x, at.y - 0.5 * side}, side, side, colour);
  });
}

void Footer::add(const std::string& before, double symbol_width, const std::string& after,
                 std::function<void(Canvas&, Point)> draw) {
  const double text = sizes_.text;
  const double left = before.empty() ? 0.0 : text_width(before, text) + 0.5 * text;
  const double right = after.empty() ? 0.0 : text_width(after, text) + 0.5 * text;
  place(left + symbol_width + right, [=, draw = std::move(draw)](Canvas& canvas, Point at) {
    const double base = at.y + 0.36 * text;
    if (!before.empty()) canvas.text({at.x, base}, before, text, kInk);
    draw(canvas, {at.x + left, at.y});
    if (!after.empty())
      canvas.text({at.x + left + symbol_width + 0.5 * text, base}, after, text, kInk);
  });
}

double Footer::height() const { return (1.0 + 2.2 * (row_ + 1)) * sizes_.text; }

void Footer::draw(Canvas& canvas, double top) const {
  canvas.fill_rectangle({0.0, top}, width_, height(), kPaper);
  canvas.line({{0.0, top}, {width_, top}}, 1.0, kHairline);
  for (const Item& item : items_) {
    item.draw(canvas, {item.left, top + (1.6 + 2.2 * item.row) * sizes_.text});
  }
}

}  // namespace loopstone
