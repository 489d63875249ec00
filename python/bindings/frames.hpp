#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/tuple.h>

#include <tuple>
#include <utility>

#include "arrays.hpp"
#include "loopstone/grid/grid_frame.hpp"

namespace loopstone::python {

/// Where a map of any kind lies. \param frame_of  tells the frame of an object
template <typename Class, typename FrameOf>
void def_frame(nb::class_<Class>& cls, FrameOf frame_of) {
  cls.def_prop_ro(
      "resolution_m", [=](const Class& self) { return frame_of(self).resolution; },
      "Side of a cell.");
  def_array(
      cls, "origin", [=](const Class& self) { return to_array(frame_of(self).origin); },
      "(2,) lower left corner of cell [0, 0] [m], map frame.");
  cls.def_prop_ro(
      "shape",
      [=](const Class& self) { return std::pair(frame_of(self).rows, frame_of(self).columns); },
      "(rows, columns): row grows with y, column with x.");
  cls.def_prop_ro(
      "extent",
      [=](const Class& self) {
        const GridFrame& frame = frame_of(self);
        return std::tuple(frame.origin.x(), frame.origin.x() + frame.columns * frame.resolution,
                          frame.origin.y(), frame.origin.y() + frame.rows * frame.resolution);
      },
      "(left, right, bottom, top) [m], as ``imshow(cells, origin='lower', extent=...)`` takes it.");
}

}  // namespace loopstone::python
