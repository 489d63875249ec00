#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "loopstone/base/error.hpp"
#include "loopstone/base/stamp.hpp"

namespace loopstone {

/// A line of a table whose columns are found by their names. Texts hold no commas.
class CsvRow {
 public:
  CsvRow(const std::vector<std::string>& columns, std::vector<std::string_view> cells,
         const Location& where)
      : columns_(columns), cells_(std::move(cells)), where_(where) {}

  /// Empty when there is no such column.
  [[nodiscard]] std::string_view text(std::string_view column) const;
  /// Throws DataError when the cell is empty or no finite number.
  [[nodiscard]] double number(std::string_view column) const;
  /// Nothing in an empty cell.
  [[nodiscard]] std::optional<double> number_or_nothing(std::string_view column) const;
  /// A count, from 0 up to two thousand millions.
  [[nodiscard]] std::int32_t count(std::string_view column) const;
  [[nodiscard]] std::optional<Stamp> stamp_or_nothing(std::string_view column) const;

  [[noreturn]] void refuse(std::string_view column, const std::string& reason) const;

 private:
  const std::vector<std::string>& columns_;
  std::vector<std::string_view> cells_;
  const Location& where_;
};

/// Calls visit for each line below the first one, which names the columns. Throws DataError for a
/// line with another number of cells.
void for_each_csv_row(std::string_view text, const std::string& path,
                      const std::function<void(const CsvRow&)>& visit);

}  // namespace loopstone
