#include "loopstone/mapping/glass_survey.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <utility>

#include "loopstone/grid/block_grid.hpp"
#include "loopstone/grid/grid_cells.hpp"
#include "mapping/cell_pieces.hpp"
#include "mapping/glass_evidence.hpp"
#include "mapping/glass_looks.hpp"
#include "mapping/shared_grid.hpp"
#include "mapping/wall_pieces.hpp"

namespace loopstone {

namespace {

/// How far to both sides of its line a piece is drawn.
constexpr double kAcrossCells = 0.75;

/// Calls take(pane, its cells) for what is suspected and hangs together.
template <typename Take>
void for_each_pane(const Grid<float>& probability, Take&& take) {
  const GridFrame& frame = probability.frame();
  Grid<std::uint8_t> suspected(frame);
  for_each_cell(frame, [&](Cell cell) {
    suspected[cell] = static_cast<double>(probability[cell]) >= kGlassSurvey.suspected ? 1 : 0;
  });
  CellPieces pieces(std::move(suspected),
                    static_cast<int>(std::ceil(kGlassSurvey.gap_m / frame.resolution)));
  pieces.for_each([&](const std::vector<Cell>& cells) {
    const Eigen::Vector2d half = Eigen::Vector2d::Constant(0.5 * frame.resolution);
    GlassPane pane{.low = frame.centre_of(cells.front()), .high = frame.centre_of(cells.front())};
    for (const Cell cell : cells) {
      pane.low = pane.low.cwiseMin(frame.centre_of(cell));
      pane.high = pane.high.cwiseMax(frame.centre_of(cell));
      pane.probability = std::max(pane.probability, static_cast<double>(probability[cell]));
    }
    pane.low -= half;
    pane.high += half;
    take(pane, cells);
  });
}

/// What is too small for a pane, or sure nowhere, is not known.
Grid<float> without_specks(Grid<float> probability) {
  std::vector<Cell> specks;
  for_each_pane(probability, [&](const GlassPane& pane, const std::vector<Cell>& cells) {
    if (pane.length_m() < kGlassSurvey.least_pane_m || pane.probability < kGlassSurvey.sure)
      specks.insert(specks.end(), cells.begin(), cells.end());
  });
  for (const Cell cell : specks) probability[cell] = -1.0F;
  return probability;
}

}  // namespace

/// Calls visit(cell, ratio) once for each cell of a drive's pieces; where several lie the one that
/// tells the most.
template <typename Visit>
void GlassSurvey::draw(const std::vector<Piece>& pieces, double resolution_m, Visit&& visit) {
  struct Told {
    float ratio = 0.0F;
    bool known = false;
  };
  BlockGrid<Told> told(resolution_m);
  for (const Piece& piece : pieces) {
    const Eigen::Vector2d at = piece.position.cast<double>();
    const Eigen::Vector2d normal = piece.normal.cast<double>();
    const double along_m = 0.5 * kWallPieces.piece_m + 0.5 * resolution_m;
    const double across_m = kAcrossCells * resolution_m;
    const double reach_m = along_m + across_m;
    const Cell low = told.cell_of(at.x() - reach_m, at.y() - reach_m);
    const Cell high = told.cell_of(at.x() + reach_m, at.y() + reach_m);
    for (int row = low.row; row <= high.row; ++row) {
      for (int column = low.column; column <= high.column; ++column) {
        const Eigen::Vector2d off = told.centre_of({column, row}) - at;
        const double along = normal.x() * off.y() - normal.y() * off.x();
        if (std::abs(along) > along_m || std::abs(normal.dot(off)) > across_m) continue;
        Told& cell = told.at({column, row});
        if (!cell.known || std::abs(piece.log_ratio) > std::abs(cell.ratio))
          cell = {piece.log_ratio, true};
      }
    }
  }
  told.for_each([&](Cell cell, const Told& of) {
    if (of.known) visit(cell, of.ratio);
  });
}

void GlassSurvey::add(std::span<const PosedScan> scans, double footprint_radius_m,
                      Threads threads) {
  std::vector<Piece>& pieces = drives_.emplace_back();
  for (const LookedAtPiece& piece : surface_looks(scans, footprint_radius_m, threads)) {
    const bool flat = std::ranges::any_of(piece.looks, [](const SurfaceLook& look) {
      return look.incidence_rad > kGlassSurvey.flat_rad;
    });
    if (!flat || std::ssize(piece.looks) < kGlassSurvey.least_looks) continue;
    const double ratio = std::clamp(glass_log_ratio(piece.looks), -kGlassSurvey.most_log_ratio,
                                    kGlassSurvey.most_log_ratio);
    pieces.push_back({piece.position, piece.normal, static_cast<float>(ratio)});
  }
}

Grid<float> GlassSurvey::probability(const GridFrame& frame) const {
  const Cell corner = corner_of(frame);
  Grid<float> sums(frame);
  Grid<std::uint8_t> known(frame);
  for (const std::vector<Piece>& drive : drives_) {
    draw(drive, frame.resolution, [&](Cell cell, float ratio) {
      const Cell at{cell.column - corner.column, cell.row - corner.row};
      if (!frame.contains(at)) return;
      sums[at] += ratio;
      known[at] = 1;
    });
  }
  Grid<float> probability(frame, -1.0F);
  for_each_cell(frame, [&](Cell cell) {
    if (known[cell] != 0)
      probability[cell] = static_cast<float>(glass_probability(static_cast<double>(sums[cell])));
  });
  return without_specks(std::move(probability));
}

std::vector<GlassPane> suspected_panes(const Grid<float>& probability) {
  std::vector<GlassPane> panes;
  for_each_pane(probability, [&](const GlassPane& pane, const std::vector<Cell>& /*cells*/) {
    panes.push_back(pane);
  });
  return panes;
}

}  // namespace loopstone
