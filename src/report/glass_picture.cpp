#include <algorithm>
#include <optional>
#include <vector>

#include "loopstone/grid/grid_cells.hpp"
#include "loopstone/mapping/glass_survey.hpp"
#include "report/site_pictures.hpp"

namespace loopstone {

namespace {

// Told apart by hue, and by lightness where eyes tell no hues.
const std::vector<Colour> kGlassRamp = {hex_colour(0xf0a3c4), hex_colour(0xb0004e)};
const Colour kSolid = hex_colour(0x0072b2, 0.75);

Colour glass_colour(double probability) {
  return ramp_colour(kGlassRamp,
                     (probability - kGlassSurvey.suspected) / (1.0 - kGlassSurvey.suspected));
}

}  // namespace

Image draw_glass_picture(const SiteGrids& grids, const SiteGround& ground) {
  SiteSheet sheet(ground);
  sheet.add_ramp(
      "glass, likely to 50 %",
      [](double share) {
        return glass_colour(kGlassSurvey.suspected + (1.0 - kGlassSurvey.suspected) * share);
      },
      "100 %");
  sheet.add_swatch(kSolid, "looked at from as many sides, and solid");
  sheet.tint([&](Cell cell) -> std::optional<Colour> {
    if (grids.glass[cell] < 0.0F) return {};
    return kSolid;
  });
  const GridFrame& frame = grids.glass.frame();
  const double radius =
      std::max(0.75 * frame.resolution * sheet.view().pixels_per_metre(), 0.8 * sheet.sizes().path);
  return sheet.draw([&](Canvas& canvas) {
    for_each_cell(frame, [&](Cell cell) {
      const auto probability = static_cast<double>(grids.glass[cell]);
      if (probability < kGlassSurvey.suspected) return;
      const Colour colour = glass_colour(probability);
      canvas.disc(sheet.view().pixel_of(frame.centre_of(cell)), radius, colour, 0.0, colour);
    });
  });
}

}  // namespace loopstone
