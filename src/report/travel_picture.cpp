#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "report/site_pictures.hpp"

namespace loopstone {

namespace {

const Colour kStood = hex_colour(0x6b7280, 0.55);
/// So many passes and more are drawn at full strength.
constexpr double kOften = 4.0;
constexpr double kWeakest = 0.55;

}  // namespace

Image draw_travel_picture(const SiteGrids& grids, const SiteFigures& figures,
                          const SiteGround& ground) {
  // To the next tenth.
  const double top_m_s =
      std::ceil(std::max(1.0, 10.0 * figures.speed_high_m_s.value_or(0.0))) / 10.0;
  SiteSheet sheet(ground);
  bool stood = false;
  sheet.tint([&](Cell cell) -> std::optional<Colour> {
    const CellTravel& travel = grids.travel[cell];
    if (travel.passes == 0) return {};
    const auto speed = travel.speed_m_s();
    stood = stood || !speed;
    if (!speed) return kStood;
    Colour colour = time_colour(static_cast<double>(*speed) / top_m_s);
    colour.alpha =
        kWeakest + (1.0 - kWeakest) * std::min(1.0, (travel.passes - 1.0) / (kOften - 1.0));
    return colour;
  });
  sheet.add_ramp("driven at 0", time_colour, fmt::format("{:g} m/s or more", top_m_s));
  Colour once = time_colour(0.5);
  once.alpha = kWeakest;
  sheet.add_swatch(once, "once");
  sheet.add_swatch(time_colour(0.5), "4 times or more");
  if (stood) sheet.add_swatch(kStood, "turned or stood");
  return sheet.draw();
}

}  // namespace loopstone
