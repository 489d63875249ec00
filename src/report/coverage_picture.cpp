#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "report/site_pictures.hpp"

namespace loopstone {

namespace {

// Told apart by hue, and by lightness where eyes tell no hues.
const std::vector<Colour> kSeen = {hex_colour(0xdbeafe), hex_colour(0x8fbcf7),
                                   hex_colour(0x3f7ff0)};
const std::vector<Colour> kUnseen = {hex_colour(0xfef0c3), hex_colour(0xf5b945),
                                     hex_colour(0xb8590f)};
const Colour kDriven = hex_colour(0xffffff);
/// Hatching of the floor that was driven [cells].
constexpr int kHatch = 4;

std::string days_ago(double days) {
  const double whole = std::max(1.0, std::ceil(days));
  return fmt::format("{:.0f} {}", whole, whole > 1.0 ? "days ago" : "day ago");
}

void add_legend(const SiteGrids& grids, SiteSheet& sheet) {
  const std::size_t sessions = grids.coverage.begins.size();
  sheet.add_ramp(
      "seen by 1", [](double share) { return ramp_colour(kSeen, share); },
      sessions == 1 ? "session" : fmt::format("{} sessions", sessions));
  if (sessions > 1) {
    sheet.add_ramp(
        "not by the newest: last 1 day ago",
        [](double share) { return ramp_colour(kUnseen, share); },
        days_ago(grids.coverage.longest_days()));
  }
  sheet.add_hatched(ramp_colour(kSeen, 1.0), kDriven, "driven over");
}

}  // namespace

Image draw_coverage_picture(const SiteGrids& grids, const OccupancyMap& map,
                            const SiteGround& ground) {
  const VisitCoverage& coverage = grids.coverage;
  const auto others = static_cast<double>(coverage.begins.size()) - 1.0;
  const double longest = coverage.longest_days();
  SiteSheet sheet(ground);
  sheet.tint([&](Cell cell) -> std::optional<Colour> {
    if (map.observed[cell] == 0) return {};
    if (!is_floor(map, cell)) return kInk;
    if (grids.travel[cell].passes > 0 && (cell.column + cell.row) % kHatch < kHatch / 2)
      return kDriven;
    if (coverage.seen_by_newest(cell))
      return ramp_colour(kSeen, others > 0.0 ? (coverage.visits[cell] - 1.0) / others : 0.0);
    return ramp_colour(kUnseen, *coverage.days_since_seen(cell) / std::max(longest, 1.0));
  });
  add_legend(grids, sheet);
  return sheet.draw();
}

}  // namespace loopstone
