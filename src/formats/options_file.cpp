#include "loopstone/formats/options_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "formats/atomic_file.hpp"
#include "formats/toml_values.hpp"

namespace loopstone {

namespace {

/// Levenshtein 1966: insertions, deletions and substitutions that turn one word into the other.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i + 1;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t substituted = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({substituted, row[j] + 1, diagonal + 1});
    }
  }
  return row.back();
}

std::string_view last_part(std::string_view key) { return key.substr(key.find_last_of('.') + 1); }

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

std::string group_of(const std::string& key) {
  const auto dot = key.find_last_of('.');
  return dot == std::string::npos ? std::string{} : key.substr(0, dot);
}

}  // namespace

std::vector<OptionProblem> apply_toml(const std::vector<OptionEntry>& options,
                                      std::string_view toml, const std::string& path) {
  TomlDocument document = parse_toml(toml, path);
  std::vector<OptionProblem> problems = apply_values(options, document.values, path);
  problems.insert(problems.begin(), document.problems.begin(), document.problems.end());
  return problems;
}

std::vector<OptionProblem> apply_options_file(const std::vector<OptionEntry>& options,
                                              const std::string& path) {
  std::string text;
  try {
    text = read_whole_file(path, kMostOptionBytes);
  } catch (const DataError& error) {
    return {{{}, {}, std::string(error.what()).substr(path.size() + 2), {path, {}, {}}}};
  }
  return apply_toml(options, text, path);
}

std::vector<OptionProblem> apply_assignment(const std::vector<OptionEntry>& options,
                                            std::string_view assignment) {
  const std::string source = "--set";
  const auto equals = assignment.find('=');
  if (equals == std::string_view::npos || equals == 0) {
    return {{std::string(assignment), {}, "must read key=value", {source, {}, {}}}};
  }
  TomlValue value;
  value.key = std::string(trimmed(assignment.substr(0, equals)));
  value.text = std::string(trimmed(assignment.substr(equals + 1)));
  const bool is_text = std::any_of(options.begin(), options.end(), [&](const OptionEntry& entry) {
    return entry.key == value.key && (std::holds_alternative<std::string*>(entry.value) ||
                                      std::holds_alternative<WordField>(entry.value));
  });
  const TomlDocument parsed = parse_toml("value = " + value.text, source);
  if (parsed.problems.empty() && parsed.values.size() == 1 && parsed.values[0].key == "value") {
    value.value = parsed.values[0].value;
  }
  if (is_text && !std::holds_alternative<std::string>(value.value)) value.value = value.text;
  return apply_values(options, {value}, source);
}

std::string options_to_toml(const std::vector<OptionEntry>& options) {
  // In TOML a table lasts until the next header, so options outside of every group come first.
  std::vector<const OptionEntry*> ordered;
  for (const OptionEntry& entry : options) ordered.push_back(&entry);
  std::vector<std::string> groups{""};
  for (const OptionEntry& entry : options) {
    if (std::find(groups.begin(), groups.end(), group_of(entry.key)) == groups.end()) {
      groups.push_back(group_of(entry.key));
    }
  }
  std::string text;
  for (const std::string& group : groups) {
    bool headed = group.empty();
    for (const OptionEntry* entry : ordered) {
      if (group_of(entry->key) != group) continue;
      if (!headed) {
        text += fmt::format("{}[{}]\n", text.empty() ? "" : "\n", group);
        headed = true;
      }
      text += fmt::format("# {} ({})\n{} = {}\n", entry->help, rule_of(*entry),
                          last_part(entry->key), toml_value(*entry));
    }
  }
  return text;
}

std::string nearest_key(std::string_view word, const std::vector<std::string>& known) {
  std::string nearest;
  constexpr std::size_t kLongestWord = 200;
  if (word.size() > kLongestWord) return {};  // no slip of the fingers
  std::size_t best = 1 + std::max<std::size_t>(2, last_part(word).size() / 2);
  for (const std::string& key : known) {
    const std::size_t distance =
        std::min(edit_distance(word, key), edit_distance(last_part(word), last_part(key)) + 1);
    if (distance < best) {
      best = distance;
      nearest = key;
    }
  }
  return nearest;
}

}  // namespace loopstone
