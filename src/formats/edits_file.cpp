#include "loopstone/formats/edits_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <type_traits>
#include <utility>

#include "formats/atomic_file.hpp"
#include "formats/toml_values.hpp"
#include "loopstone/formats/decimal_stamp.hpp"
#include "loopstone/geometry/angle.hpp"

namespace loopstone {

namespace {

/// No map reaches farther.
constexpr double kFarthest_m = 1e6;
/// So many corners nobody draws by hand.
constexpr std::size_t kMostCorners = 1000;
constexpr double kLatest_s = 4e9;

/// The keys of one [[edit]], each of which is asked for once; what nobody asked for is unknown.
class EditTable {
 public:
  EditTable(std::string name, std::int64_t line, const std::string& path,
            std::vector<OptionProblem>& problems)
      : name_(std::move(name)), line_(line), path_(path), problems_(problems) {}

  void add(std::string key, const TomlValue& value) { values_.emplace(std::move(key), &value); }

  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] std::int64_t line() const { return line_; }
  [[nodiscard]] bool has(const std::string& key) const { return values_.contains(key); }

  [[nodiscard]] std::optional<std::string> text(const std::string& key) {
    return take<std::string>(key, "must be a text", [](const TomlValue& value) {
      const auto* given = std::get_if<std::string>(&value.value);
      return given != nullptr ? std::optional(*given) : std::nullopt;
    });
  }
  [[nodiscard]] std::optional<bool> flag(const std::string& key) {
    return take<bool>(key, "must be true or false", [](const TomlValue& value) {
      const auto* given = std::get_if<bool>(&value.value);
      return given != nullptr ? std::optional(*given) : std::nullopt;
    });
  }
  [[nodiscard]] std::optional<double> number(const std::string& key, double low, double high) {
    const std::string rule = fmt::format("must be a number from {} to {}", low, high);
    return take<double>(key, rule, [&](const TomlValue& value) -> std::optional<double> {
      const auto given = as_number(value);
      if (!given || !(*given >= low && *given <= high)) return {};
      return given;
    });
  }
  [[nodiscard]] std::optional<std::int64_t> index(const std::string& key) {
    return take<std::int64_t>(key, "must be a whole number from 0",
                              [](const TomlValue& value) -> std::optional<std::int64_t> {
                                const auto* given = std::get_if<std::int64_t>(&value.value);
                                if (given == nullptr || *given < 0 || !std::in_range<int>(*given))
                                  return {};
                                return *given;
                              });
  }
  /// A number, or in quotes with every digit.
  [[nodiscard]] std::optional<Stamp> stamp(const std::string& key) {
    return take<Stamp>(
        key,
        "must be a stamp of the map's clock in seconds, such as 976052857.339 or \"976052857.339\"",
        [](const TomlValue& value) -> std::optional<Stamp> {
          if (const auto* text = std::get_if<std::string>(&value.value)) {
            const auto stamp = parse_decimal_stamp(*text);
            return stamp && std::abs(stamp->seconds()) <= kLatest_s ? stamp : std::nullopt;
          }
          const auto given = as_number(value);
          if (!given || !(std::abs(*given) <= kLatest_s)) return {};
          return Stamp::from_seconds(*given);
        });
  }
  [[nodiscard]] std::optional<std::vector<std::vector<double>>> rows(const std::string& key,
                                                                     const std::string& rule) {
    return take<std::vector<std::vector<double>>>(
        key, rule, [](const TomlValue& value) { return value.rows; });
  }

  /// Something is wrong with what a key says, or with the edit as a whole.
  void complain(const std::string& key, const std::string& rule) {
    const auto value = values_.find(key);
    const bool is_there = value != values_.end();
    problems_.push_back({key.empty() ? name_ : name_ + "." + key,
                         is_there ? value->second->text : std::string{},
                         rule,
                         {path_, is_there ? value->second->line : line_, {}}});
  }
  /// What was never asked for.
  void finish() {
    for (const auto& [key, value] : values_) {
      if (asked_.contains(key)) continue;
      const std::vector<std::string> known(asked_.begin(), asked_.end());
      const std::string nearest = nearest_key(key, known);
      problems_.push_back({name_ + "." + key,
                           {},
                           nearest.empty()
                               ? "unknown key of this kind of edit; docs/editing.md has all"
                               : "unknown key; did you mean " + nearest + "?",
                           {path_, value->line, {}}});
    }
  }

 private:
  [[nodiscard]] static std::optional<double> as_number(const TomlValue& value) {
    if (const auto* real = std::get_if<double>(&value.value)) return *real;
    if (const auto* whole = std::get_if<std::int64_t>(&value.value))
      return static_cast<double>(*whole);
    return {};
  }
  template <typename T, typename Read>
  [[nodiscard]] std::optional<T> take(const std::string& key, const std::string& rule,
                                      Read&& read) {
    asked_.insert(key);
    const auto value = values_.find(key);
    if (value == values_.end()) return {};
    std::optional<T> taken = read(*value->second);
    if (!taken) complain(key, rule);
    return taken;
  }

  std::string name_;
  std::int64_t line_;
  const std::string& path_;
  std::vector<OptionProblem>& problems_;
  std::map<std::string, const TomlValue*> values_{};
  std::set<std::string> asked_{};
};

/// A place of the path by the keys that begin with `prefix`: "from_".
PathPlace read_place(EditTable& table, const std::string& prefix) {
  return {.stamp = table.stamp(prefix + "t_s"),
          .drive_s = table.number(prefix + "s", 0.0, kLatest_s),
          .node = table.index(prefix + "node")};
}

/// How many of the keys of a place are there, whatever they hold.
int named(const EditTable& table, const std::string& prefix) {
  int count = 0;
  for (const char* const key : {"t_s", "s", "node"}) count += table.has(prefix + key) ? 1 : 0;
  return count;
}

PathPlace require_place(EditTable& table, const std::string& prefix) {
  const PathPlace place = read_place(table, prefix);
  if (named(table, prefix) != 1) {
    table.complain({}, fmt::format("must tell one of {0}s (seconds after the first scan), {0}t_s "
                                   "(a stamp) and {0}node",
                                   prefix));
  }
  return place;
}

/// Of what lies on the map.
PathPlace read_anchor(EditTable& table) {
  const PathPlace place = read_place(table, "anchor_");
  if (named(table, "anchor_") > 1)
    table.complain({}, "must tell no more than one of anchor_s, anchor_t_s and anchor_node");
  return place;
}

bool all_near(const std::vector<double>& numbers) {
  return std::ranges::all_of(numbers,
                             [](double number) { return std::abs(number) <= kFarthest_m; });
}

std::optional<Polygon2> read_box(EditTable& table) {
  static constexpr const char* kRule =
      "must be [min_x, min_y, max_x, max_y] in metres, min less than max";
  const auto rows = table.rows("box", kRule);
  if (!rows) return {};
  if (rows->size() != 1 || rows->front().size() != 4 || !all_near(rows->front())) {
    table.complain("box", kRule);
    return {};
  }
  const std::vector<double>& box = rows->front();
  const Polygon2 polygon = box_polygon({box[0], box[1]}, {box[2], box[3]});
  if (!(box[0] < box[2] && box[1] < box[3]) || fault_of(polygon)) table.complain("box", kRule);
  return polygon;
}

std::optional<Polygon2> read_corners(EditTable& table) {
  const std::string rule =
      fmt::format("must be [[x, y], [x, y], ...] in metres, three corners at least and {} at most",
                  kMostCorners);
  const auto rows = table.rows("polygon", rule);
  if (!rows) return {};
  Polygon2 polygon;
  for (const std::vector<double>& row : *rows) {
    if (row.size() != 2 || !all_near(row) || rows->size() > kMostCorners) {
      table.complain("polygon", rule);
      return {};
    }
    polygon.corners.emplace_back(row[0], row[1]);
  }
  if (const auto fault = fault_of(polygon)) table.complain("polygon", "must " + *fault);
  return polygon;
}

Polygon2 read_polygon(EditTable& table) {
  const auto box = read_box(table);
  const auto corners = read_corners(table);
  if (table.has("box") == table.has("polygon"))
    table.complain({}, "must tell one of polygon and box");
  return corners ? *corners : box.value_or(Polygon2{});
}

DeleteClosure read_delete(EditTable& table) {
  DeleteClosure edit{.from_submap = table.index("from_submap"),
                     .to_submap = table.index("to_submap")};
  if (table.has("from_submap") || table.has("to_submap")) {
    if (!table.has("from_submap") || !table.has("to_submap"))
      table.complain({}, "must tell from_submap and to_submap, both");
    return edit;
  }
  edit.from = require_place(table, "from_");
  edit.to = require_place(table, "to_");
  return edit;
}

AddClosure read_add(EditTable& table) {
  AddClosure edit{.from = require_place(table, "from_"), .to = require_place(table, "to_")};
  const auto x_m = table.number("x_m", -kFarthest_m, kFarthest_m);
  const auto y_m = table.number("y_m", -kFarthest_m, kFarthest_m);
  const auto yaw_rad = table.number("yaw_rad", -2.0 * kPi, 2.0 * kPi);
  if (table.has("x_m") || table.has("y_m") || table.has("yaw_rad")) {
    if (!(table.has("x_m") && table.has("y_m") && table.has("yaw_rad")))
      table.complain({},
                     "a guess needs all of x_m, y_m and yaw_rad: where `to` is, seen from `from`");
    edit.guess_from_T_to =
        Pose2{x_m.value_or(0.0), y_m.value_or(0.0), wrap_angle(yaw_rad.value_or(0.0))};
  }
  edit.half_window_m = table.number("half_window_m", 0.05, 30.0);
  edit.half_window_rad = table.number("half_window_rad", 0.005, kPi);
  edit.force = table.flag("force").value_or(false);
  return edit;
}

SetOrigin read_origin(EditTable& table) {
  const auto x_m = table.number("x_m", -kFarthest_m, kFarthest_m);
  const auto y_m = table.number("y_m", -kFarthest_m, kFarthest_m);
  if (!table.has("x_m") || !table.has("y_m")) table.complain({}, "must tell x_m and y_m");
  SetOrigin edit{.point = {x_m.value_or(0.0), y_m.value_or(0.0)}};
  if (const auto yaw_rad = table.number("yaw_rad", -2.0 * kPi, 2.0 * kPi))
    edit.yaw_rad = wrap_angle(*yaw_rad);
  return edit;
}

LimitSpeed read_speed(EditTable& table) {
  LimitSpeed edit{.name = table.text("name").value_or(""), .polygon = read_polygon(table)};
  const auto percent = table.number("percent", 1.0, 100.0);
  const auto limit = table.number("limit_m_s", 0.001, 1000.0);
  if (table.has("percent") == table.has("limit_m_s"))
    table.complain({}, "must tell one of percent (of the robot's speed) and limit_m_s");
  if (limit) {
    edit.limit = *limit;
    edit.unit = SpeedUnit::kMetresPerSecond;
  } else {
    edit.limit = percent.value_or(0.0);
  }
  return edit;
}

/// The kinds of edits by their words.
const std::vector<std::string>& kinds() {
  static const std::vector<std::string> all = [] {
    std::vector<std::string> words;
    for (const decltype(MapEdit::what)& what : {decltype(MapEdit::what){DeleteClosure{}},
                                                {AddClosure{}},
                                                {IgnoreStretch{}},
                                                {CropMap{}},
                                                {EraseInside{}},
                                                {StraightenMap{}},
                                                {SetOrigin{}},
                                                {KeepOut{}},
                                                {LimitSpeed{}},
                                                {MapAsEdited{}}})
      words.emplace_back(kind_of({.what = what}));
    return words;
  }();
  return all;
}

std::string choice_of_kinds() {
  std::string choice;
  for (const std::string& kind : kinds()) choice += (choice.empty() ? "" : ", ") + kind;
  return choice;
}

void read_what(const std::string& kind, EditTable& table, MapEdit& edit) {
  if (kind == "delete_closure") edit.what = read_delete(table);
  if (kind == "add_closure") edit.what = read_add(table);
  if (kind == "ignore")
    edit.what =
        IgnoreStretch{.from = require_place(table, "from_"), .to = require_place(table, "to_")};
  if (kind == "crop") edit.what = CropMap{read_polygon(table)};
  if (kind == "erase") edit.what = EraseInside{read_polygon(table)};
  if (kind == "straighten") edit.what = StraightenMap{};
  if (kind == "origin") edit.what = read_origin(table);
  if (kind == "keep_out")
    edit.what = KeepOut{.name = table.text("name").value_or(""), .polygon = read_polygon(table)};
  if (kind == "speed") edit.what = read_speed(table);
  if (kind == "as_edited") edit.what = MapAsEdited{};
  const bool lies_on_map = kind == "crop" || kind == "erase" || kind == "origin" ||
                           kind == "keep_out" || kind == "speed";
  if (lies_on_map) edit.anchor = read_anchor(table);
}

MapEdit read_edit(EditTable& table) {
  MapEdit edit{.line = table.line()};
  const auto kind = table.text("kind");
  if (!table.has("kind")) {
    table.complain({}, "must have a kind: " + choice_of_kinds());
  } else if (kind && std::ranges::find(kinds(), *kind) == kinds().end()) {
    const std::string nearest = nearest_key(*kind, kinds());
    table.complain("kind", nearest.empty() ? "must be one of " + choice_of_kinds()
                                           : "must be " + nearest + "? All: " + choice_of_kinds());
  } else if (kind) {
    read_what(*kind, table, edit);
    table.finish();
  }
  return edit;
}

/// "edit[3].kind": 3 and "kind"; nothing of other keys.
std::optional<std::pair<std::size_t, std::string>> key_of_edit(const std::string& key,
                                                               std::size_t edits) {
  constexpr std::string_view kBegin = "edit[";
  const std::size_t close = key.find("].");
  if (!key.starts_with(kBegin) || close == std::string::npos) return {};
  std::size_t number = 0;
  for (std::size_t i = kBegin.size(); i < close; ++i) {
    if (key[i] < '0' || key[i] > '9') return {};
    number = std::min<std::size_t>(number * 10 + static_cast<std::size_t>(key[i] - '0'), edits);
  }
  if (number >= edits) return {};
  return std::pair{number, key.substr(close + 2)};
}

/// Polygons and numbers as TOML.
class EditWriter {
 public:
  explicit EditWriter(const MapEdit& edit) {
    text_ = fmt::format("[[edit]]\nkind = \"{}\"\n", kind_of(edit));
    std::visit([this](const auto& what) { write(what); }, edit.what);
    write("anchor_", edit.anchor);
  }
  [[nodiscard]] std::string take() { return std::move(text_); }

 private:
  void line(std::string_view key, const std::string& value) {
    text_ += fmt::format("{} = {}\n", key, value);
  }
  void number(std::string_view key, const std::optional<double>& value) {
    if (value) line(key, toml_number(*value));
  }
  void index(std::string_view key, const std::optional<std::int64_t>& value) {
    if (value) line(key, fmt::format("{}", *value));
  }
  void write(const std::string& prefix, const PathPlace& place) {
    if (place.stamp)
      line(prefix + "t_s", fmt::format("\"{}\"", format_decimal_stamp(*place.stamp)));
    number(prefix + "s", place.drive_s);
    index(prefix + "node", place.node);
  }
  void write(const Polygon2& polygon) {
    std::string corners;
    for (const Eigen::Vector2d& corner : polygon.corners) {
      corners += fmt::format("{}[{}, {}]", corners.empty() ? "" : ", ", toml_number(corner.x()),
                             toml_number(corner.y()));
    }
    line("polygon", "[" + corners + "]");
  }
  void write_name(const std::string& name) {
    if (!name.empty()) line("name", toml_string(name));
  }
  void write(const DeleteClosure& edit) {
    index("from_submap", edit.from_submap);
    index("to_submap", edit.to_submap);
    write("from_", edit.from);
    write("to_", edit.to);
  }
  void write(const AddClosure& edit) {
    write("from_", edit.from);
    write("to_", edit.to);
    if (edit.guess_from_T_to) {
      number("x_m", edit.guess_from_T_to->x);
      number("y_m", edit.guess_from_T_to->y);
      number("yaw_rad", edit.guess_from_T_to->yaw);
    }
    number("half_window_m", edit.half_window_m);
    number("half_window_rad", edit.half_window_rad);
    if (edit.force) line("force", "true");
  }
  void write(const IgnoreStretch& edit) {
    write("from_", edit.from);
    write("to_", edit.to);
  }
  void write(const CropMap& edit) { write(edit.polygon); }
  void write(const EraseInside& edit) { write(edit.polygon); }
  void write(const StraightenMap& /*edit*/) {}
  void write(const SetOrigin& edit) {
    number("x_m", edit.point.x());
    number("y_m", edit.point.y());
    number("yaw_rad", edit.yaw_rad);
  }
  void write(const KeepOut& edit) {
    write_name(edit.name);
    write(edit.polygon);
  }
  void write(const LimitSpeed& edit) {
    write_name(edit.name);
    write(edit.polygon);
    number(edit.unit == SpeedUnit::kPercent ? "percent" : "limit_m_s", edit.limit);
  }
  void write(const MapAsEdited& /*edit*/) {}

  std::string text_{};
};

}  // namespace

std::vector<MapEdit> parse_edits(std::string_view toml, const std::string& path) {
  const TomlDocument document = parse_toml(toml, path);
  std::vector<OptionProblem> problems = document.problems;
  const auto counted = document.table_arrays.find("edit");
  const std::size_t count = counted == document.table_arrays.end() ? 0 : counted->second;
  std::vector<EditTable> tables;
  tables.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    const std::string numbered = fmt::format("edit[{}]", i);
    tables.emplace_back(numbered, document.table_lines.at(numbered), path, problems);
  }
  for (const TomlValue& value : document.values) {
    const auto of_edit = key_of_edit(value.key, count);
    if (of_edit) {
      tables[of_edit->first].add(of_edit->second, value);
    } else {
      problems.push_back({value.key,
                          value.text,
                          "is not of an edit; each begins with a line [[edit]]",
                          {path, value.line, {}}});
    }
  }
  std::vector<MapEdit> edits;
  for (EditTable& table : tables) edits.push_back(read_edit(table));
  std::ranges::stable_sort(
      problems, {}, [](const OptionProblem& problem) { return problem.where.line.value_or(0); });
  if (!problems.empty()) throw OptionsError(std::move(problems));
  return edits;
}

EditsFile read_edits_file(const std::string& path) {
  EditsFile file{.text = read_whole_file(path, kMostOptionBytes)};
  file.edits = parse_edits(file.text, path);
  return file;
}

EditsFile joined(EditsFile before, const EditsFile& more) {
  const MapEdit between{.what = MapAsEdited{}};
  if (!before.text.empty() && before.text.back() != '\n') before.text += '\n';
  before.text += "\n" + edits_to_toml({&between, 1}) + "\n" + more.text;
  before.edits.push_back(between);
  before.edits.insert(before.edits.end(), more.edits.begin(), more.edits.end());
  return before;
}

std::string edits_to_toml(std::span<const MapEdit> edits) {
  std::string text;
  for (const MapEdit& edit : edits) {
    if (!text.empty()) text += "\n";
    text += EditWriter(edit).take();
  }
  return text;
}

}  // namespace loopstone
