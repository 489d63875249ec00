#include "report/map_view.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace loopstone {
namespace {

constexpr double kStrayShare = 0.003;
/// Room around the content for markers and their labels.
constexpr double kMarginShare = 0.035;
constexpr int kLeastMarginCells = 6;
/// Paths are shown up to here; what broken odometry says may lie beyond any picture.
constexpr int kFarthestCell = 100'000'000;

/// The first and last index that stay when at most `most` counts are cut from each end.
struct Kept {
  int first;
  int last;
};

Kept cut_stray_ends(const std::vector<std::int64_t>& counts, std::int64_t most) {
  const auto size = static_cast<int>(counts.size());
  Kept kept{0, size - 1};
  std::int64_t cut = 0;
  while (kept.first < kept.last && cut + counts[static_cast<std::size_t>(kept.first)] <= most) {
    cut += counts[static_cast<std::size_t>(kept.first++)];
  }
  cut = 0;
  while (kept.last > kept.first && cut + counts[static_cast<std::size_t>(kept.last)] <= most) {
    cut += counts[static_cast<std::size_t>(kept.last--)];
  }
  return kept;
}

constexpr Rgb kUnknown{0xd9, 0xdd, 0xe3};  // kUnseenGround
constexpr Rgb kFree{0xff, 0xff, 0xff};
constexpr Rgb kOccupied{0x16, 0x1b, 0x26};

Rgb mix(const Rgb& a, const Rgb& b, double share) {
  const auto channel = [&](std::size_t i) {
    return static_cast<std::uint8_t>(std::lround(a[i] + share * (b[i] - a[i])));
  };
  return {channel(0), channel(1), channel(2)};
}

/// Colours by log-odds in steps of 1/16 from -4 to 4; belief counts fully from p = 0.27 down and
/// 0.82 up.
class Palette {
 public:
  Palette() {
    for (int i = 0; i < kSteps; ++i) {
      const double log_odds = (i - kEvenOdds) / 16.0;
      colours_[static_cast<std::size_t>(i)] =
          log_odds < 0.0 ? mix(kUnknown, kFree, std::min(1.0, 0.45 - 0.55 * log_odds))
                         : mix(kUnknown, kOccupied, std::min(1.0, log_odds / 1.5));
    }
  }
  [[nodiscard]] const Rgb& operator()(float log_odds) const {
    const int i =
        std::clamp(static_cast<int>(std::floor(log_odds * 16.0F)) + kSteps / 2, 0, kSteps - 1);
    return colours_[static_cast<std::size_t>(i)];
  }

 private:
  static constexpr int kSteps = 129;
  static constexpr int kEvenOdds = kSteps / 2;
  std::array<Rgb, kSteps> colours_{};
};

template <typename IsKnown>
MapView view_of_known(const GridFrame& frame, const IsKnown& is_known, const Trajectory& trajectory,
                      int target_side_px, int most_side_px) {
  MapView view;
  view.frame = frame;
  const auto columns = static_cast<std::size_t>(view.frame.columns);
  std::vector<std::int64_t> in_column(columns, 0);
  std::vector<std::int64_t> in_row(static_cast<std::size_t>(view.frame.rows), 0);
  for (std::size_t i = 0; i < frame.cell_count(); ++i) {
    if (!is_known(i)) continue;
    ++in_column[i % columns];
    ++in_row[i / columns];
  }
  const std::int64_t observed = std::accumulate(in_row.begin(), in_row.end(), std::int64_t{0});
  const auto most = static_cast<std::int64_t>(kStrayShare * static_cast<double>(observed));
  const Kept kept_columns = cut_stray_ends(in_column, most);
  const Kept kept_rows = cut_stray_ends(in_row, most);
  view.low = {kept_columns.first, kept_rows.first};
  view.high = {kept_columns.last, kept_rows.last};
  for (const StampedPose2& stamped : trajectory.poses()) {
    Cell cell = view.frame.cell_of(stamped.pose.translation());
    cell = {std::clamp(cell.column, -kFarthestCell, kFarthestCell),
            std::clamp(cell.row, -kFarthestCell, kFarthestCell)};
    view.low = {std::min(view.low.column, cell.column), std::min(view.low.row, cell.row)};
    view.high = {std::max(view.high.column, cell.column), std::max(view.high.row, cell.row)};
  }
  const int content =
      std::max(view.high.column - view.low.column, view.high.row - view.low.row) + 1;
  const int margin = std::max(kLeastMarginCells, static_cast<int>(kMarginShare * content));
  view.low = {view.low.column - margin, view.low.row - margin};
  view.high = {view.high.column + margin, view.high.row + margin};

  const int shown_columns = view.high.column - view.low.column + 1;
  const int shown_rows = view.high.row - view.low.row + 1;
  const int side = std::max(shown_columns, shown_rows);
  view.pixels_per_cell = std::clamp(target_side_px / side, 1, 8);
  view.cells_per_pixel = (side + most_side_px - 1) / most_side_px;
  const auto pixels = [&](int cells) {
    return (cells * view.pixels_per_cell + view.cells_per_pixel - 1) / view.cells_per_pixel;
  };
  view.width_px = pixels(shown_columns);
  view.height_px = pixels(shown_rows);
  return view;
}

/// Calls visit(cell) for the cells of a square block that lie on the map; a path may lead far
/// beyond it.
template <typename Visit>
void for_each_on_map(const GridFrame& frame, Cell low, int side, Visit&& visit) {
  const int end_row = std::min(low.row + side, frame.rows);
  const int end_column = std::min(low.column + side, frame.columns);
  for (int row = std::max(low.row, 0); row < end_row; ++row) {
    for (int column = std::max(low.column, 0); column < end_column; ++column)
      visit(Cell{column, row});
  }
}

/// \param colour_of  what stands for a square block of cells, given its lowest cell and its side
template <typename ColourOf>
Image shade(const MapView& view, const ColourOf& colour_of) {
  Image image = make_image(view.width_px, view.height_px, 3);
  std::vector<std::uint8_t> line(static_cast<std::size_t>(view.width_px) * 3);
  int drawn_cell_row = -1;
  bool drawn = false;
  for (int y = 0; y < view.height_px; ++y) {
    // Row 0 of the cells is the bottom of the picture.
    const int from_bottom = view.height_px - 1 - y;
    const int cell_row = view.low.row + from_bottom * view.cells_per_pixel / view.pixels_per_cell;
    if (!drawn || cell_row != drawn_cell_row) {
      for (int x = 0; x < view.width_px; ++x) {
        const int cell_column = view.low.column + x * view.cells_per_pixel / view.pixels_per_cell;
        const Rgb colour = colour_of(Cell{cell_column, cell_row}, view.cells_per_pixel);
        std::copy(colour.begin(), colour.end(), line.begin() + std::ptrdiff_t{3} * x);
      }
      drawn_cell_row = cell_row;
      drawn = true;
    }
    std::copy(line.begin(), line.end(),
              image.bytes.begin() + static_cast<std::ptrdiff_t>(line.size()) * y);
  }
  return image;
}

}  // namespace

Rgb cell_rgb(int percent) {
  if (percent < 0) return kUnknown;
  const double share = std::min(percent, 100) / 100.0;
  return share < 0.5 ? mix(kFree, kUnknown, 2.0 * share)
                     : mix(kUnknown, kOccupied, 2.0 * share - 1.0);
}

Point MapView::pixel_of(const Eigen::Vector2d& point_m) const {
  const Eigen::Vector2d corner =
      frame.origin + frame.resolution * Eigen::Vector2d(low.column, low.row);
  const Eigen::Vector2d offset = (point_m - corner) * pixels_per_metre();
  return {offset.x(), height_px - offset.y()};
}

double MapView::pixels_per_metre() const {
  return pixels_per_cell / (cells_per_pixel * frame.resolution);
}

MapView view_of(const OccupancyMap& map, const Trajectory& trajectory, int target_side_px,
                int most_side_px) {
  const auto is_known = [&](std::size_t i) { return map.observed.cells()[i] != 0; };
  return view_of_known(map.observed.frame(), is_known, trajectory, target_side_px, most_side_px);
}

MapView view_of(const CellStates& map, const Trajectory& trajectory, int target_side_px,
                int most_side_px) {
  const auto is_known = [&](std::size_t i) { return map.cells()[i] >= 0; };
  return view_of_known(map.frame(), is_known, trajectory, target_side_px, most_side_px);
}

Image shade_map(const OccupancyMap& map, const MapView& view) {
  const Palette palette;
  return shade(view, [&](Cell low, int side) {
    bool observed = false;
    float most = -100.0F;
    for_each_on_map(view.frame, low, side, [&](Cell cell) {
      if (map.observed[cell] == 0) return;
      observed = true;
      most = std::max(most, map.log_odds[cell]);
    });
    return observed ? palette(most) : kUnknown;
  });
}

Image shade_map(const CellStates& map, const MapView& view) {
  return shade(view, [&](Cell low, int side) {
    std::int8_t most = kUnknownCell;
    for_each_on_map(view.frame, low, side, [&](Cell cell) { most = std::max(most, map[cell]); });
    return cell_rgb(most);
  });
}

Image paled(Image image) {
  for (std::uint8_t& channel : image.bytes) {
    channel = static_cast<std::uint8_t>(255 - (255 - channel) * 3 / 5);
  }
  return image;
}

}  // namespace loopstone
