#include "loopstone/formats/localization_csv.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <iterator>
#include <limits>
#include <optional>
#include <type_traits>

#include "formats/atomic_file.hpp"
#include "formats/text_lines.hpp"
#include "formats/text_numbers.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/formats/decimal_stamp.hpp"

namespace loopstone {
namespace {

using Estimate = LocalizationEstimate;

/// Calls visit(name, value, needed) for every column that holds a number, in the file's order. The
/// values lead into the estimate, so that writer and reader share one list.
template <typename Visitor>
void visit_numbers_before_state(Estimate& e, Visitor&& visit) {
  visit("x_m", e.map_T_robot.x, true);
  visit("y_m", e.map_T_robot.y, true);
  visit("yaw_rad", e.map_T_robot.yaw, true);
  visit("xx_m2", e.covariance(0, 0), true);
  visit("xy_m2", e.covariance(0, 1), true);
  visit("xyaw_m_rad", e.covariance(0, 2), true);
  visit("yy_m2", e.covariance(1, 1), true);
  visit("yyaw_m_rad", e.covariance(1, 2), true);
  visit("yawyaw_rad2", e.covariance(2, 2), true);
}

template <typename Visitor>
void visit_numbers_after_state(Estimate& e, Visitor&& visit) {
  visit("probability", e.probability, true);
  visit("refined", e.refined, false);
  visit("hypotheses", e.hypotheses, false);
  visit("particles", e.particles, false);
  visit("landmarks", e.landmarks, false);
  visit("travelled_m", e.travelled_m, false);
  visit("explained", e.evidence.explained, false);
  visit("violations", e.evidence.violations, false);
  visit("unexpected", e.evidence.unexpected, false);
  visit("mass", e.evidence.mass, false);
  visit("precision", e.evidence.precision, false);
  visit("spread_m", e.evidence.spread_m, false);
  visit("spread_rad", e.evidence.spread_rad, false);
  visit("innovation", e.evidence.innovation, false);
  visit("followed_m", e.evidence.followed_m, false);
  visit("known", e.evidence.known, false);
  visit("silent", e.evidence.silent, false);
  visit("unproven", e.evidence.unproven, false);
  visit("lately_explained", e.evidence.lately.explained, false);
  visit("lately_violations", e.evidence.lately.violations, false);
  visit("lately_unexpected", e.evidence.lately.unexpected, false);
  visit("lately_known", e.evidence.lately.known, false);
  visit("lately_silent", e.evidence.lately.silent, false);
  visit("along_explained", e.evidence.along.explained, false);
  visit("along_violations", e.evidence.along.violations, false);
  visit("along_unexpected", e.evidence.along.unexpected, false);
  visit("along_known", e.evidence.along.known, false);
  visit("along_silent", e.evidence.along.silent, false);
}

constexpr std::string_view kStamp = "t_s";
constexpr std::string_view kState = "state";

void append_cell(std::string& line, double value) {
  if (std::isfinite(value)) fmt::format_to(std::back_inserter(line), "{}", value + 0.0);
}
void append_cell(std::string& line, int value) {
  fmt::format_to(std::back_inserter(line), "{}", value);
}
void append_cell(std::string& line, bool value) { line += value ? '1' : '0'; }

std::string line_of(Estimate estimate) {
  std::string line = format_decimal_stamp(estimate.stamp);
  const auto append = [&](std::string_view /*name*/, const auto& value, bool /*needed*/) {
    line += ',';
    append_cell(line, value);
  };
  visit_numbers_before_state(estimate, append);
  line += ',';
  line += to_string(estimate.state);
  visit_numbers_after_state(estimate, append);
  return line + '\n';
}

std::string header_line() {
  std::string line(kStamp);
  const auto append = [&](std::string_view name, const auto& /*value*/, bool /*needed*/) {
    (line += ',') += name;
  };
  Estimate any;
  visit_numbers_before_state(any, append);
  (line += ',') += kState;
  visit_numbers_after_state(any, append);
  return line + '\n';
}

/// The lines below a header.
class CsvReader {
 public:
  CsvReader(std::string_view header, const Location& location) : columns_(split_cells(header)) {
    Estimate any;
    const auto require = [&](std::string_view name, const auto& /*value*/, bool needed) {
      if (needed && !column(name)) missing(name, location);
    };
    require(kStamp, 0, true);
    require(kState, 0, true);
    visit_numbers_before_state(any, require);
    visit_numbers_after_state(any, require);
  }

  [[nodiscard]] Estimate read(std::string_view line, const Location& location) const {
    const std::vector<std::string_view> cells = split_cells(line);
    if (cells.size() != columns_.size()) {
      throw DataError(location, fmt::format("the line has {} values, the first line names {}",
                                            cells.size(), columns_.size()));
    }
    Estimate estimate;
    const auto stamp = parse_decimal_stamp(cells[*column(kStamp)]);
    if (!stamp) throw DataError(location, "the time is no number of seconds");
    estimate.stamp = *stamp;
    estimate.state = state_of(cells[*column(kState)], location);
    const auto read_cell = [&](std::string_view name, auto& value, bool /*needed*/) {
      if (const auto at = column(name))
        value = number<std::decay_t<decltype(value)>>(cells[*at], name, location);
    };
    visit_numbers_before_state(estimate, read_cell);
    visit_numbers_after_state(estimate, read_cell);
    estimate.covariance.triangularView<Eigen::StrictlyLower>() = estimate.covariance.transpose();
    return estimate;
  }

 private:
  [[nodiscard]] std::optional<std::size_t> column(std::string_view name) const {
    const auto at = std::find(columns_.begin(), columns_.end(), name);
    if (at == columns_.end()) return std::nullopt;
    return static_cast<std::size_t>(at - columns_.begin());
  }
  [[noreturn]] static void missing(std::string_view name, const Location& location) {
    throw DataError(location, "there is no column " + std::string(name) +
                                  "; `loopstone localize` writes such files");
  }
  static LocalizationState state_of(std::string_view word, const Location& location) {
    if (const auto state = find_word<LocalizationState>(word)) return *state;
    throw DataError(
        location, "the state is '" + std::string(word) + "'; expected TRACKING, DOUBTFUL or LOST");
  }
  template <typename Value>
  static Value number(std::string_view word, std::string_view name, const Location& location) {
    if constexpr (std::is_same_v<Value, double>) {
      if (word.empty()) return std::numeric_limits<double>::quiet_NaN();
      const auto value = parse_number(word);
      if (value && std::isfinite(*value)) return *value;
    } else {
      const auto value = parse_integer(word);
      constexpr std::int64_t kMost =
          std::is_same_v<Value, bool> ? 1 : std::numeric_limits<int>::max();
      if (value && *value >= 0 && *value <= kMost) return static_cast<Value>(*value);
    }
    throw DataError(location,
                    "'" + std::string(word) + "' can't be a value of " + std::string(name));
  }

  std::vector<std::string_view> columns_;
};

}  // namespace

std::string format_localization_csv(const std::vector<LocalizationEstimate>& estimates) {
  std::string text = header_line();
  text.reserve(estimates.size() * 320);
  for (const LocalizationEstimate& estimate : estimates) text += line_of(estimate);
  return text;
}

std::vector<LocalizationEstimate> parse_localization_csv(std::string_view text,
                                                         const std::string& path_for_errors) {
  std::vector<LocalizationEstimate> estimates;
  std::optional<CsvReader> reader;
  for_each_line(text, [&](std::string_view line, std::int64_t number) {
    const std::string_view content = trim(line);
    if (content.empty()) return;
    const Location location{path_for_errors, number};
    if (!reader) {
      reader.emplace(content, location);
    } else {
      estimates.push_back(reader->read(content, location));
    }
  });
  if (!reader) throw DataError({path_for_errors}, "is empty; expected a line of column names");
  return estimates;
}

void write_localization_csv(const std::string& path,
                            const std::vector<LocalizationEstimate>& estimates) {
  write_file_atomically(path, format_localization_csv(estimates));
}

std::vector<LocalizationEstimate> read_localization_csv(const std::string& path,
                                                        const MemoryBudget& budget) {
  return parse_localization_csv(read_whole_file(path, budget.most_text_bytes()), path);
}

}  // namespace loopstone
