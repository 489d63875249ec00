#include "loopstone/report/site_grids.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <iterator>
#include <vector>

#include "formats/atomic_file.hpp"
#include "loopstone/formats/ros_map.hpp"
#include "loopstone/grid/grid_cells.hpp"
#include "loopstone/report/site_outputs.hpp"
#include "report/mask_files.hpp"
#include "report/output_files.hpp"
#include "report/site_pictures.hpp"

namespace loopstone {

namespace {

std::int8_t capped(double value) {
  constexpr double kMost = 100.0;
  return static_cast<std::int8_t>(std::lround(std::min(value, kMost)));
}

template <typename Value>
CellStates mask_of(const GridFrame& frame, Value&& value) {
  CellStates mask(frame, kUnknownCell);
  for_each_cell(frame, [&](Cell cell) { mask[cell] = value(cell); });
  return mask;
}

CellStates visits_mask(const VisitCoverage& coverage) {
  return mask_of(coverage.visits.frame(), [&](Cell cell) {
    const int visits = coverage.visits[cell];
    return visits == 0 ? kUnknownCell : capped(visits);
  });
}

/// Rounded up: 0 is what the newest session saw, and nothing else.
CellStates days_mask(const VisitCoverage& coverage) {
  return mask_of(coverage.visits.frame(), [&](Cell cell) {
    const auto days = coverage.days_since_seen(cell);
    if (!days) return kUnknownCell;
    return coverage.seen_by_newest(cell) ? std::int8_t{0} : capped(std::max(1.0, std::ceil(*days)));
  });
}

CellStates travel_mask(const Grid<CellTravel>& travel, const OccupancyMap& map) {
  return mask_of(travel.frame(), [&](Cell cell) {
    const int passes = travel[cell].passes;
    return passes == 0 && !is_floor(map, cell) ? kUnknownCell : capped(passes);
  });
}

CellStates glass_mask(const Grid<float>& glass) {
  return mask_of(glass.frame(), [&](Cell cell) {
    const auto probability = static_cast<double>(glass[cell]);
    return probability < 0.0 ? kUnknownCell : capped(100.0 * probability);
  });
}

std::string travel_csv(const Grid<CellTravel>& travel) {
  fmt::memory_buffer text;
  const auto to = std::back_inserter(text);
  fmt::format_to(to, "x_m,y_m,passes,speed_m_s\n");
  const GridFrame& frame = travel.frame();
  for_each_cell(frame, [&](Cell cell) {
    const CellTravel& driven = travel[cell];
    if (driven.passes == 0) return;
    const Eigen::Vector2d at = frame.centre_of(cell);
    fmt::format_to(to, "{:.3f},{:.3f},{},", at.x(), at.y(), driven.passes);
    if (const auto speed = driven.speed_m_s()) fmt::format_to(to, "{:.3f}", *speed);
    text.push_back('\n');
  });
  return fmt::to_string(text);
}

/// Of all passes, and what one cell of ten is below and above.
void add_speeds(const Grid<CellTravel>& travel, SiteFigures& figures) {
  double sum_m_s = 0.0;
  std::size_t passes = 0;
  std::vector<float> speeds;
  for (const CellTravel& cell : travel.cells()) {
    figures.most_passes = std::max<int>(figures.most_passes, cell.passes);
    if (cell.timed == 0) continue;
    sum_m_s += static_cast<double>(cell.speed_sum_m_s);
    passes += cell.timed;
    speeds.push_back(*cell.speed_m_s());
  }
  if (speeds.empty()) return;
  figures.speed_m_s = sum_m_s / static_cast<double>(passes);
  const auto at = [&](std::size_t place) {
    const auto nth = speeds.begin() + static_cast<std::ptrdiff_t>(place);
    std::ranges::nth_element(speeds, nth);
    return static_cast<double>(*nth);
  };
  figures.speed_low_m_s = at(speeds.size() / 10);
  figures.speed_high_m_s = at(speeds.size() - 1 - speeds.size() / 10);
}

}  // namespace

SiteFigures figures_of(const SiteGrids& grids, const OccupancyMap& map,
                       std::span<const SiteCorrection> edits) {
  SiteFigures figures{.sessions = grids.coverage.begins.size(),
                      .floor = figures_of(grids.coverage, grids.travel, map)};
  add_speeds(grids.travel, figures);
  figures.panes = suspected_panes(grids.glass);
  for (const SiteCorrection& one : edits) {
    figures.edits.push_back({.edit = one.edit.id, .kind = std::string(to_string(one.edit.kind))});
    if (one.edit.kind != SiteEditKind::kExclude) figures.edits.back().cells = one.cells;
  }
  return figures;
}

void write_site_grids(const SiteGrids& grids, const SiteFigures& figures,
                      const Grid<float>& movable, const OccupancyMap& map,
                      const std::string& folder, Threads threads) {
  make_folder(folder);
  const SiteGround ground(map);
  const auto write_picture = [&](const char* name, const Image& picture) {
    write_png(folder + "/" + name, picture, kPngCompression);
  };
  // The pictures take longest, so they come first.
  const std::vector<std::function<void()>> makers = {
      [&] { write_picture("coverage.png", draw_coverage_picture(grids, map, ground)); },
      [&] { write_picture("travel.png", draw_travel_picture(grids, figures, ground)); },
      [&] { write_picture("glass.png", draw_glass_picture(grids, ground)); },
      [&] { write_movable(movable, map, folder); },
      [&] { write_file_atomically(folder + "/travel.csv", travel_csv(grids.travel)); },
      [&] { write_mask(visits_mask(grids.coverage), folder, "coverage"); },
      [&] { write_mask(days_mask(grids.coverage), folder, "coverage_days"); },
      [&] { write_mask(travel_mask(grids.travel, map), folder, "travel"); },
      [&] { write_mask(glass_mask(grids.glass), folder, "glass"); },
  };
  parallel_for(makers.size(), threads, [&](std::size_t i) { makers[i](); });
}

}  // namespace loopstone
