#include "registration/shift_sums.hpp"

namespace loopstone {

void ScanOnLevel::lay(const CellList& cells, int column, int row) {
  const std::size_t count = cells.size();
  run_offsets_.resize(count);
  lane_indexes_.resize(count);
  row_indexes_.resize(count);
  offsets_.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    const int shifted = cells.columns[i] + column;
    run_offsets_[i] = level_->run_offset(shifted);
    lane_indexes_[i] = shifted >> level_->level;
    row_indexes_[i] = rows_->index_of(cells.rows[i] + row);
  }
}

void ScanOnLevel::choose_lanes(int blocks) {
  const std::size_t count = offsets_.size();
  const int lowest = level_->lowest_index - MaxPyramid::kLanes;
  const int highest = level_->highest_index + 1;
  for (std::size_t i = 0; i < count; ++i) {
    const int index = std::clamp(lane_indexes_[i] + blocks, lowest, highest) - lowest;
    offsets_[i] = run_offsets_[i] + static_cast<std::uint32_t>(index);
  }
}

void ScanOnLevel::add(int row_shift, std::size_t begin, std::size_t end, LaneSums& sums) const {
  // 16 bits hold 256 values of 8 bits. The compiler keeps this array in registers, eight lanes in
  // each.
  std::array<std::uint16_t, MaxPyramid::kLanes> lanes{};
  const std::uint8_t* const data = level_->data.data();
  const std::uint32_t* const rows = rows_->data() + row_shift;
  const std::uint32_t* const offsets = offsets_.data();
  const std::int32_t* const row_indexes = row_indexes_.data();
  for (std::size_t i = begin; i < end; ++i) {
    const std::uint8_t* const values = data + rows[row_indexes[i]] + offsets[i];
    for (std::size_t lane = 0; lane < lanes.size(); ++lane)
      lanes[lane] = static_cast<std::uint16_t>(lanes[lane] + values[lane]);
  }
  for (std::size_t lane = 0; lane < lanes.size(); ++lane) sums[lane] += lanes[lane];
}

}  // namespace loopstone
