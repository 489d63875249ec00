#include <nanobind/nanobind.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/variant.h>
#include <nanobind/stl/vector.h>

#include <chrono>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "arrays.hpp"
#include "bindings.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/formats/edits_file.hpp"
#include "loopstone/formats/machine_memory.hpp"
#include "loopstone/formats/options_file.hpp"
#include "loopstone/formats/robot_file.hpp"
#include "loopstone/formats/session_file.hpp"
#include "loopstone/report/edited_folder.hpp"
#include "loopstone/report/peak_memory.hpp"
#include "loopstone/slam/map_editor.hpp"
#include "loopstone/slam/map_verdict.hpp"
#include "loopstone/slam/mapper.hpp"
#include "loopstone/version.hpp"
#include "mapping.hpp"
#include "methods.hpp"
#include "path_like.hpp"
#include "work.hpp"

namespace loopstone::python {

namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

std::string word(Verdict verdict) { return std::string(loopstone::to_string(verdict)); }

/// The map of a state up to its solved graph.
SettledMap settle(const Session& session, const std::string& origin, Threads threads) {
  if (session.terms.robot_toml.empty())
    throw DataError({origin}, "does not tell its robot; map the log once more");
  const RobotModel robot = parse_robot(session.terms.robot_toml, origin);
  MapOptions options;
  std::vector<OptionProblem> problems =
      apply_toml(list_options(options), session.terms.options_toml, origin);
  if (!problems.empty()) throw OptionsError(std::move(problems));
  limit_cells(options);
  Mapper mapper(robot, options, threads);
  try {
    mapper.restore_state(session.mapper);
  } catch (const UsageError& error) {
    throw DataError({origin}, std::string("is damaged: ") + error.what());
  }
  return mapper.settle();
}

/// What an edit needs of the map in a folder of results: its state, and what is known of its log.
std::shared_ptr<Mapped> map_in(const std::string& folder, const EditedFolder& told,
                               Threads threads) {
  auto map = std::make_shared<Mapped>();
  const MemoryBudget budget = machine_memory_budget();
  map->state = std::make_shared<const Session>(read_kept_state(folder, "edit", budget));
  map->robot = parse_robot(map->state->terms.robot_toml, kept_state_path(folder));
  map->info.version = kVersion;
  map->info.threads = threads.resolved();
  map->info.options_toml = map->state->terms.options_toml;
  map->info.log_path = told.log;
  map->info.left_out = told.left_out;
  map->info.log_warnings = told.log_warnings;
  map->result.verdict.overall = told.verdict;
  return map;
}

/// A finished map in somebody's hand; any thread may call it, one at a time works.
class Editor {
 public:
  Editor(std::shared_ptr<Mapped> map, Threads threads)
      : before_(std::move(map)),
        edited_(before_->info.log_path),
        was_coloured_(before_->texture.has_value()) {
    if (before_->edits)
      throw UsageError("this map was edited; edit the one that was not, with all edits");
    if (!before_->state)
      throw UsageError("this map has no state to be edited from; make it with keep_state=True");
    const auto start = Clock::now();
    editor_.emplace(settle(*before_->state, "the map's state", threads), threads);
    open_s_ = seconds_since(start);
  }
  /// With the edits that were done to it.
  Editor(const std::string& folder, Threads threads) : edited_(folder) {
    const auto start = Clock::now();
    const EditedFolder told = read_edited_folder(folder, machine_memory_budget());
    before_ = map_in(folder, told, threads);
    was_coloured_ = told.has_texture;
    editor_.emplace(settle(*before_->state, kept_state_path(folder), threads), threads);
    open_s_ = seconds_since(start);
    if (!told.was_edited) return;
    for (const MapEdit& edit : joined(told.edits, {}).edits) editor_->add(edit);
  }

  EditReport add(const std::string& toml) {
    const std::vector<MapEdit> edits = parse_edits(toml, "edit");
    if (edits.size() != 1) throw UsageError("edit: one was expected");
    return alone([&](MapEditor& editor) { return EditReport(editor.add(edits.front())); });
  }
  std::vector<EditReport> add_all(const std::string& toml, const std::string& path) {
    const std::vector<MapEdit> edits = parse_edits(toml, path);
    return alone([&](MapEditor& editor) {
      std::vector<EditReport> reports;
      for (const MapEdit& edit : edits) reports.push_back(editor.add(edit));
      return reports;
    });
  }
  bool undo() {
    return alone([](MapEditor& editor) { return editor.undo(); });
  }
  std::size_t size() {
    return alone([](MapEditor& editor) { return editor.size(); });
  }
  std::vector<EditReport> reports() {
    return alone([](MapEditor& editor) {
      std::vector<EditReport> reports;
      for (std::size_t i = 0; i < editor.size(); ++i) reports.push_back(editor.report(i));
      return reports;
    });
  }
  std::string toml() {
    return alone([](MapEditor& editor) { return toml_of(editor); });
  }
  EditPreview preview() {
    return alone([](MapEditor& editor) { return editor.preview(); });
  }

  std::shared_ptr<Mapped> draw(const nb::object& progress) {
    return work(progress, [this](Work& own) {
      return alone_unlocked([&](MapEditor& editor) { return drawn(editor, own); });
    });
  }

 private:
  static std::string toml_of(const MapEditor& editor) {
    std::vector<MapEdit> edits;
    for (std::size_t i = 0; i < editor.size(); ++i) edits.push_back(editor.edit(i));
    return edits_to_toml(edits);
  }

  /// As `loopstone edit` makes it.
  std::shared_ptr<Mapped> drawn(const MapEditor& editor, Work& work) {
    if (editor.any_refused())
      throw UsageError("an edit was refused, see reports; undo() takes the last one away");
    const auto start = Clock::now();
    EditedMap map = editor.draw(work.callback());
    if (!work.goes_on()) throw CalledOff{};
    auto done = std::make_shared<Mapped>();
    done->info = before_->info;
    done->robot = before_->robot;
    done->state = before_->state;
    done->result = std::move(map.result);
    const std::vector<std::string>& of_log = before_->info.log_warnings;
    std::vector<std::string>& warnings = done->result.warnings;
    warnings.insert(warnings.begin(), of_log.begin(), of_log.end());
    judge_left_out(done->result.verdict, before_->info.left_out.share());
    if (was_coloured_) warnings.emplace_back(kColourIsLost);
    EditOutputs edits{.edits_toml = toml_of(editor),
                      .edited = edited_,
                      .new_T_map = map.new_T_map,
                      .shift = editor.preview().shift,
                      .cells_erased = map.cells_erased,
                      .keep_out = std::move(map.keep_out),
                      .speed = std::move(map.speed),
                      .verdict_before = before_->result.verdict.overall,
                      .open_s = open_s_};
    for (std::size_t i = 0; i < editor.size(); ++i) {
      edits.edits.push_back({std::string(kind_of(editor.edit(i))), editor.report(i)});
      edits.edit_s += editor.report(i).seconds;
    }
    edits.draw_s = seconds_since(start);
    done->info.wall_time_s = open_s_ + edits.edit_s + edits.draw_s;
    done->info.peak_memory_bytes = peak_memory_bytes();
    done->edits = std::move(edits);
    return done;
  }

  template <typename Use>
  std::invoke_result_t<Use, MapEditor&> alone_unlocked(Use&& use) {
    const std::lock_guard lock(mutex_);
    return use(*editor_);
  }
  template <typename Use>
  std::invoke_result_t<Use, MapEditor&> alone(Use&& use) {
    const nb::gil_scoped_release unlocked;
    return alone_unlocked(std::forward<Use>(use));
  }

  std::shared_ptr<Mapped> before_;
  std::string edited_;  ///< what the report calls the map
  bool was_coloured_ = false;
  double open_s_ = 0.0;
  std::mutex mutex_{};
  std::optional<MapEditor> editor_{};
};

void bind_report(nb::module_& m) {
  nb::class_<EditReport> report(m, "EditReport", "What became of an edit.");
  report.def_ro("applied", &EditReport::applied, "False: it was refused, and nothing has changed.");
  report.def_ro("told", &EditReport::told, "What it did, or why it was refused, in words.");
  report.def_ro("closure", &EditReport::closure, "Added, taken out or refused; else None.");
  report.def_ro("closures_revoked", &EditReport::closures_revoked,
                "Others that contradict the graph since.");
  report.def_prop_ro(
      "moved_m", [](const EditReport& r) { return r.shift.largest_m; },
      "How far a key scan moved at most.");
  report.def_prop_ro(
      "moved_rad", [](const EditReport& r) { return r.shift.largest_rad; },
      "How far one turned at most.");
  report.def_prop_ro(
      "verdict_before", [](const EditReport& r) { return word(r.verdict_before); },
      "Of the graph alone.");
  report.def_prop_ro(
      "verdict", [](const EditReport& r) { return word(r.verdict); }, "Of the graph since.");
  report.def("__bool__", [](const EditReport& r) { return r.applied; });
  report.def("__repr__", [](const EditReport& r) {
    return std::string("<EditReport: ") + (r.applied ? "" : "refused: ") + r.told + ">";
  });
}

}  // namespace

void bind_editor(nb::module_& m) {
  bind_report(m);
  nb::class_<Editor> editor(
      m, "MapEditor",
      "A finished map in somebody's hand, as ``loopstone edit`` has it: a list of edits, done to\n"
      "what the map was made of. Points and polygons are told in the frame of the map before all\n"
      "edits.");
  editor.def(
      "__init__",
      [](Editor* self, const std::variant<std::shared_ptr<Mapped>, PathLike>& map, int threads) {
        const nb::gil_scoped_release unlocked;
        if (const auto* made = std::get_if<std::shared_ptr<Mapped>>(&map)) {
          new (self) Editor(*made, Threads{threads});
        } else {
          new (self) Editor(std::get<PathLike>(map).value, Threads{threads});
        }
      },
      nb::arg("map"), nb::kw_only(), nb::arg("threads") = 0,
      "Of a map made with ``keep_state=True``, or of the folder that it was saved in, as\n"
      "``loopstone edit`` takes it: if that was edited, with these edits first. Map and folder "
      "stay\n"
      "as they are. Raises UsageError, DataError.");
  def_python(editor, "add", "loopstone._edits", "add",
             "def add(self, kind: str, **keys: typing.Any) -> EditReport",
             "One more edit: ``editor.add(\"crop\", box=[0, 0, 20, 10])``. Kinds and keys are\n"
             "those of docs/editing.md. One that is refused is on the list all the same, and "
             "changes\nnothing. Raises OptionsError for what is no edit.");
  editor.def("add_toml", &Editor::add_all, nb::arg("toml"), nb::arg("name") = "edits",
             "All ``[[edit]]`` tables of a text, in their order.");
  editor.def("undo", &Editor::undo, "Takes the last one away; False when there is none.");
  editor.def("__len__", &Editor::size);
  editor.def_prop_ro("reports", &Editor::reports, "What became of each.");
  editor.def("to_toml", &Editor::toml, "The list, as ``loopstone edit --edits`` takes it.");
  def_array(
      editor, "map_T_keys",
      [](Editor& self) {
        const EditPreview preview = self.preview();
        return to_array(std::span<const Pose2>(preview.map_T_keys));
      },
      "(K, 3) of the graph's nodes with all edits so far, in the frame that they ask for.");
  editor.def_prop_ro(
      "verdict", [](Editor& self) { return word(self.preview().verdict); },
      "Of the graph with all edits so far, before the map is drawn.");
  editor.def_prop_ro(
      "loop_closures", [](Editor& self) { return self.preview().closures; },
      "With all edits so far.");
  editor.def(
      "draw", &Editor::draw, nb::arg("progress") = nb::none(),
      nb::sig("def draw(self, progress: collections.abc.Callable[[str, int, int, int, "
              "float], object] | None = None) -> MapResult"),
      "The map with the edits, with all that map() gives but the floor's colour; its save()\n"
      "writes the edits and the masks of zones, too. Raises UsageError while one is refused.");
  editor.def("__repr__", [](Editor& self) {
    return "<MapEditor with " + std::to_string(self.size()) + " edits>";
  });
  m.def("add_edit", &Editor::add, nb::arg("editor"), nb::arg("toml"));
}

}  // namespace loopstone::python
