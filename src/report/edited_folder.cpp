#include "loopstone/report/edited_folder.hpp"

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <system_error>

#include "formats/atomic_file.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/base/words.hpp"
#include "loopstone/formats/session_file.hpp"

namespace loopstone {

namespace {

using Json = nlohmann::json;
namespace fs = std::filesystem;

/// Null when there is none or it is no JSON.
Json summary_of(const std::string& folder, const MemoryBudget& budget) {
  const fs::path path = fs::path(folder) / "summary.json";
  std::error_code ignored;
  if (!fs::is_regular_file(path, ignored)) return {};
  Json summary =
      Json::parse(read_whole_file(path.string(), budget.most_text_bytes()), nullptr, false);
  return summary.is_object() ? summary : Json();
}

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

EditedFolder read_edited_folder(const std::string& folder, const MemoryBudget& budget) {
  const Json summary = summary_of(folder, budget);
  // A run that was killed leaves its state alone: what it has led to is a map, too.
  std::error_code ignored;
  if (summary.is_null() && fs::exists(kept_state_path(folder), ignored)) return {};
  const auto complete = summary.find("complete");
  if (complete == summary.end() || *complete != true) {
    throw DataError({folder},
                    "holds no map to edit: no summary.json of a run that came to its end; "
                    "`loopstone map LOG -o FOLDER --keep-state` leaves one");
  }
  EditedFolder edited{.log = text_in(summary, "log"),
                      .left_out = left_out_in(object_in(summary, "left_out")),
                      .has_texture = summary.contains("texture"),
                      .was_edited = summary.contains("edits")};
  if (const auto list = summary.find("log_warnings"); list != summary.end() && list->is_array()) {
    for (const Json& warning : *list)
      if (warning.is_string()) edited.log_warnings.push_back(warning.get<std::string>());
  }
  edited.verdict = find_word<Verdict>(text_in(object_in(summary, "quality"), "verdict"))
                       .value_or(Verdict::kUnknown);
  if (edited.was_edited) edited.edits = read_edits_file((fs::path(folder) / "edits.toml").string());
  return edited;
}

}  // namespace loopstone
