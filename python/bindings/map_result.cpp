#include <nanobind/nanobind.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "arrays.hpp"
#include "bindings.hpp"
#include "graph.hpp"
#include "json.hpp"
#include "loopstone/formats/image.hpp"
#include "loopstone/formats/session_file.hpp"
#include "loopstone/report/map_outputs.hpp"
#include "loopstone/report/map_picture.hpp"
#include "mapping.hpp"
#include "methods.hpp"
#include "path_like.hpp"

namespace loopstone::python {

namespace {

using Shared = std::shared_ptr<Mapped>;

MapExtras extras_of(const Mapped& mapped) {
  return {.texture = mapped.texture ? &*mapped.texture : nullptr,
          .landmarks = mapped.landmarks ? &*mapped.landmarks : nullptr,
          .edits = mapped.edits ? &*mapped.edits : nullptr,
          .site = mapped.site ? &*mapped.site : nullptr};
}

/// A part of a result; it keeps all of it.
template <typename Part>
std::shared_ptr<Part> part(const Shared& whole, Part& part) {
  return {whole, &part};
}

void save(const Shared& self, const PathLike& folder, bool force) {
  const nb::gil_scoped_release unlocked;
  const std::lock_guard lock(self->mutex);
  RunInfo info = self->info;
  info.force = force;
  write_map_outputs(self->result, info, folder.value, extras_of(*self));
  if (self->state) {
    write_session(kept_state_path(folder.value), *self->state);
  } else {
    remove_kept_state(folder.value);
  }
}

nb::object summary(const Shared& self) {
  std::string text;
  {
    const nb::gil_scoped_release unlocked;
    const std::lock_guard lock(self->mutex);
    text = format_summary(self->result, self->info, extras_of(*self));
  }
  return parse_json(text);
}

nb::bytes picture(const Shared& self) {
  std::string png;
  {
    const nb::gil_scoped_release unlocked;
    png = encode_png(draw_map_picture(self->result));
  }
  return nb::bytes(png.data(), png.size());
}

using Covariances = nb::ndarray<nb::numpy, const double, nb::ro, nb::shape<-1, 3, 3>>;

std::optional<Covariances> covariances(nb::handle_t<Mapped> handle) {
  Mapped& self = nb::cast<Mapped&>(handle);
  const MapResult& result = self.result;
  if (!result.covariances.available()) return {};
  {
    const nb::gil_scoped_release unlocked;
    const std::lock_guard lock(self.mutex);
    if (self.covariances.empty()) {
      std::vector<double> values;
      values.reserve(9 * result.trajectory.size());
      for (const StampedPose2& pose : result.trajectory.poses()) {
        const Eigen::Matrix3d covariance = result.covariance_at(pose.stamp);
        values.insert(values.end(), covariance.data(), covariance.data() + 9);
      }
      self.covariances = std::move(values);
    }
  }
  return Covariances(self.covariances.data(), {result.trajectory.size(), 3, 3}, handle);
}

void def_parts(nb::class_<Mapped>& cls) {
  cls.def_prop_ro(
      "trajectory", [](const Shared& self) { return part(self, self->result.trajectory); },
      "map_T_robot at every scan.");
  cls.def_prop_ro(
      "odometry", [](const Shared& self) { return part(self, self->result.odometry); },
      "odom_T_robot at every scan, by dead reckoning alone.");
  def_array(cls, "covariances", covariances,
            "(N, 3, 3) of each pose of the trajectory against the first, axes of the map\n"
            "[m^2, m rad, rad^2], a read-only view; None when a pose is held by nothing.\n"
            "Worked out when first asked for, up to a millisecond a pose.");
  cls.def_prop_ro(
      "graph",
      [](const Shared& self) {
        return whole_graph(std::shared_ptr<const PoseGraph>(self, &self->result.graph));
      },
      "The pose graph of all key scans, at its final poses.");
  def_array(
      cls, "node_stamps_ns",
      [](const Shared& self) {
        std::vector<std::int64_t> stamps;
        for (const Stamp& stamp : self->result.node_stamps) stamps.push_back(stamp.nanoseconds);
        const std::size_t count = stamps.size();
        return array_of<std::int64_t, nb::ndim<1>>(std::move(stamps), {count});
      },
      "(K,) int64 [ns] of the graph's poses.");
  cls.def_prop_ro(
      "map",
      [](const Shared& self) -> std::shared_ptr<OccupancyMap> {
        if (!self->result.map_failure.empty()) return nullptr;
        return part(self, self->result.map);
      },
      nb::sig("def map(self) -> OccupancyMap | None"),
      "The occupancy map; None when it would be too large: see ``warnings``.");
  cls.def_prop_ro(
      "texture",
      [](const Shared& self) -> std::shared_ptr<FloorTexture> {
        if (!self->texture) return nullptr;
        return part(self, *self->texture);
      },
      nb::sig("def texture(self) -> FloorTexture | None"),
      "The floor in colour, when the log has RGB-D.");
  cls.def_prop_ro(
      "landmarks",
      [](const Shared& self) {
        return self->landmarks ? self->landmarks->landmarks : std::vector<FoundLandmark>{};
      },
      "The reflectors that were found, of a map with ``landmarks=True``; in the order of the\n"
      "graph's landmarks.");
  cls.def_prop_ro(
      "loop_closures", [](const Shared& self) { return self->result.loop_closures; },
      "All that were found, those that do not stand included.");
}

void def_judgement(nb::class_<Mapped>& cls) {
  cls.def_prop_ro(
      "verdict", [](const Shared& self) { return self->result.verdict; },
      "How good the map is, in words, with the figures behind them.");
  cls.def_prop_ro(
      "possible_error_m", [](const Shared& self) { return self->result.ties.possible.m; },
      "How far a part of the map may be off, by all that hangs loosely.");
  cls.def_prop_ro(
      "possible_error_rad", [](const Shared& self) { return self->result.ties.possible.rad; },
      "By how much it may be turned.");
  cls.def_prop_ro("summary", summary, nb::sig("def summary(self) -> dict[str, typing.Any]"),
                  "Every figure of the run, units in the names: what summary.json has.");
  cls.def_prop_ro(
      "warnings", [](const Shared& self) { return self->result.warnings; }, "In plain words.");
  cls.def_prop_ro(
      "complete", [](const Shared& self) { return self->result.complete; },
      "False when the run was interrupted.");
  cls.def_prop_ro(
      "failure", [](const Shared& self) { return self->info.failure; },
      "What was asked for and can't be had, the floor's colour or landmarks, and why; empty when\n"
      "all is there.");
  cls.def_prop_ro(
      "robot",
      [](const Shared& self) {
        return Robot{self->robot, {}};
      },
      "That the map was made with: mounts and wheels.");
  cls.def_prop_ro(
      "has_state", [](const Shared& self) { return self->state != nullptr; },
      "Another drive can go on with it, and it can be edited: made with ``keep_state=True``.");
  cls.def_prop_ro(
      "drives", [](const Shared& self) { return self->result.drives.size() + 1; },
      "How many drives it is of: more than 1 of a map that was gone on with.");
  cls.def_prop_ro(
      "options_toml", [](const Shared& self) { return self->info.options_toml; },
      "The effective options.");
}

}  // namespace

void bind_map_result(nb::module_& m) {
  nb::class_<Mapped> cls(m, "MapResult", "What the mapper made of a log.");
  def_parts(cls);
  def_judgement(cls);
  cls.def("save", save, nb::arg("folder"), nb::kw_only(), nb::arg("force") = false,
          "Writes the files that ``loopstone map`` writes, all of them or none. Raises UsageError\n"
          "when the folder holds something, unless forced.");
  cls.def("to_png", picture, "The bytes of map.png: map, path, closures, scale bar.");
  def_python(cls, "_repr_html_", "loopstone._notebook", "map_result_html",
             "def _repr_html_(self) -> str", "Map and verdict, for notebooks.");
  def_python(cls, "plot", "loopstone._plot", "plot_result",
             "def plot(self, ax: matplotlib.axes.Axes | None = None) -> matplotlib.axes.Axes",
             "Draws map, path and closures, metres on the axes. Needs loopstone[plot].");
  cls.def("__repr__", [](const Mapped& self) {
    const MapStatistics& s = self.result.statistics;
    return "<MapResult of " + std::to_string(s.scans) + " scans, " +
           std::to_string(s.loop_closures_accepted) +
           " loop closures: " + std::string(loopstone::to_string(self.result.verdict.overall)) +
           ">";
  });
}

}  // namespace loopstone::python
