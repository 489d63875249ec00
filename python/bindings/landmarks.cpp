#include <fmt/format.h>
#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <vector>

#include "arrays.hpp"
#include "bindings.hpp"
#include "loopstone/formats/landmark_file.hpp"
#include "loopstone/formats/machine_memory.hpp"
#include "loopstone/localization/landmark_mapping.hpp"
#include "path_like.hpp"

namespace loopstone::python {

namespace {

void bind_landmark(nb::module_& m) {
  nb::class_<MappedLandmark> landmark(
      m, "Landmark", "A reflector or beacon whose place is known; can't be changed.");
  landmark.def(
      "__init__",
      [](MappedLandmark* self, int id, double x_m, double y_m, double sigma_m, double radius_m) {
        new (self) MappedLandmark{id, {x_m, y_m}, sigma_m, radius_m};
      },
      nb::arg("id"), nb::arg("x_m"), nb::arg("y_m"), nb::kw_only(), nb::arg("sigma_m") = 0.0,
      nb::arg("radius_m") = 0.0, "Values are checked by what it is given to.");
  landmark.def_ro("id", &MappedLandmark::id, "No other landmark's.");
  def_array(
      landmark, "position", [](const MappedLandmark& l) { return to_array(l.position); },
      "(2,) x, y of its centre on the map [m].");
  landmark.def_ro("sigma_m", &MappedLandmark::sigma_m, "Standard deviation of x and of y.");
  landmark.def_ro("radius_m", &MappedLandmark::radius_m,
                  "Of a round one, whose surface a laser meets; 0: it is flat.");
  landmark.def("__repr__", [](const MappedLandmark& l) {
    return fmt::format("<Landmark {} at ({:.3f}, {:.3f}) m>", l.id, l.position.x(), l.position.y());
  });
}

void bind_found(nb::module_& m) {
  nb::class_<FoundLandmark> found(m, "FoundLandmark", "A landmark whose place a drive found.");
  found.def_ro("id", &FoundLandmark::id, "1, 2, ... as they were first seen.");
  def_array(
      found, "position", [](const FoundLandmark& l) { return to_array(l.position); },
      "(2,) x, y of its centre on the map [m].");
  def_array(
      found, "covariance",
      [](const FoundLandmark& l) { return to_array(Eigen::MatrixXd(l.covariance)); },
      "(2, 2) of its position against the first pose, axes of the map [m^2].");
  found.def_ro("sigma_m", &FoundLandmark::sigma_m,
               "Among the other landmarks, without what moves all of them together.");
  found.def_ro("radius_m", &FoundLandmark::radius_m,
               "0: it is flat, or was seen from one side only.");
  found.def_ro("sightings", &FoundLandmark::sightings, "That agree with it.");
  found.def_ro("visits", &FoundLandmark::visits, "How often it came into view.");
  found.def("__repr__", [](const FoundLandmark& l) {
    return fmt::format("<FoundLandmark {} at ({:.3f}, {:.3f}) m, {} sightings>", l.id,
                       l.position.x(), l.position.y(), l.sightings);
  });
}

}  // namespace

void bind_landmarks(nb::module_& m) {
  bind_landmark(m);
  bind_found(m);
  m.def(
      "read_landmarks",
      [](const PathLike& path) {
        const nb::gil_scoped_release unlocked;
        return read_landmarks(path.value, machine_memory_budget());
      },
      nb::arg("path"),
      "Reads landmarks: CSV with ``id,x_m,y_m``, a folder that holds landmarks.csv, or UTIAS\n"
      "MRCLAM's. Raises DataError.");
  m.def(
      "mapped_landmarks", [](const std::vector<FoundLandmark>& found) { return as_mapped(found); },
      nb::arg("found"));
}

}  // namespace loopstone::python
