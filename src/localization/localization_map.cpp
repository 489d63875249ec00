#include "loopstone/localization/localization_map.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "localization/map_tables.hpp"
#include "loopstone/base/error.hpp"

namespace loopstone {

namespace {

constexpr std::int8_t kOccupiedPercent = 65;

/// A wall is known to a cell, so the finer the map, the finer the model; below 5 cm a laser's own
/// errors matter.
LikelihoodFieldOptions weigher_options(double resolution_m) {
  LikelihoodFieldOptions options;
  options.hit_sigma_m = std::max(0.1, 1.5 * resolution_m);
  return options;
}

/// Two places that look alike are drawn a little differently, as their walls lie otherwise in the
/// cells. Such differences are the same for every scan, so they must not add up: no distance within
/// a cell counts.
Grid<float> forgiving_distances(const Grid<std::int8_t>& occupancy, const MapField& field) {
  Grid<float> distances = field.distances();
  const auto forgiven = static_cast<float>(distances.frame().resolution + 0.01);
  for (float& distance : distances.cells()) distance = std::max(0.0F, distance - forgiven);
  const auto& percents = occupancy.cells();
  for (std::size_t i = 0; i < percents.size(); ++i) {
    if (percents[i] < 0 && distances.cells()[i] > 0.0F)
      distances.cells()[i] = std::numeric_limits<float>::quiet_NaN();
  }
  return distances;
}

/// What no place explains, people above all, must not decide between places: one return counts for
/// no more than 1.4.
LikelihoodFieldOptions judge_options(double resolution_m) {
  LikelihoodFieldOptions options = weigher_options(resolution_m);
  options.random_share = 0.9;
  options.max_range_m = 6.0;
  return options;
}

Grid<std::int8_t> checked(Grid<std::int8_t> map) {
  const auto& cells = map.cells();
  const bool walls = std::any_of(cells.begin(), cells.end(),
                                 [](std::int8_t percent) { return percent >= kOccupiedPercent; });
  const bool free = std::any_of(cells.begin(), cells.end(), [](std::int8_t percent) {
    return percent >= 0 && percent < kOccupiedPercent;
  });
  if (!walls) {
    throw UsageError(
        "the map shows no wall, so a scan can't be compared with it; check its thresholds");
  }
  if (!free) {
    throw UsageError("the map shows nothing free where a robot could be; check its thresholds");
  }
  return map;
}

/// 1 where a beam ends: occupied cells.
Grid<std::uint8_t> solid_cells(const Grid<std::int8_t>& occupancy) {
  Grid<std::uint8_t> solid(occupancy.frame());
  std::transform(occupancy.cells().begin(), occupancy.cells().end(), solid.cells().begin(),
                 [](std::int8_t percent) {
                   return static_cast<std::uint8_t>(percent >= kOccupiedPercent ? 1 : 0);
                 });
  return solid;
}

}  // namespace

LocalizationMap::Tables::Tables(Grid<std::int8_t> map)
    : occupancy(checked(std::move(map))),
      search(occupancy),
      weigher(occupancy, weigher_options(occupancy.frame().resolution)),
      judge(forgiving_distances(occupancy, search.field()),
            judge_options(occupancy.frame().resolution)),
      caster(solid_cells(occupancy), kCastMaxM) {
  const auto free = std::count_if(occupancy.cells().begin(), occupancy.cells().end(),
                                  [](std::int8_t p) { return p >= 0 && p < kOccupiedPercent; });
  const double cell = occupancy.frame().resolution;
  free_area_m2 = static_cast<double>(free) * cell * cell;
}

LocalizationMap::LocalizationMap(Grid<std::int8_t> occupancy)
    : tables_(std::make_unique<const Tables>(std::move(occupancy))) {}
LocalizationMap::~LocalizationMap() = default;
LocalizationMap::LocalizationMap(LocalizationMap&&) noexcept = default;
LocalizationMap& LocalizationMap::operator=(LocalizationMap&&) noexcept = default;

const Grid<std::int8_t>& LocalizationMap::occupancy() const { return tables_->occupancy; }
double LocalizationMap::free_area_m2() const { return tables_->free_area_m2; }
std::size_t LocalizationMap::memory_bytes() const {
  return tables_->occupancy.cells().size() + tables_->search.memory_bytes() +
         tables_->weigher.memory_bytes() + tables_->judge.memory_bytes() +
         tables_->caster.memory_bytes();
}

}  // namespace loopstone
