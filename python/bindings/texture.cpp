#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <cstdint>
#include <type_traits>
#include <utility>
#include <vector>

#include "arrays.hpp"
#include "bindings.hpp"
#include "frames.hpp"
#include "loopstone/mapping/floor_texture.hpp"

// The grid of its cells says that it can be copied, and can't.
template <>
struct nanobind::detail::is_copy_constructible<loopstone::FloorTexture> : std::false_type {};

namespace loopstone::python {

namespace {

/// Of every cell of the frame, from the lower left corner on. \param take  what of a colour
template <typename Take>
std::vector<std::uint8_t> of_cells(const FloorTexture& texture, Take&& take) {
  std::vector<std::uint8_t> values;
  for (int row = 0; row < texture.frame.rows; ++row) {
    for (int column = 0; column < texture.frame.columns; ++column)
      take(texture.at({column, row}), values);
  }
  return values;
}

std::vector<std::size_t> shape_of(const FloorTexture& texture) {
  return {static_cast<std::size_t>(texture.frame.rows),
          static_cast<std::size_t>(texture.frame.columns)};
}

Array<std::uint8_t, nb::ndim<3>> colours(const FloorTexture& texture) {
  std::vector<std::size_t> shape = shape_of(texture);
  shape.push_back(3);
  return array_of<std::uint8_t, nb::ndim<3>>(
      of_cells(texture,
               [](const TextureColour& c, std::vector<std::uint8_t>& values) {
                 values.insert(values.end(), {c.red, c.green, c.blue});
               }),
      shape);
}

Array<std::uint8_t, nb::ndim<2>> coverage(const FloorTexture& texture) {
  return array_of<std::uint8_t, nb::ndim<2>>(
      of_cells(texture, [](const TextureColour& c,
                           std::vector<std::uint8_t>& values) { values.push_back(c.coverage); }),
      shape_of(texture));
}

}  // namespace

void bind_texture(nb::module_& m) {
  nb::class_<FloorTexture> texture(m, "FloorTexture",
                                   "The colour of the floor, as an RGB-D camera saw it.");
  def_array(texture, "colours", colours, "(rows, columns, 3) uint8, sRGB; black where unknown.");
  def_array(texture, "coverage", coverage,
            "(rows, columns) uint8: 255 seen, 128 filled in between, 0 unknown.");
  def_frame(texture, [](const FloorTexture& self) -> const GridFrame& { return self.frame; });
  texture.def_prop_ro(
      "seen_area_m2", [](const FloorTexture& self) { return self.statistics.seen_area_m2; },
      "Of the cells that were seen [m^2].");
  texture.def_prop_ro(
      "frames_used", [](const FloorTexture& self) { return self.statistics.frames_used; },
      "Pairs of colour and depth that gave colour.");
  texture.def_ro("warnings", &FloorTexture::warnings, "In plain words.");
}

}  // namespace loopstone::python
