#include "loopstone/report/landmark_drawing.hpp"

#include <algorithm>
#include <cmath>

namespace loopstone {
namespace {

constexpr double kCellM = 0.05;
constexpr double kMostCells = 4e6;
constexpr double kLeastRadiusM = 0.1;
constexpr std::int8_t kOccupied = 100;

}  // namespace

Grid<std::int8_t> drawn_landmarks(std::span<const MappedLandmark> landmarks, double margin_m) {
  Eigen::Vector2d low = landmarks.empty() ? Eigen::Vector2d::Zero() : landmarks[0].position;
  Eigen::Vector2d high = low;
  for (const MappedLandmark& landmark : landmarks) {
    low = low.cwiseMin(landmark.position);
    high = high.cwiseMax(landmark.position);
  }
  low.array() -= margin_m;
  high.array() += margin_m;
  const double cell_m = std::max(kCellM, std::sqrt((high - low).prod() / kMostCells));
  Grid<std::int8_t> grid(frame_covering(low, high, cell_m, cell_m), 0);
  const GridFrame& frame = grid.frame();
  for (const MappedLandmark& landmark : landmarks) {
    const double radius = std::max({kLeastRadiusM, landmark.radius_m, cell_m});
    const Cell first = frame.cell_of(landmark.position.array() - radius);
    const Cell last = frame.cell_of(landmark.position.array() + radius);
    for (int row = first.row; row <= last.row; ++row) {
      for (int column = first.column; column <= last.column; ++column) {
        const Cell cell{column, row};
        if (frame.contains(cell) && (frame.centre_of(cell) - landmark.position).norm() <= radius)
          grid[cell] = kOccupied;
      }
    }
  }
  return grid;
}

}  // namespace loopstone
