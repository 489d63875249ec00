#include "edited_folder.hpp"

#include <filesystem>
#include <nlohmann/json.hpp>
#include <utility>

#include "loopstone/base/error.hpp"
#include "loopstone/base/words.hpp"
#include "loopstone/formats/options_file.hpp"
#include "loopstone/formats/robot_file.hpp"
#include "loopstone/slam/mapper.hpp"
#include "loopstone/slam/mapper_state.hpp"
#include "loopstone/slam/settled_map.hpp"
#include "map_pipeline.hpp"
#include "session_folder.hpp"

namespace loopstone::app {

namespace {

using Json = nlohmann::json;

/// What is missing, or is something else, is 0.
std::int64_t count_in(const Json& json, const char* key) {
  const auto found = json.find(key);
  return found != json.end() && found->is_number_integer() ? found->get<std::int64_t>() : 0;
}

std::string text_in(const Json& json, const char* key) {
  const auto found = json.find(key);
  return found != json.end() && found->is_string() ? found->get<std::string>() : std::string();
}

Json object_in(const Json& json, const char* key) {
  const auto found = json.find(key);
  return found != json.end() && found->is_object() ? *found : Json::object();
}

/// As left_out_json() tells it.
LeftOut left_out_in(const Json& json) {
  LeftOut left_out;
  left_out.skipped.records = count_in(json, "records");
  left_out.skipped.scans = count_in(json, "scans");
  left_out.records_read = count_in(json, "records_of") - left_out.skipped.records;
  left_out.scans_read = count_in(json, "scans_of") - left_out.skipped.scans;
  if (const auto since = json.find("since_s"); since != json.end() && since->is_number())
    left_out.since_s = since->get<double>();
  if (const auto reasons = json.find("reasons"); reasons != json.end() && reasons->is_array()) {
    for (const Json& reason : *reasons) {
      if (!reason.is_object()) continue;
      left_out.skipped.reasons.push_back({.reason = text_in(reason, "reason"),
                                          .first = {text_in(reason, "first"), {}, {}},
                                          .records = count_in(reason, "records")});
    }
  }
  return left_out;
}

}  // namespace

EditedFolder read_edited_folder(const std::string& out) {
  const Json summary = summary_of(out);
  // A run that was killed leaves its state alone: what it has led to is a map, too.
  if (summary.is_null() && std::filesystem::exists(state_path(out))) return {};
  const auto complete = summary.find("complete");
  if (complete == summary.end() || *complete != true) {
    throw DataError({out},
                    "holds no map to edit: no summary.json of a run that came to its end; "
                    "`loopstone map LOG -o FOLDER --keep-state` leaves one");
  }
  EditedFolder folder{.log = text_in(summary, "log"),
                      .left_out = left_out_in(object_in(summary, "left_out")),
                      .has_texture = summary.contains("texture"),
                      .was_edited = summary.contains("edits")};
  if (const auto list = summary.find("log_warnings"); list != summary.end() && list->is_array()) {
    for (const Json& warning : *list)
      if (warning.is_string()) folder.log_warnings.push_back(warning.get<std::string>());
  }
  folder.verdict = find_word<Verdict>(text_in(object_in(summary, "quality"), "verdict"))
                       .value_or(Verdict::kUnknown);
  if (folder.was_edited)
    folder.edits = read_edits_file((std::filesystem::path(out) / "edits.toml").string());
  return folder;
}

SettledMap settle_kept_map(const std::string& out, const AppContext& context, KeptMap& kept) {
  Session session = read_kept_session(out, "edit", context);
  const std::string path = state_path(out);
  if (session.terms.robot_toml.empty()) {
    throw DataError({path},
                    "does not tell its robot; `loopstone map LOG -o FOLDER --keep-state` "
                    "makes one that does");
  }
  kept.robot = parse_robot(session.terms.robot_toml, path);
  kept.options_toml = session.terms.options_toml;
  std::vector<OptionProblem> problems =
      apply_toml(list_options(kept.options), kept.options_toml, path);
  if (!problems.empty()) throw OptionsError(std::move(problems));
  kept.options.map.most_cells = most_cells(context);
  Mapper mapper(kept.robot, kept.options, context.threads());
  try {
    mapper.restore_state(std::move(session.mapper));
  } catch (const UsageError& error) {
    throw DataError({path}, std::string("is damaged: ") + error.what());
  }
  return mapper.settle();
}

MapEditor open_kept_map(const std::string& out, const AppContext& context, KeptMap& kept) {
  return MapEditor(settle_kept_map(out, context, kept), context.threads());
}

}  // namespace loopstone::app
