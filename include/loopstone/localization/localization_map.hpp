#pragma once

#include <cstdint>
#include <memory>

#include "loopstone/grid/grid.hpp"

namespace loopstone {

/// A map made ready for localisation, once: distances to walls, bounds for searching it, free
/// space. Immutable, so it may be shared between threads and localizers.
class LocalizationMap {
 public:
  /// What making one takes for each cell, about; what it keeps is less.
  static constexpr std::uint64_t kBytesPerCell = 26;

  /// \param occupancy  in percent, -1 unknown, as nav_msgs/OccupancyGrid has it
  /// Throws UsageError when the map shows no wall or nothing free.
  explicit LocalizationMap(Grid<std::int8_t> occupancy);
  ~LocalizationMap();
  LocalizationMap(LocalizationMap&&) noexcept;
  LocalizationMap& operator=(LocalizationMap&&) noexcept;

  [[nodiscard]] const Grid<std::int8_t>& occupancy() const;
  [[nodiscard]] double free_area_m2() const;
  [[nodiscard]] std::size_t memory_bytes() const;

  /// What the localizer looks up in it.
  struct Tables;
  [[nodiscard]] const Tables& tables() const { return *tables_; }

 private:
  std::unique_ptr<const Tables> tables_;
};

}  // namespace loopstone
