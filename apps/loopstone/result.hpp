#pragma once

#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "app.hpp"
#include "loopstone/report/summary_figure.hpp"
#include "loopstone/slam/decision_numbers.hpp"

namespace loopstone::app {

/// What a command found, once for people (a short table with units) and once for scripts (one JSON
/// object).
///
///   Result result;
///   result.add("scans", "scans", statistics.scans);
///   result.add("ate.rmse_m", "absolute error, rmse", error.rmse, "m");
///   result.print(context);
class Result {
 public:
  /// \param key   of the JSON object; dots nest: "ate.rmse_m"
  /// \param label for people
  Result& add(std::string_view key, std::string_view label, double value,
              std::string_view unit = "", int digits = 4);
  Result& add(std::string_view key, std::string_view label, std::int64_t value,
              std::string_view unit = "");
  Result& add(std::string_view key, std::string_view label, int value, std::string_view unit = "") {
    return add(key, label, static_cast<std::int64_t>(value), unit);
  }
  Result& add(std::string_view key, std::string_view label, std::size_t value,
              std::string_view unit = "") {
    return add(key, label, static_cast<std::int64_t>(value), unit);
  }
  Result& add(std::string_view key, std::string_view label, bool value);
  Result& add(std::string_view key, std::string_view label, const std::string& value);
  Result& add(std::string_view key, std::string_view label, const char* value) {
    return add(key, label, std::string(value));
  }
  /// Only in the JSON object; a number that is not finite becomes null.
  Result& add_json(std::string_view key, nlohmann::ordered_json value);
  /// Only in the table: one row, or with an empty label a line of its own.
  Result& add_row(std::string_view label, std::string text, std::string_view unit = "");

  /// On stdout; JSON with --json. Throws DataError when stdout does not take it.
  void print(const AppContext& context) const;

  [[nodiscard]] const nlohmann::ordered_json& json() const { return json_; }
  /// Each number of the JSON object.
  [[nodiscard]] std::vector<SummaryFigure> figures() const;
  [[nodiscard]] std::string table() const;

 private:
  struct Row {
    std::string label;
    std::string text;
    std::string unit;
  };
  std::vector<Row> rows_{};
  nlohmann::ordered_json json_ = nlohmann::ordered_json::object();
};

/// What was decided by, for scripts: groups of names and values.
[[nodiscard]] nlohmann::ordered_json numbers_json(std::span<const NumberGroup> groups);

/// Writes to stdout, with_escaped_controls(), and makes sure that it arrived. Throws DataError when
/// it did not (disk full, closed pipe).
void print_to_stdout(std::string_view document);

}  // namespace loopstone::app
