#include "report/site_sheet.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "loopstone/report/map_picture.hpp"

namespace loopstone {

SiteGround::SiteGround(const OccupancyMap& map)
    : view(view_of(map, {}, MapPictureOptions{}.target_side_px, MapPictureOptions{}.most_side_px)),
      image(paled(shade_map(map, view))) {}

SiteSheet::SiteSheet(SiteGround ground)
    : view_(ground.view),
      sizes_(std::max(view_.width_px, view_.height_px)),
      width_(std::max(view_.width_px, static_cast<int>(16.0 * sizes_.text))),
      footer_(sizes_, width_),
      map_(std::move(ground.image)) {
  footer_.add_scale_bar(view_.pixels_per_metre());
  footer_.add_axes();
}

void SiteSheet::add_swatch(const Colour& colour, const std::string& words) {
  footer_.add_swatch(colour, words);
}

void SiteSheet::add_hatched(const Colour& ground, const Colour& stripes, const std::string& words) {
  const double side = 0.9 * sizes_.text;
  footer_.add("", side, words, [=](Canvas& canvas, Point at) {
    const double top = at.y - 0.5 * side;
    canvas.fill_rectangle({at.x, top}, side, side, ground);
    const double third = side / 3.0;
    for (const double from : {0.0, 2.0 * third}) {
      const double low = std::min(side, from + third);
      canvas.polygon({{at.x, top + from}, {at.x, top + low}, {at.x + low, top}, {at.x + from, top}},
                     stripes, 0.0, stripes);
    }
    canvas.polygon({{at.x + side, top + third},
                    {at.x + side, top + 2.0 * third},
                    {at.x + 2.0 * third, top + side},
                    {at.x + third, top + side}},
                   stripes, 0.0, stripes);
  });
}

void SiteSheet::add_ramp(const std::string& from, const std::function<Colour(double)>& colour_at,
                         const std::string& to) {
  const double length = 6.0 * sizes_.text;
  const double height = 0.7 * sizes_.text;
  footer_.add(from, length, to, [=](Canvas& canvas, Point at) {
    constexpr int kSteps = 48;
    for (int i = 0; i < kSteps; ++i) {
      canvas.fill_rectangle({at.x + length * i / kSteps, at.y - 0.5 * height},
                            length / kSteps + 0.6, height, colour_at((i + 0.5) / kSteps));
    }
  });
}

std::optional<Colour> SiteSheet::colour_at(
    int x, int y, const std::function<std::optional<Colour>(Cell)>& colour_of) const {
  const auto first = [&](int low, int pixel) {
    return low + pixel * view_.cells_per_pixel / view_.pixels_per_cell;
  };
  const Cell corner{first(view_.low.column, x), first(view_.low.row, view_.height_px - 1 - y)};
  for (int row = corner.row; row < corner.row + view_.cells_per_pixel; ++row) {
    for (int column = corner.column; column < corner.column + view_.cells_per_pixel; ++column) {
      const Cell cell{column, row};
      if (!view_.frame.contains(cell)) continue;
      if (const auto colour = colour_of(cell)) return colour;
    }
  }
  return {};
}

void SiteSheet::tint(const std::function<std::optional<Colour>(Cell)>& colour_of) {
  const int side = view_.pixels_per_cell;
  // A cell's pixels are alike: each is asked for once.
  for (int top = view_.height_px; top > 0; top -= side) {
    for (int left = 0; left < view_.width_px; left += side) {
      const auto colour = colour_at(left, top - 1, colour_of);
      if (!colour) continue;
      for (int y = std::max(0, top - side); y < top; ++y) {
        for (int x = left; x < std::min(left + side, view_.width_px); ++x) {
          std::uint8_t* pixel =
              map_.bytes.data() +
              3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(view_.width_px) +
                   static_cast<std::size_t>(x));
          for (const double to : {colour->red, colour->green, colour->blue}) {
            const double mixed = *pixel + colour->alpha * (255.0 * to - *pixel);
            *pixel++ = static_cast<std::uint8_t>(std::lround(mixed));
          }
        }
      }
    }
  }
}

Image SiteSheet::draw(const std::function<void(Canvas&)>& on_top) const {
  Canvas canvas(width_, view_.height_px + static_cast<int>(footer_.height()), kPaper);
  canvas.paste(map_, 0, 0);
  canvas.clip({0.0, 0.0}, view_.width_px, view_.height_px);
  if (on_top) on_top(canvas);
  canvas.unclip();
  footer_.draw(canvas, view_.height_px);
  return canvas.image();
}

Colour ramp_colour(const std::vector<Colour>& ramp, double share) {
  const double place = std::clamp(share, 0.0, 1.0) * static_cast<double>(ramp.size() - 1);
  const std::size_t i = std::min(static_cast<std::size_t>(place), ramp.size() - 2);
  const double t = place - static_cast<double>(i);
  const auto mix = [t](double a, double b) { return a + t * (b - a); };
  const Colour& a = ramp[i];
  const Colour& b = ramp[i + 1];
  return {mix(a.red, b.red), mix(a.green, b.green), mix(a.blue, b.blue), mix(a.alpha, b.alpha)};
}

}  // namespace loopstone
