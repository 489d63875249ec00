#include "report/csv_table.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "formats/text_lines.hpp"
#include "loopstone/formats/decimal_stamp.hpp"

namespace loopstone {
namespace {}  // namespace

std::string_view CsvRow::text(std::string_view column) const {
  const auto found = std::ranges::find(columns_, column);
  if (found == columns_.end()) return {};
  return cells_[static_cast<std::size_t>(found - columns_.begin())];
}

void CsvRow::refuse(std::string_view column, const std::string& reason) const {
  throw DataError(where_, std::string(column) + " " + reason);
}

double CsvRow::number(std::string_view column) const {
  const std::string_view word = text(column);
  if (word.empty()) refuse(column, "is missing");
  return parse_finite(word, where_);
}

std::optional<double> CsvRow::number_or_nothing(std::string_view column) const {
  const std::string_view word = text(column);
  if (word.empty()) return {};
  return parse_finite(word, where_);
}

std::int32_t CsvRow::count(std::string_view column) const {
  const double value = number(column);
  if (value < 0.0 || value > std::numeric_limits<std::int32_t>::max() || value != std::floor(value))
    refuse(column, "is no count");
  return static_cast<std::int32_t>(value);
}

std::optional<Stamp> CsvRow::stamp_or_nothing(std::string_view column) const {
  const std::string_view word = text(column);
  if (word.empty()) return {};
  const auto stamp = parse_decimal_stamp(word);
  if (!stamp) refuse(column, "is no number of seconds");
  return stamp;
}

void for_each_csv_row(std::string_view text, const std::string& path,
                      const std::function<void(const CsvRow&)>& visit) {
  std::vector<std::string> columns;
  for_each_line(text, [&](std::string_view line, std::int64_t number) {
    if (trim(line).empty()) return;
    std::vector<std::string_view> cells = split_cells(line);
    if (columns.empty()) {
      columns.assign(cells.begin(), cells.end());
      return;
    }
    const Location where{path, number};
    if (cells.size() != columns.size()) {
      throw DataError(where, "the line has " + std::to_string(cells.size()) +
                                 " values, the first line names " + std::to_string(columns.size()));
    }
    visit(CsvRow(columns, std::move(cells), where));
  });
}

}  // namespace loopstone
