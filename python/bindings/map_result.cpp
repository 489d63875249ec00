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
#include "loopstone/base/error.hpp"
#include "loopstone/formats/image.hpp"
#include "loopstone/formats/machine_memory.hpp"
#include "loopstone/formats/options_file.hpp"
#include "loopstone/formats/session_file.hpp"
#include "loopstone/report/map_outputs.hpp"
#include "loopstone/report/map_picture.hpp"
#include "mapping.hpp"
#include "messages.hpp"
#include "methods.hpp"
#include "options.hpp"
#include "path_like.hpp"

namespace loopstone::python {

namespace {

using Shared = std::shared_ptr<Mapped>;

MapExtras extras_of(const Mapped& mapped) {
  return {.texture = mapped.texture ? &*mapped.texture : nullptr,
          .edits = mapped.edits ? &*mapped.edits : nullptr};
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
      "loop_closures", [](const Shared& self) { return self->result.loop_closures; },
      "All that were found, those that do not stand included.");
}

/// The state of a result that kept it. Throws UsageError when it has none to go on from.
MappingPlan gone_on_with(MappingPlan plan, const Mapped& before) {
  if (before.edits) {
    throw UsageError(
        "this map was edited; go on with the one that was not, then do the same edits to what "
        "comes of it");
  }
  if (!before.state)
    throw UsageError("this map has no state to go on from; make it with keep_state=True");
  plan.goes_on_with = before.state;
  plan.goes_on_from = "the map's state";
  return plan;
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

  m.def(
      "map_log",
      [](const Log& log, const OptionValues& values, double start_s, double duration_s,
         std::int64_t max_scans, int threads, bool texture, bool keep_state,
         const std::optional<PathLike>& from_folder, const Mapped* from_result,
         const nb::object& progress) {
        const auto options = options_of<MapOptions>(values);
        MappingPlan plan{.cut = {start_s, duration_s, max_scans},
                         .threads = Threads{threads},
                         .texture = texture,
                         .keep_state = keep_state};
        if (from_result != nullptr) plan = gone_on_with(std::move(plan), *from_result);
        return work(progress, [&](Work& own) {
          if (from_folder) {
            plan.goes_on_with = std::make_shared<const Session>(
                read_kept_state(from_folder->value, machine_memory_budget()));
            plan.goes_on_from = kept_state_path(from_folder->value);
          }
          return map_log(log, options, plan, own);
        });
      },
      nb::arg("log"), nb::arg("options"), nb::arg("start_s"), nb::arg("duration_s"),
      nb::arg("max_scans"), nb::arg("threads"), nb::arg("texture"), nb::arg("keep_state"),
      nb::arg("from_folder").none(), nb::arg("from_result").none(), nb::arg("progress").none());
  m.def(
      "map_messages",
      [](const nb::typed<nb::iterable, nb::object>& messages, const Robot* robot,
         const OptionValues& values, int threads, const nb::object& progress) {
        const auto options = options_of<MapOptions>(values);
        std::vector<SensorMessage> all;
        for (const nb::handle message : messages) all.push_back(message_of(message));
        const RobotModel model = robot == nullptr ? RobotModel{} : robot->model;
        return work(progress, [&](Work& own) {
          return map_messages(all, model, options, Threads{threads}, own);
        });
      },
      nb::arg("messages"), nb::arg("robot").none(), nb::arg("options"), nb::arg("threads"),
      nb::arg("progress").none());
}

}  // namespace loopstone::python
