#include <nanobind/nanobind.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bindings.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/formats/machine_memory.hpp"
#include "loopstone/formats/mrclam.hpp"
#include "loopstone/formats/session_file.hpp"
#include "mapping.hpp"
#include "messages.hpp"
#include "options.hpp"
#include "path_like.hpp"

namespace loopstone::python {

namespace {

constexpr const char* kIsEdited =
    "was edited; go on with the one that was not, then do the same edits to what comes of it";

/// The state of a result that kept it. Throws UsageError when it has none to go on from.
MappingPlan gone_on_with(MappingPlan plan, const Mapped& before) {
  if (before.edits) {
    throw UsageError(std::string("the map ") + kIsEdited);
  }
  if (!before.state)
    throw UsageError("this map has no state to go on from; make it with keep_state=True");
  plan.goes_on_with = before.state;
  plan.goes_on_from = "the map's state";
  return plan;
}

/// The same of a folder. Throws DataError.
MappingPlan gone_on_with(MappingPlan plan, const std::string& folder) {
  Session state = read_kept_state(folder, "go on from", machine_memory_budget());
  if (is_edited_map(folder)) throw DataError({folder}, kIsEdited);
  plan.goes_on_with = std::make_shared<const Session>(std::move(state));
  plan.goes_on_from = kept_state_path(folder);
  return plan;
}

/// With landmarks, their options stand among the others.
LandmarkMapOptions map_options(const OptionValues& values, bool landmarks) {
  if (landmarks) return options_of<LandmarkMapOptions>(values);
  return {.map = options_of<MapOptions>(values)};
}

void require_scans(const std::string& log) {
  if (!is_mrclam_log(log)) return;
  throw UsageError(
      log + ": holds landmarks and odometry, no scans; `loopstone map --landmarks` maps them");
}

}  // namespace

void bind_map_calls(nb::module_& m) {
  m.def(
      "map_log",
      [](const Log& log, const OptionValues& values, double start_s, double duration_s,
         std::int64_t max_scans, int threads, bool texture, bool landmarks, bool keep_state,
         const std::optional<PathLike>& from_folder, const Mapped* from_result,
         const nb::object& progress) {
        const LandmarkMapOptions options = map_options(values, landmarks);
        if (landmarks && (keep_state || from_folder || from_result != nullptr)) {
          throw UsageError(
              "landmarks: a state does not keep how bright beams were, by which reflectors are "
              "told; leave out keep_state and continue_from");
        }
        require_scans(log.path);
        MappingPlan plan{.cut = {start_s, duration_s, max_scans},
                         .threads = Threads{threads},
                         .texture = texture,
                         .keep_state = keep_state};
        if (landmarks) plan.landmarks = options.landmarks;
        if (from_result != nullptr) plan = gone_on_with(std::move(plan), *from_result);
        return work(progress, [&](Work& own) {
          if (from_folder) plan = gone_on_with(std::move(plan), from_folder->value);
          return map_log(log, options.map, plan, own);
        });
      },
      nb::arg("log"), nb::arg("options"), nb::arg("start_s"), nb::arg("duration_s"),
      nb::arg("max_scans"), nb::arg("threads"), nb::arg("texture"), nb::arg("landmarks"),
      nb::arg("keep_state"), nb::arg("from_folder").none(), nb::arg("from_result").none(),
      nb::arg("progress").none());
  m.def(
      "map_messages",
      [](const nb::typed<nb::iterable, nb::object>& messages, const Robot* robot,
         const OptionValues& values, bool landmarks, int threads, const nb::object& progress) {
        const LandmarkMapOptions options = map_options(values, landmarks);
        MappingPlan plan{.threads = Threads{threads}, .texture = false};
        if (landmarks) plan.landmarks = options.landmarks;
        std::vector<SensorMessage> all;
        for (const nb::handle message : messages) all.push_back(message_of(message));
        const RobotModel model = robot == nullptr ? RobotModel{} : robot->model;
        return work(progress,
                    [&](Work& own) { return map_messages(all, model, options.map, plan, own); });
      },
      nb::arg("messages"), nb::arg("robot").none(), nb::arg("options"), nb::arg("landmarks"),
      nb::arg("threads"), nb::arg("progress").none());
}

}  // namespace loopstone::python
