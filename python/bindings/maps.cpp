#include "maps.hpp"

#include <nanobind/nanobind.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>

#include <cmath>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "arrays.hpp"
#include "bindings.hpp"
#include "frames.hpp"
#include "loopstone/formats/image.hpp"
#include "loopstone/formats/machine_memory.hpp"
#include "loopstone/mapping/occupancy.hpp"
#include "methods.hpp"
#include "path_like.hpp"

namespace loopstone::python {

namespace {

template <typename T>
View<T, nb::ndim<2>> cells_view(const Grid<T>& grid, nb::handle owner) {
  const GridFrame& frame = grid.frame();
  return View<T, nb::ndim<2>>(
      grid.cells().data(),
      {static_cast<std::size_t>(frame.rows), static_cast<std::size_t>(frame.columns)}, owner);
}

CellStates make_cells(const ArrayLike& given, double resolution_m, const ArrayLike& origin) {
  const Integers cells = integers_of(given, "cells");
  if (cells.shape.size() != 2)
    throw nb::value_error("cells: expected an array of shape (rows, columns)");
  if (!(resolution_m > 0.0) || !std::isfinite(resolution_m))
    throw nb::value_error("resolution_m: must be greater than 0");
  const Numbers corner = numbers_of(origin, "origin");
  const bool is_point = corner.shape == std::vector<std::size_t>{2} &&
                        std::isfinite(corner.values[0]) && std::isfinite(corner.values[1]);
  if (!is_point) throw nb::value_error("origin: expected two finite numbers: x, y");
  constexpr std::size_t kMostSide = std::size_t{1} << 24U;
  if (cells.shape[0] == 0 || cells.shape[1] == 0 || cells.shape[0] > kMostSide ||
      cells.shape[1] > kMostSide) {
    throw nb::value_error("cells: a map has at least one row and one column, and at most 2^24");
  }
  CellStates grid(GridFrame{{corner.values[0], corner.values[1]},
                            resolution_m,
                            static_cast<int>(cells.shape[1]),
                            static_cast<int>(cells.shape[0])});
  for (std::size_t i = 0; i < cells.values.size(); ++i) {
    const std::int64_t cell = cells.values[i];
    if (cell < kUnknownCell || cell > kOccupiedCell)
      throw nb::value_error("cells: must be percent from 0 to 100, or -1 where unknown");
    grid.cells()[i] = static_cast<std::int8_t>(cell);
  }
  return grid;
}

nb::bytes png_of(const CellStates& cells) {
  std::string png;
  {
    const nb::gil_scoped_release unlocked;
    png = encode_png(map_image(cells));
  }
  return nb::bytes(png.data(), png.size());
}

Array<float, nb::ndim<2>> probabilities(const OccupancyMap& map) {
  const GridFrame& frame = map.log_odds.frame();
  std::vector<float> values(frame.cell_count());
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double odds = map.log_odds.cells()[i];
    values[i] =
        map.observed.cells()[i] == 0 ? 0.5F : static_cast<float>(1.0 / (1.0 + std::exp(-odds)));
  }
  return array_of<float, nb::ndim<2>>(std::move(values), {static_cast<std::size_t>(frame.rows),
                                                          static_cast<std::size_t>(frame.columns)});
}

using Mask = nb::ndarray<nb::numpy, const bool, nb::ro, nb::ndim<2>>;

Mask observed_view(nb::handle_t<OccupancyMap> self) {
  static_assert(sizeof(bool) == 1);
  const Grid<std::uint8_t>& grid = nb::cast<const OccupancyMap&>(self).observed;
  // Cells are 0 or 1, which is how a bool lies in memory.
  return Mask(
      reinterpret_cast<const bool*>(grid.cells().data()),
      {static_cast<std::size_t>(grid.frame().rows), static_cast<std::size_t>(grid.frame().columns)},
      self);
}

void bind_grid_map(nb::module_& m) {
  nb::class_<GridMap> grid(m, "GridMap",
                           "A map of cells in percent, as ROS has it; can't be changed.");
  grid.def(
      "__init__",
      [](GridMap* self, const ArrayLike& cells, double resolution_m, const ArrayLike& origin) {
        new (self)
            GridMap{std::make_shared<const CellStates>(make_cells(cells, resolution_m, origin))};
      },
      nb::arg("cells"), nb::arg("resolution_m"), nb::arg("origin"),
      "Copies (rows, columns) int8; row 0 has the lowest y. Raises ValueError.");
  def_array(
      grid, "cells",
      [](nb::handle_t<GridMap> self) {
        return cells_view(*nb::cast<const GridMap&>(self).cells, self);
      },
      "(rows, columns) int8, a read-only view: percent occupied, -1 unknown.");
  def_frame(grid, [](const GridMap& self) -> const GridFrame& { return self.cells->frame(); });
  grid.def(
      "save",
      [](const GridMap& self, const PathLike& path) {
        const nb::gil_scoped_release unlocked;
        write_ros_map(path.value, *self.cells);
      },
      nb::arg("path"),
      "Writes NAME.yaml and NAME.pgm, as ROS map_server reads them: both or none.");
  grid.def(
      "to_png", [](const GridMap& self) { return png_of(*self.cells); },
      "The bytes of a PNG picture: white free, black occupied, grey unknown.");
  grid.def("_repr_png_", [](const GridMap& self) { return png_of(*self.cells); });
  def_python(grid, "plot", "loopstone._plot", "plot_grid",
             "def plot(self, ax: matplotlib.axes.Axes | None = None) -> matplotlib.axes.Axes",
             "Draws it, metres on the axes. Needs loopstone[plot].");
  grid.def("__repr__", [](const GridMap& self) {
    const GridFrame& frame = self.cells->frame();
    return "<GridMap of " + std::to_string(frame.rows) + " x " + std::to_string(frame.columns) +
           " cells>";
  });
  m.def(
      "read_map",
      [](const PathLike& path) {
        const nb::gil_scoped_release unlocked;
        return GridMap{
            std::make_shared<const CellStates>(read_ros_map(path.value, machine_memory_budget()))};
      },
      nb::arg("path"),
      "Reads a map as ROS map_server does: YAML beside PGM or PNG. Raises DataError.");
}

}  // namespace

void bind_maps(nb::module_& m) {
  bind_grid_map(m);
  nb::class_<OccupancyMap> map(m, "OccupancyMap",
                               "An occupancy map that was made of scans; can't be changed.");
  def_array(
      map, "log_odds",
      [](nb::handle_t<OccupancyMap> self) {
        return cells_view(nb::cast<const OccupancyMap&>(self).log_odds, self);
      },
      "(rows, columns) float32, a read-only view: positive occupied, negative free, 0 even.");
  def_array(map, "observed", observed_view,
            "(rows, columns) bool, a read-only view: a beam or the robot was there.");
  def_array(map, "probability", probabilities,
            "(rows, columns) float32 in [0, 1], computed; 0.5 where unknown.");
  def_frame(map,
            [](const OccupancyMap& self) -> const GridFrame& { return self.log_odds.frame(); });
  map.def(
      "to_grid",
      [](const OccupancyMap& self) {
        return GridMap{std::make_shared<const CellStates>(cell_states(self))};
      },
      "As cells of 0, 100 and -1: free, occupied, unknown.");
  map.def("_repr_png_", [](const OccupancyMap& self) { return png_of(cell_states(self)); });
  def_python(map, "plot", "loopstone._plot", "plot_occupancy",
             "def plot(self, ax: matplotlib.axes.Axes | None = None) -> matplotlib.axes.Axes",
             "Draws it, metres on the axes. Needs loopstone[plot].");
  map.def("__repr__", [](const OccupancyMap& self) {
    const GridFrame& frame = self.log_odds.frame();
    return "<OccupancyMap of " + std::to_string(frame.rows) + " x " +
           std::to_string(frame.columns) + " cells>";
  });
}

}  // namespace loopstone::python
