#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "app.hpp"
#include "commands.hpp"
#include "edited_folder.hpp"
#include "interrupt.hpp"
#include "log_run.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/formats/session_file.hpp"
#include "loopstone/geometry/angle.hpp"
#include "loopstone/report/edit_outputs.hpp"
#include "loopstone/report/map_figures.hpp"
#include "loopstone/report/map_outputs.hpp"
#include "loopstone/report/peak_memory.hpp"
#include "output_path.hpp"
#include "progress_display.hpp"
#include "result.hpp"
#include "session_folder.hpp"

namespace loopstone::app {

namespace {

constexpr const char* kFooter = R"(
Edits are [[edit]] tables of a TOML file, done in their order; docs/editing.md has every kind and key:
  delete_closure, add_closure   places that are one, or are not
  ignore                        a stretch of the path whose scans are not used
  crop, erase                   what lies outside goes; what stands inside goes
  straighten, origin            how the map lies in its frame
  keep_out, speed               zones, as masks for nav2
Examples:
  loopstone map LOG -o out --keep-state
  loopstone edit out --edits edits.toml --check        what each edit would do
  loopstone edit out --edits edits.toml -o out2        the map with them; out stays as it is)";

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

struct Arguments {
  std::string folder;
  std::string edits;
  std::string out;
  bool check = false;
  bool force = false;
};

std::string moved_text(const MapShift& shift) {
  if (shift.largest_m == 0.0 && shift.largest_rad == 0.0) return "nothing moved";
  return fmt::format("key scans moved {:.3f} m on average, {:.3f} m and {:.2f} deg at most",
                     shift.mean_m, shift.largest_m, degrees(shift.largest_rad));
}

/// One line for what it did, one for what it did to the graph.
void add_edit_rows(std::size_t number, const ToldEdit& edit, Result& table) {
  const EditReport& report = edit.report;
  table.add_row(fmt::format("{} {}", number, edit.kind),
                (report.applied ? "" : "refused: ") + report.told);
  if (!report.applied || (report.shift.largest_m == 0.0 && !report.closure)) return;
  std::string graph = moved_text(report.shift);
  if (report.closures_revoked > 0)
    graph += fmt::format("; {} closures contradict the graph now", report.closures_revoked);
  graph += fmt::format(
      "; loops close with {:.2f} of the squared error promised, {:.2f} before; "
      "graph {}, {} before",
      report.reduced_chi2, report.reduced_chi2_before, to_string(report.verdict),
      to_string(report.verdict_before));
  table.add_row("", graph);
}

void print_check(const EditOutputs& edits, const AppContext& context) {
  if (context.json()) {
    print_to_stdout(format_edits(edits));
    return;
  }
  Result table;
  for (std::size_t i = 0; i < edits.edits.size(); ++i) add_edit_rows(i + 1, edits.edits[i], table);
  table.add_row("all edits", moved_text(edits.shift));
  table.add_row("time", fmt::format("{:.2f} s to open the map, {:.3f} s for the edits",
                                    edits.open_s, edits.edit_s));
  table.print(context);
}

void print_result(const MapResult& result, const EditOutputs& edits, const RunInfo& info,
                  const Arguments& arguments, const AppContext& context) {
  if (context.json()) {
    print_to_stdout(format_summary(result, info, {.edits = &edits}));
    return;
  }
  Result table;
  for (std::size_t i = 0; i < edits.edits.size(); ++i) add_edit_rows(i + 1, edits.edits[i], table);
  table.add_row("all edits", moved_text(edits.shift));
  table.add("map_free_area_m2", "free area mapped", figures_of(result.map).free_area_m2, "m2", 1);
  table.add_row("loop closures",
                fmt::format("{} accepted, {} rejected", result.statistics.loop_closures_accepted,
                            result.statistics.loop_closures_rejected));
  if (!edits.keep_out.empty() || !edits.speed.empty()) {
    table.add_row("zones", fmt::format("{} not to be entered, {} to go slowly in",
                                       edits.keep_out.size(), edits.speed.size()));
  }
  table.add_row("quality before", std::string(to_string(edits.verdict_before)));
  if (!result.verdict.sentence.empty()) table.add_row("quality", result.verdict.sentence);
  table.add_row("time",
                fmt::format("{:.2f} s to open the map, {:.3f} s for the edits, {:.2f} s to draw it",
                            edits.open_s, edits.edit_s, edits.draw_s));
  table.add_row("report", arguments.out + "/report.html");
  table.print(context);
}

/// Those of the list that are new are the last ones.
std::vector<std::string> refusals(const MapEditor& editor, const std::string& path,
                                  std::size_t done_before) {
  std::vector<std::string> lines;
  for (std::size_t i = 0; i < editor.size(); ++i) {
    if (editor.report(i).applied) continue;
    const MapEdit& edit = editor.edit(i);
    const std::string number = i < done_before ? fmt::format("an earlier edit ({})", i + 1)
                                               : fmt::format("edit {}", i + 1 - done_before);
    lines.push_back(fmt::format("{}: {} ({}) is refused: {}",
                                to_string(Location{path, edit.line, {}}), number, kind_of(edit),
                                editor.report(i).told));
  }
  return lines;
}

[[noreturn]] void throw_refusals(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += (text.empty() ? "" : "\n") + line;
  throw std::runtime_error(text);
}

EditOutputs outputs_of(const MapEditor& editor, const EditedFolder& folder, const EditsFile& edits,
                       const Arguments& arguments) {
  EditOutputs outputs{.edits_toml = edits.text,
                      .edited = arguments.folder,
                      .shift = editor.preview().shift,
                      .verdict_before = folder.verdict};
  for (std::size_t i = 0; i < editor.size(); ++i)
    outputs.edits.push_back({std::string(kind_of(editor.edit(i))), editor.report(i)});
  return outputs;
}

/// The edits that the folder has, and those of the file.
EditsFile all_edits(const EditedFolder& folder, const EditsFile& more) {
  return folder.was_edited ? joined(folder.edits, more) : more;
}

void do_edits(const EditsFile& edits, MapEditor& editor, ProgressDisplay& display) {
  std::int64_t done = 0;
  for (const MapEdit& edit : edits.edits) {
    display.show({"editing", done++, static_cast<std::int64_t>(edits.edits.size())});
    editor.add(edit);
  }
}

/// The results, what they were made of, and the state they can be made from again: all, or none.
void write_all(const MapResult& result, const EditOutputs& edits, RunInfo& info,
               const Outputs& outputs, const Arguments& arguments, const AppContext& context) {
  const Session session = read_session(kept_state_path(arguments.folder), context.memory());
  const HeldInterrupt held(
      "interrupted: the results are being written, which is soon done; once "
      "more ends it at once");
  outputs.prepare();
  write_map_outputs(result, info, arguments.out, {.edits = &edits});
  write_session(kept_state_path(arguments.out), session);
  info.peak_memory_bytes = peak_memory_bytes();
}

RunInfo info_of(const EditedFolder& folder, const KeptMap& kept, const Arguments& arguments,
                const AppContext& context) {
  RunInfo info = run_info(folder.log, folder.left_out, arguments.force, context);
  info.options_toml = kept.options_toml;
  info.log_warnings = folder.log_warnings;
  return info;
}

/// What the log gave reason to say of the map holds of the edited one, too.
void add_log_judgement(const EditedFolder& folder, MapResult& result) {
  result.warnings.insert(result.warnings.begin(), folder.log_warnings.begin(),
                         folder.log_warnings.end());
  judge_left_out(result.verdict, folder.left_out.share());
  if (folder.has_texture) result.warnings.emplace_back(kColourIsLost);
}

Outputs outputs_for(const Arguments& arguments, const AppContext& context) {
  if (arguments.out.empty() && !arguments.check)
    throw UsageError("-o FOLDER is needed for the results; --check only says what edits would do");
  if (!arguments.out.empty() && arguments.check)
    throw UsageError("--check writes nothing: leave out -o, or --check");
  Outputs outputs(context, arguments.force);
  outputs.reads(arguments.folder);
  if (!arguments.edits.empty()) outputs.reads(arguments.edits);
  if (!arguments.out.empty()) outputs.add_folder("-o", arguments.out);
  return outputs;
}

ExitCode run_edit(const Arguments& arguments, const AppContext& context) {
  const auto start = Clock::now();
  const Outputs outputs = outputs_for(arguments, context);
  outputs.check();
  const EditsFile more = arguments.edits.empty() ? EditsFile{} : read_edits_file(arguments.edits);
  const EditedFolder folder = read_edited_folder(arguments.folder);
  const EditsFile edits = all_edits(folder, more);

  ProgressDisplay display(context);
  display.show({"opening", 0, 0});
  KeptMap kept;
  MapEditor editor = open_kept_map(arguments.folder, context, kept);
  const double open_s = seconds_since(start);
  const auto editing = Clock::now();
  do_edits(edits, editor, display);
  ProgressDisplay::clear_line();
  EditOutputs told = outputs_of(editor, folder, edits, arguments);
  told.open_s = open_s;
  told.edit_s = seconds_since(editing);
  const std::vector<std::string> refused =
      refusals(editor, arguments.edits, edits.edits.size() - more.edits.size());
  if (arguments.check) print_check(told, context);
  if (!refused.empty()) throw_refusals(refused);
  if (arguments.check) return kExitDone;

  const auto drawing = Clock::now();
  EditedMap map = editor.draw(display.callback());
  ProgressDisplay::clear_line();
  add_log_judgement(folder, map.result);
  told.draw_s = seconds_since(drawing);
  told.new_T_map = map.new_T_map;
  told.cells_erased = map.cells_erased;
  told.keep_out = std::move(map.keep_out);
  told.speed = std::move(map.speed);
  RunInfo info = info_of(folder, kept, arguments, context);
  info.wall_time_s = seconds_since(start);
  write_all(map.result, told, info, outputs, arguments, context);
  for (const auto& warning : map.result.warnings) context.warn(warning);
  print_result(map.result, told, info, arguments, context);
  return kExitDone;
}

}  // namespace

void add_edit_command(CLI::App& app, AppContext& context) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command = app.add_subcommand(
      "edit", "Put a finished map right by hand: closures, stretches, frame, zones");
  command
      ->add_option("OUT", arguments->folder,
                   "a folder of results that `loopstone map --keep-state` left; it stays as it is")
      ->required();
  command
      ->add_option(
          "--edits", arguments->edits,
          "what to do, as TOML; without it the map is drawn as it is, which completes what a "
          "run left that was killed")
      ->type_name("FILE.toml");
  command
      ->add_option("-o,--out", arguments->out,
                   "folder for the results; made, or empty unless --force")
      ->type_name("OUT2");
  command->add_flag("--check", arguments->check,
                    "say what each edit would do, and write nothing; exit code 1 when one is "
                    "refused");
  add_force_flag(*command, arguments->force);
  context.add_common_flags(*command);
  context.add_threads_flag(*command);
  command->footer(kFooter);
  context.on_run(*command, [arguments, &context] { return run_edit(*arguments, context); });
}

}  // namespace loopstone::app
