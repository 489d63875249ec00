#include "loopstone/report/site_outputs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "formats/atomic_file.hpp"
#include "loopstone/formats/ros_map.hpp"
#include "loopstone/grid/grid_cells.hpp"
#include "report/canvas.hpp"
#include "report/map_view.hpp"
#include "report/mask_files.hpp"
#include "report/output_files.hpp"
#include "report/site_masks.hpp"
#include "report/site_sheet.hpp"

namespace loopstone {

namespace {

// The report's colours: told apart by hue, and by lightness where eyes tell no hues.
const Colour kAppeared = hex_colour(0x0072b2);
const Colour kGone = hex_colour(0xd55e00);
const Colour kMovable = hex_colour(0xb0004e);

void fill_cell(const GridFrame& frame, Cell cell, const Colour& colour, const MapView& view,
               Canvas& canvas) {
  const Eigen::Vector2d half = Eigen::Vector2d::Constant(0.5 * frame.resolution);
  const Point low = view.pixel_of(frame.centre_of(cell) - half);
  const double side = std::max(1.0, frame.resolution * view.pixels_per_metre());
  canvas.fill_rectangle({low.x, low.y - side}, side, side, colour);
}

/// Occupied cells of a map within a change.
void fill_change(const MapChange& change, const OccupancyMap& map, const MapView& view,
                 const Colour& colour, Canvas& canvas) {
  const GridFrame& frame = map.log_odds.frame();
  const Cell low = frame.cell_of(change.low);
  const Cell high = frame.cell_of(change.high);
  for (int row = std::max(0, low.row); row <= std::min(frame.rows - 1, high.row); ++row) {
    for (int column = std::max(0, low.column); column <= std::min(frame.columns - 1, high.column);
         ++column) {
      const Cell cell{column, row};
      if (map.observed[cell] != 0 && map.probability(cell) > kVisitLedger.occupied)
        fill_cell(frame, cell, colour, view, canvas);
    }
  }
}

std::string changes_csv(std::span<const MapChange> changes) {
  std::string text = "what,x_low_m,y_low_m,x_high_m,y_high_m,area_m2\n";
  for (const MapChange& change : changes) {
    text += fmt::format("{},{:.3f},{:.3f},{:.3f},{:.3f},{:.4f}\n",
                        change.appeared ? "appeared" : "gone", change.low.x(), change.low.y(),
                        change.high.x(), change.high.y(), change.area_m2);
  }
  return text;
}

}  // namespace

Image draw_changes_picture(std::span<const MapChange> changes, const OccupancyMap& before,
                           const OccupancyMap& now) {
  SiteSheet sheet(now);
  sheet.add_swatch(kAppeared, "appeared");
  sheet.add_swatch(kGone, "gone");
  return sheet.draw([&](Canvas& canvas) {
    for (const MapChange& change : changes) {
      const Colour& colour = change.appeared ? kAppeared : kGone;
      fill_change(change, change.appeared ? now : before, sheet.view(), colour, canvas);
      const Eigen::Vector2d margin = Eigen::Vector2d::Constant(0.2);
      const Point low = sheet.view().pixel_of(change.low - margin);
      const Point high = sheet.view().pixel_of(change.high + margin);
      canvas.line({low, {high.x, low.y}, high, {low.x, high.y}, low},
                  std::max(2.0, 0.7 * sheet.sizes().path), colour);
    }
  });
}

Image draw_movable_picture(const Grid<float>& movable, const OccupancyMap& map) {
  SiteSheet sheet(map);
  sheet.add_swatch(kMovable, "stands there on some visits: the darker, the more often");
  return sheet.draw([&](Canvas& canvas) {
    const GridFrame& frame = movable.frame();
    for_each_cell(frame, [&](Cell cell) {
      const float share = movable[cell];
      if (share <= 0.0F) return;
      Colour colour = kMovable;
      colour.alpha = 0.25 + 0.75 * static_cast<double>(share);
      fill_cell(frame, cell, colour, sheet.view(), canvas);
    });
  });
}

void write_changes(std::span<const MapChange> changes, const OccupancyMap& before,
                   const OccupancyMap& now, const std::string& folder, bool force) {
  OutputFolder made(folder, force);
  AtomicFile table(made.file("changes.csv"));
  table.write(changes_csv(changes));
  table.commit();
  write_png(made.file("changes.png"), draw_changes_picture(changes, before, now), kPngCompression);
  made.keep();
}

CellStates movable_mask(const Grid<float>& movable, const OccupancyMap& map) {
  CellStates percent(movable.frame(), kUnknownCell);
  for (std::size_t i = 0; i < percent.cells().size(); ++i) {
    if (map.observed.cells()[i] != 0)
      percent.cells()[i] = static_cast<std::int8_t>(std::lround(100.0F * movable.cells()[i]));
  }
  return percent;
}

void write_movable(const Grid<float>& movable, const OccupancyMap& map, const std::string& folder) {
  make_folder(folder);
  write_png(folder + "/movable.png", draw_movable_picture(movable, map), kPngCompression);
  write_mask(movable_mask(movable, map), folder, "movable");
}

}  // namespace loopstone
