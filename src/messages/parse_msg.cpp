#include <algorithm>
#include <charconv>

#include "messages/layout.hpp"

namespace loopstone {
namespace {

constexpr std::size_t kMostName = 128;

[[noreturn]] void fail(std::string_view what, std::string_view line) {
  throw MessageError(0, "the definition's line '" + shown(line) + "' " + std::string(what));
}

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view kBlanks = " \t\r";
  const std::size_t first = text.find_first_not_of(kBlanks);
  if (first == text.npos) return {};
  return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

bool is_word(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
}

/// Takes "[]", "[<=5]", "[3]" off the end of a type.
std::string_view take_shape(std::string_view type, ParsedField& field, std::string_view line) {
  if (!type.ends_with(']')) return type;
  const std::size_t open = type.find('[');
  if (open == type.npos) fail("has a ']' without '['", line);
  const std::string_view size = type.substr(open + 1, type.size() - open - 2);
  field.shape = size.empty() || size.starts_with("<=") ? Shape::kSequence : Shape::kArray;
  if (field.shape == Shape::kArray) {
    std::uint32_t count = 0;
    const auto [end, error] = std::from_chars(size.data(), size.data() + size.size(), count);
    if (error != std::errc{} || end != size.data() + size.size()) {
      fail("has a size that is no whole number of 32 bits", line);
    }
    field.count = count;
  }
  return type.substr(0, open);
}

/// "float32[<=5] ranges [1.0]  # m" and whatever else stands on a line; false when it is no field.
bool parse_field(std::string_view line, ParsedField& field) {
  const std::size_t blank = line.find_first_of(" \t");
  std::string_view type = line.substr(0, blank);
  const std::string_view rest = blank == line.npos ? "" : trimmed(line.substr(blank));
  const auto name_end = std::ranges::find_if_not(rest, is_word);
  const std::string_view name = rest.substr(0, static_cast<std::size_t>(name_end - rest.begin()));
  if (name.empty()) fail("has no name of a field", line);
  if (name.size() > kMostName || type.size() > 2 * kMostName) fail("is too long", line);
  if (trimmed(rest.substr(name.size())).starts_with('=')) return false;  // a constant
  field.name = name;
  type = take_shape(type, field, line);
  type = type.substr(0, type.find("<="));  // bounds of strings do not change the bytes
  if (!std::ranges::all_of(type, [](char c) { return is_word(c) || c == '/'; }) || type.empty()) {
    fail("has no type of a field", line);
  }
  field.type = canonical_type(type);
  return true;
}

}  // namespace

std::vector<ParsedStruct> parse_msg(std::string_view text, DefinitionLanguage language) {
  constexpr std::string_view kHead = "MSG: ";
  std::vector<ParsedStruct> types(1);
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view line = trimmed(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    if (line.empty() || line[0] == '#' || line[0] == '@' || line.starts_with("====")) continue;
    if (line.starts_with(kHead)) {
      const std::string name = canonical_type(trimmed(line.substr(kHead.size())));
      // Some name the message itself, too.
      if (types.size() == 1 && types[0].fields.empty() && types[0].name.empty()) {
        types[0].name = name;
      } else {
        types.push_back({.name = name});
      }
      continue;
    }
    ParsedField field;
    if (!parse_field(line, field)) continue;
    // ROS 2 has no such short name.
    if (field.type == "Header" && language == DefinitionLanguage::kRos1Msg) {
      field.type = "std_msgs/Header";
    }
    types.back().fields.push_back(std::move(field));
  }
  return types;
}

}  // namespace loopstone
