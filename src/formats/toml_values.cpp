#include "formats/toml_values.hpp"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <sstream>
#include <string_view>

#include "formats/cloud_parts.hpp"

namespace loopstone {

namespace {

std::string joined(const std::string& prefix, std::string_view key) {
  return prefix.empty() ? std::string(key) : prefix + "." + std::string(key);
}

template <typename Node>
std::string text_of(const Node& node) {
  std::ostringstream out;
  out << node;
  return out.str();
}

bool all_tables(const toml::array& array) {
  return !array.empty() &&
         std::all_of(array.begin(), array.end(), [](const auto& node) { return node.is_table(); });
}

/// Nothing when something in it is no number.
std::optional<std::vector<double>> numbers_of(const toml::array& array) {
  std::vector<double> numbers;
  for (const toml::node& node : array) {
    if (!node.is_number()) return {};
    numbers.push_back(node.is_integer() ? static_cast<double>(node.as_integer()->get())
                                        : node.as_floating_point()->get());
  }
  return numbers;
}

std::optional<std::vector<std::vector<double>>> rows_of(const toml::array& array) {
  std::vector<std::vector<double>> rows;
  if (auto one = numbers_of(array)) {
    rows.push_back(std::move(*one));
    return rows;
  }
  for (const toml::node& node : array) {
    if (!node.is_array()) return {};
    auto row = numbers_of(*node.as_array());
    if (!row) return {};
    rows.push_back(std::move(*row));
  }
  return rows;
}

void flatten(const toml::node& node, const std::string& key, TomlDocument& out) {
  if (const auto* table = node.as_table()) {
    for (const auto& [name, child] : *table) flatten(child, joined(key, name.str()), out);
    return;
  }
  if (const auto* array = node.as_array(); array != nullptr && all_tables(*array)) {
    out.table_arrays[key] = array->size();
    for (std::size_t i = 0; i < array->size(); ++i) {
      const std::string numbered = fmt::format("{}[{}]", key, i);
      out.table_lines[numbered] = static_cast<std::int64_t>((*array)[i].source().begin.line);
      flatten((*array)[i], numbered, out);
    }
    return;
  }
  TomlValue leaf{key, static_cast<std::int64_t>(node.source().begin.line), {}, {}};
  if (const auto* boolean = node.as_boolean()) {
    leaf.value = boolean->get();
    leaf.text = boolean->get() ? "true" : "false";
  } else if (const auto* integer = node.as_integer()) {
    leaf.value = integer->get();
    leaf.text = fmt::format("{}", integer->get());
  } else if (const auto* real = node.as_floating_point()) {
    leaf.value = real->get();
    leaf.text = toml_number(real->get());
  } else if (const auto* text = node.as_string()) {
    leaf.value = text->get();
    leaf.text = toml_string(text->get());
  } else {
    if (const auto* array = node.as_array()) leaf.rows = rows_of(*array);
    node.visit([&leaf](const auto& other) { leaf.text = text_of(other); });
  }
  out.values.push_back(std::move(leaf));
}

const OptionEntry* find(const std::vector<OptionEntry>& options, std::string_view key) {
  const auto found = std::find_if(options.begin(), options.end(),
                                  [&](const OptionEntry& entry) { return entry.key == key; });
  return found == options.end() ? nullptr : &*found;
}

std::string unknown_key_rule(const std::vector<OptionEntry>& options, std::string_view key) {
  const std::string as_group = std::string(key) + ".";
  std::vector<std::string> known;
  for (const OptionEntry& entry : options) {
    known.push_back(entry.key);
    if (entry.key.starts_with(as_group)) {
      return fmt::format("is a group of options, such as {}; it has no value of its own",
                         entry.key);
    }
  }
  const std::string nearest = nearest_key(key, known);
  return nearest.empty() ? "unknown key; `loopstone config` lists all keys"
                         : fmt::format("unknown key; did you mean {}?", nearest);
}

bool within(const OptionEntry& entry, double value) {
  // Written so that NaN is outside.
  return !entry.range || (value >= entry.range->lowest && value <= entry.range->highest);
}

/// Puts the value where the entry points; false when type or rule does not fit.
bool assign(const OptionEntry& entry, const TomlValue& value) {
  if (auto* const* target = std::get_if<bool*>(&entry.value)) {
    const auto* given = std::get_if<bool>(&value.value);
    if (given == nullptr) return false;
    **target = *given;
    return true;
  }
  if (auto* const* target = std::get_if<int*>(&entry.value)) {
    const auto* given = std::get_if<std::int64_t>(&value.value);
    if (given == nullptr || !std::in_range<int>(*given)) return false;
    if (!within(entry, static_cast<double>(*given))) return false;
    **target = static_cast<int>(*given);
    return true;
  }
  if (auto* const* target = std::get_if<double*>(&entry.value)) {
    const auto* real = std::get_if<double>(&value.value);
    const auto* whole = std::get_if<std::int64_t>(&value.value);
    if (real == nullptr && whole == nullptr) return false;
    const double given = real != nullptr ? *real : static_cast<double>(*whole);
    if (!within(entry, given)) return false;
    **target = given;
    return true;
  }
  const auto* given = std::get_if<std::string>(&value.value);
  if (given == nullptr) return false;
  if (const auto* choice = std::get_if<WordField>(&entry.value)) return choice->set(*given);
  *std::get<std::string*>(entry.value) = *given;
  return true;
}

/// What is deeper than this is no option, and would overflow the stack of a parser that follows it
/// down.
constexpr int kMostDepth = 32;

/// Where the text ends that begins with the quote at `begin`.
std::size_t end_of_text(std::string_view toml, std::size_t begin) {
  const char quote = toml[begin];
  const std::string three(3, quote);
  const bool is_long = toml.substr(begin, 3) == three;
  for (std::size_t i = begin + (is_long ? 3 : 1); i < toml.size(); ++i) {
    if (toml[i] == '\\' && quote == '"') {
      ++i;
    } else if (toml[i] == '\n' && !is_long) {
      return i;
    } else if (toml[i] == quote && !is_long) {
      return i + 1;
    } else if (toml.substr(i, 3) == three) {
      // A long text may end in up to two quotes of its own.
      for (i += 3; toml.substr(i, 1) == three.substr(0, 1);) ++i;
      return i;
    }
  }
  return toml.size();
}

/// Where there are more brackets open, or more parts in a dotted key, than any options have; npos:
/// nowhere. Knows no more of TOML than texts, comments, brackets and dots.
std::size_t where_too_deep(std::string_view toml) {
  int brackets = 0;
  int dots = 0;
  for (std::size_t i = 0; i < toml.size(); ++i) {
    const char c = toml[i];
    if (c == '"' || c == '\'') {
      i = end_of_text(toml, i) - 1;
    } else if (c == '#') {
      i = std::min(toml.find('\n', i), toml.size()) - 1;
    } else if (c == '.') {
      ++dots;
    } else if (c == '[' || c == '{') {
      ++brackets;
    } else if ((c == ']' || c == '}') && brackets > 0) {
      --brackets;
    }
    if (c == '=' || c == ',' || c == '[' || c == '{' || c == '\n') dots = 0;
    if (brackets > kMostDepth || dots >= kMostDepth) return i;
  }
  return toml.npos;
}

/// Counted from 1.
std::int64_t line_at(std::string_view text, std::size_t place) {
  const std::string_view before = text.substr(0, place);
  return std::count(before.begin(), before.end(), '\n') + 1;
}

/// What the parser found wrong, in our words: its own name neither what stands there nor what
/// belongs there.
std::string syntax_rule(std::string_view toml, const toml::parse_error& error) {
  const bool twice = error.description().find("redefine") != std::string_view::npos;
  std::string_view line = toml;
  for (auto number = error.source().begin.line; number > 1; --number) {
    line.remove_prefix(std::min(line.find('\n'), line.size() - 1) + 1);
  }
  line = line.substr(0, std::min(line.find('\n'), line.size()));
  return fmt::format(
      "not valid TOML{} at column {} of {}; write key = 0.5, key = \"word\" or [group]",
      twice ? ", a key stands there twice," : "",
      static_cast<std::uint64_t>(error.source().begin.column), show_word(line));
}

}  // namespace

TomlDocument parse_toml(std::string_view toml, const std::string& path) {
  TomlDocument document;
  if (toml.size() > kMostOptionBytes) {
    document.problems.push_back({{}, {}, "longer than a megabyte: no options", {path, {}, {}}});
    return document;
  }
  if (const std::size_t place = where_too_deep(toml); place != toml.npos) {
    document.problems.push_back(
        {{},
         {},
         fmt::format("more than {} brackets or parts of a key within each other: no options",
                     kMostDepth),
         {path, line_at(toml, place), {}}});
    return document;
  }
  try {
    const toml::table table = toml::parse(toml, path);
    flatten(table, {}, document);
  } catch (const toml::parse_error& error) {
    document.problems.push_back({{},
                                 {},
                                 syntax_rule(toml, error),
                                 {path, static_cast<std::int64_t>(error.source().begin.line), {}}});
  }
  std::stable_sort(document.values.begin(), document.values.end(),
                   [](const TomlValue& a, const TomlValue& b) { return a.line < b.line; });
  return document;
}

std::vector<OptionProblem> apply_values(const std::vector<OptionEntry>& options,
                                        const std::vector<TomlValue>& values,
                                        const std::string& path) {
  std::vector<OptionProblem> problems;
  for (const TomlValue& value : values) {
    const auto line = value.line > 0 ? std::optional(value.line) : std::nullopt;
    const OptionEntry* entry = find(options, value.key);
    if (entry == nullptr) {
      problems.push_back({value.key, {}, unknown_key_rule(options, value.key), {path, line, {}}});
    } else if (!assign(*entry, value)) {
      problems.push_back({value.key, value.text, "must be " + rule_of(*entry), {path, line, {}}});
    }
  }
  return problems;
}

std::string toml_number(double value) {
  std::string text = fmt::format("{}", value);  // the shortest text that reads back the same
  if (text.find_first_of(".en") == std::string::npos) text += ".0";
  return text;
}

std::string toml_string(std::string_view text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') {
      quoted += '\\';
      quoted += c;
    } else if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) {
      quoted += fmt::format("\\u{:04X}", static_cast<int>(static_cast<unsigned char>(c)));
    } else {
      quoted += c;
    }
  }
  return quoted + "\"";
}

std::string toml_value(const OptionEntry& entry) {
  if (const auto* value = std::get_if<bool*>(&entry.value)) return **value ? "true" : "false";
  if (const auto* value = std::get_if<int*>(&entry.value)) return fmt::format("{}", **value);
  if (const auto* value = std::get_if<double*>(&entry.value)) return toml_number(**value);
  if (const auto* value = std::get_if<WordField>(&entry.value)) return toml_string(**value);
  return toml_string(*std::get<std::string*>(entry.value));
}

}  // namespace loopstone
