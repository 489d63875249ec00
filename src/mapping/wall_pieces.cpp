#include "mapping/wall_pieces.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "loopstone/grid/block_grid.hpp"
#include "loopstone/registration/surface_grid.hpp"

namespace loopstone {
namespace {

struct PieceSum : SurfaceSum {
  std::int16_t scans = 0;
  std::int16_t last_scan = -1;
};

/// Two sides of a thin wall, or the two walls of a corner.
struct PieceCell {
  std::array<PieceSum, 2> sums{};
};

bool faces_same(const PieceSum& sum, const Eigen::Vector2f& normal) {
  return faces_like(sum, normal.x(), normal.y(), kSameFacing);
}

void add_to(PieceCell& cell, const Eigen::Vector2f& offset, const Eigen::Vector2f& normal,
            std::int16_t scan) {
  for (PieceSum& sum : cell.sums) {
    if (sum.weight != 0.0F && !faces_same(sum, normal)) continue;
    sum.weight += 1.0F;
    sum.x += offset.x();
    sum.y += offset.y();
    sum.normal_x += normal.x();
    sum.normal_y += normal.y();
    if (sum.last_scan != scan) ++sum.scans;
    sum.last_scan = scan;
    return;
  }
}

BlockGrid<PieceCell> sums_of(std::span<const JudgedScan> scans) {
  BlockGrid<PieceCell> grid(kWallPieces.piece_m);
  for (std::size_t s = 0; s < scans.size(); ++s) {
    for (const WallReturn& seen : scans[s].returns) {
      const Cell at = grid.cell_of(static_cast<double>(seen.surface.x()),
                                   static_cast<double>(seen.surface.y()));
      for (int row = at.row - 1; row <= at.row + 1; ++row) {
        for (int column = at.column - 1; column <= at.column + 1; ++column) {
          const Eigen::Vector2f centre = grid.centre_of({column, row}).cast<float>();
          add_to(grid.at({column, row}), seen.surface - centre, seen.normal,
                 static_cast<std::int16_t>(s));
        }
      }
    }
  }
  return grid;
}

}  // namespace

StretchWalls stretch_walls(std::span<const JudgedScan> scans) {
  StretchWalls walls;
  if (scans.empty()) return walls;
  const BlockGrid<PieceCell> grid = sums_of(scans);
  grid.for_each([&](Cell cell, const PieceCell& piece) {
    for (const PieceSum& sum : piece.sums) {
      if (sum.scans < kWallPieces.least_scans) continue;
      const Eigen::Vector2f normal(sum.normal_x, sum.normal_y);
      if (normal.norm() < static_cast<float>(kWallPieces.least_straightness) * sum.weight) continue;
      const Eigen::Vector2f offset(sum.x / sum.weight, sum.y / sum.weight);
      if (offset.cwiseAbs().maxCoeff() > static_cast<float>(0.5 * kWallPieces.piece_m)) continue;
      walls.pieces.push_back({grid.centre_of(cell).cast<float>() + offset, normal.normalized(),
                              scans.front().stretch});
    }
  });
  for (const JudgedScan& scan : scans) {
    for (const WallReturn& seen : scan.returns) {
      const Cell at = grid.cell_of(static_cast<double>(seen.surface.x()),
                                   static_cast<double>(seen.surface.y()));
      const PieceCell* piece = grid.find(at);
      if (piece == nullptr) continue;
      for (const PieceSum& sum : piece->sums) {
        if (sum.scans < kWallPieces.least_scans || !faces_same(sum, seen.normal)) continue;
        const Eigen::Vector2f mean =
            grid.centre_of(at).cast<float>() + Eigen::Vector2f(sum.x, sum.y) / sum.weight;
        const Eigen::Vector2f normal = Eigen::Vector2f(sum.normal_x, sum.normal_y).normalized();
        walls.spread_m.push_back(std::abs(normal.dot(seen.surface - mean)));
        break;
      }
    }
  }
  return walls;
}

}  // namespace loopstone
