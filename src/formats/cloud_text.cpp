#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "formats/cloud_parts.hpp"
#include "formats/text_lines.hpp"
#include "formats/text_numbers.hpp"
#include "loopstone/formats/point_cloud_file.hpp"

namespace loopstone {
namespace {

using Words = std::vector<std::string_view>;

/// What stands between the columns; blank: any number of blanks and tabs.
char delimiter_of(std::string_view line) {
  for (const char candidate : {';', ','}) {
    if (line.find(candidate) != line.npos) return candidate;
  }
  return ' ';
}

Words split(std::string_view line, char delimiter) {
  if (delimiter == ' ') return split_words(line);
  Words words;
  while (true) {
    const std::size_t end = line.find(delimiter);
    words.push_back(trim(line.substr(0, end)));
    if (end == line.npos) break;
    line.remove_prefix(end + 1);
  }
  // A delimiter at the end of a line makes no column.
  if (words.size() > 1 && words.back().empty()) words.pop_back();
  return words;
}

/// 0, 1, 2 when a column's name is that of x, y or z: x, "X", x_m, x [m], Points:0, point.x.
std::optional<std::size_t> axis_of(std::string_view word) {
  std::string name;
  for (const char c : word) {
    if (c == '[' || c == '(') break;
    if (c != '"' && c != '\'' && c != ' ') {
      name += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    }
  }
  if (name.ends_with("_m")) name.resize(name.size() - 2);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::string letter(1, static_cast<char>('x' + axis));
    const std::string digit(1, static_cast<char>('0' + axis));
    if (name == letter || name == "point." + letter || name == "points:" + digit ||
        name == "points_" + digit) {
      return axis;
    }
  }
  return std::nullopt;
}

/// Which column is x, y and z.
struct Columns {
  char delimiter = ' ';
  std::array<std::optional<std::size_t>, 3> of_axis{};

  [[nodiscard]] bool complete() const { return of_axis[0] && of_axis[1]; }
  [[nodiscard]] std::size_t least_count() const {
    std::size_t count = 0;
    for (const auto& column : of_axis) count = std::max(count, column ? *column + 1 : 0);
    return count;
  }
};

Columns named_columns(std::string_view line) {
  Columns columns{delimiter_of(line), {}};
  // Names between tabs may have blanks in them.
  const bool tabs = columns.delimiter == ' ' && line.find('\t') != line.npos;
  const Words words = split(line, tabs ? '\t' : columns.delimiter);
  for (std::size_t i = 0; i < words.size(); ++i) {
    const auto axis = axis_of(words[i]);
    if (axis && !columns.of_axis[*axis]) columns.of_axis[*axis] = i;
  }
  return columns;
}

Columns first_columns(std::string_view line) {
  Columns columns{delimiter_of(line), {}};
  const std::size_t count = split(line, columns.delimiter).size();
  for (std::size_t i = 0; i < std::min<std::size_t>(count, 3); ++i) columns.of_axis[i] = i;
  return columns;
}

std::string_view without_comment_mark(std::string_view line) {
  while (!line.empty() && (line.front() == '#' || line.front() == '%' || line.front() == '/')) {
    line.remove_prefix(1);
  }
  return trim(line);
}

bool is_comment(std::string_view line) {
  return line.front() == '#' || line.front() == '%' || line.starts_with("//");
}

class CloudTextParser {
 public:
  explicit CloudTextParser(std::string path) : path_(std::move(path)) {}

  void take(std::string_view raw_line, std::int64_t number) {
    const std::string_view line = trim(raw_line);
    if (line.empty()) return;
    const Location where{path_, number};
    if (is_comment(line)) {
      if (!columns_) take_names(without_comment_mark(line));
      return;
    }
    if (!columns_ && !take_first_line(line, where)) return;
    cloud_.points.push_back(parse_point(line, where));
  }

  [[nodiscard]] PointCloud finish() && {
    const bool has_z = columns_ && columns_->of_axis[2].has_value();
    return finish_cloud(std::move(cloud_), has_z, path_);
  }

 private:
  bool take_names(std::string_view line) {
    const Columns named = named_columns(line);
    if (!named.complete()) return false;
    columns_ = named;
    return true;
  }

  /// The first line that is no comment: names, the number of points, or the first point. True when
  /// it is a point.
  bool take_first_line(std::string_view line, const Location& where) {
    const char delimiter = delimiter_of(line);
    const Words words = split(line, delimiter);
    if (words.size() == 1 && parse_integer(words[0]) && !count_seen_) {
      count_seen_ = true;  // .pts begins so
      return false;
    }
    const bool numbers = std::all_of(words.begin(), words.end(),
                                     [](std::string_view word) { return parse_number(word); });
    if (!numbers && take_names(line)) return false;
    const bool begins_with_number = parse_number(words[0]).has_value();
    if (!begins_with_number && !names_skipped_) {
      names_skipped_ = true;  // names that name no x and y
      return false;
    }
    columns_ = first_columns(line);
    if (!columns_->complete()) {
      throw DataError(where,
                      "has a single column; a cloud needs x and y, or x, y and z, between "
                      "commas, semicolons, tabs or blanks");
    }
    return true;
  }

  [[nodiscard]] Eigen::Vector3d parse_point(std::string_view line, const Location& where) const {
    const Words words = split(line, columns_->delimiter);
    if (words.size() < columns_->least_count()) {
      throw DataError(where, fmt::format("has {} columns; {} are needed for the coordinates",
                                         words.size(), columns_->least_count()));
    }
    Eigen::Vector3d point = Eigen::Vector3d::Zero();
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (!columns_->of_axis[axis]) continue;
      const std::string_view word = words[*columns_->of_axis[axis]];
      const auto value = parse_number(word);
      if (!value) {
        throw DataError(where, show_word(word) + " is no number" +
                                   (word.find(',') == word.npos ? "" : "; write 1.5, not 1,5"));
      }
      point(static_cast<Eigen::Index>(axis)) = *value;
    }
    return point;
  }

  std::string path_;
  PointCloud cloud_;
  std::optional<Columns> columns_;
  bool count_seen_ = false;
  bool names_skipped_ = false;
};

}  // namespace

PointCloud decode_cloud_text(std::string_view text, const std::string& path,
                             const MemoryBudget& budget) {
  if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);  // byte order mark of UTF-8
  if (text.substr(0, 4096).find('\0') != text.npos) {
    throw DataError({path},
                    "is neither text nor a format of point clouds that is known: PCD, PLY, "
                    "NPY, MAT v5");
  }
  const auto line_ends = static_cast<std::uint64_t>(std::count(text.begin(), text.end(), '\n'));
  require_points(line_ends + 1, 0, text.size(), budget, {path});
  CloudTextParser parser(path);
  for_each_line(text,
                [&](std::string_view line, std::int64_t number) { parser.take(line, number); });
  return std::move(parser).finish();
}

}  // namespace loopstone
