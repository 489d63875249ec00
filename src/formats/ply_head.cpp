#include "formats/ply_head.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "formats/cloud_parts.hpp"
#include "formats/text_lines.hpp"
#include "formats/text_numbers.hpp"

namespace loopstone {
namespace {

std::optional<ScalarType> type_of(std::string_view word) {
  static constexpr std::array<std::pair<std::string_view, ScalarType>, 16> kTypes{{
      {"char", {'i', 1}},
      {"int8", {'i', 1}},
      {"uchar", {'u', 1}},
      {"uint8", {'u', 1}},
      {"short", {'i', 2}},
      {"int16", {'i', 2}},
      {"ushort", {'u', 2}},
      {"uint16", {'u', 2}},
      {"int", {'i', 4}},
      {"int32", {'i', 4}},
      {"uint", {'u', 4}},
      {"uint32", {'u', 4}},
      {"float", {'f', 4}},
      {"float32", {'f', 4}},
      {"double", {'f', 8}},
      {"float64", {'f', 8}},
  }};
  const auto found = std::find_if(kTypes.begin(), kTypes.end(),
                                  [word](const auto& entry) { return entry.first == word; });
  return found == kTypes.end() ? std::nullopt : std::optional(found->second);
}

ScalarType require_type(std::string_view word, const HeadLines& lines) {
  const auto type = type_of(word);
  if (!type) lines.fail(show_word(word) + " is no type of a number");
  return *type;
}

PlyData parse_format(const std::vector<std::string_view>& words, const HeadLines& lines) {
  const std::string_view kind = words.size() > 1 ? words[1] : std::string_view{};
  if (kind == "ascii") return PlyData::kAscii;
  if (kind == "binary_little_endian") return PlyData::kLittleEndian;
  if (kind == "binary_big_endian") return PlyData::kBigEndian;
  lines.fail("format " + show_word(kind) +
             " is none of ascii, binary_little_endian, binary_big_endian");
}

PlyElement parse_element(const std::vector<std::string_view>& words, const HeadLines& lines) {
  const auto count = words.size() == 3 ? parse_integer(words[2]) : std::nullopt;
  if (!count || *count < 0 || *count > (std::int64_t{1} << 40)) {
    lines.fail("an element must read `element NAME COUNT` with a possible count");
  }
  return {std::string(words[1]), static_cast<std::size_t>(*count), {}};
}

PlyProperty parse_property(const std::vector<std::string_view>& words, const HeadLines& lines) {
  if (words.size() == 3) return {std::string(words[2]), require_type(words[1], lines), {}};
  if (words.size() == 5 && words[1] == "list") {
    const ScalarType size = require_type(words[2], lines);
    if (size.kind == 'f') lines.fail("the length of a list must be a whole number");
    return {std::string(words[4]), require_type(words[3], lines), size};
  }
  lines.fail("a property must read `property TYPE NAME` or `property list TYPE TYPE NAME`");
}

}  // namespace

bool PlyElement::has_lists() const {
  return std::any_of(properties.begin(), properties.end(),
                     [](const PlyProperty& property) { return property.list_size.has_value(); });
}

std::size_t PlyElement::least_bytes() const {
  std::size_t bytes = 0;
  for (const PlyProperty& property : properties) {
    bytes += static_cast<std::size_t>(property.list_size.value_or(property.type).bytes);
  }
  return bytes;
}

PlyHead parse_ply_head(std::string_view bytes, const std::string& path) {
  HeadLines lines(bytes, path);
  if (lines.next() != "ply") lines.fail("is no PLY file: it doesn't begin with a line 'ply'");
  PlyHead head;
  bool has_format = false;
  while (true) {
    const std::string_view line = lines.next();
    const std::vector<std::string_view> words = split_words(line);
    if (words.empty() || words[0] == "comment" || words[0] == "obj_info") continue;
    if (words[0] == "end_header") break;
    if (words[0] == "format") {
      head.data = parse_format(words, lines);
      has_format = true;
    } else if (words[0] == "element") {
      head.elements.push_back(parse_element(words, lines));
    } else if (words[0] == "property") {
      if (head.elements.empty()) lines.fail("a property stands before the first element");
      head.elements.back().properties.push_back(parse_property(words, lines));
    } else {
      lines.fail(show_word(words[0]) + " is no entry of a PLY head");
    }
  }
  if (!has_format) lines.fail("the line `format` is missing");
  head.data_offset = lines.offset();
  head.head_lines = lines.line();
  return head;
}

}  // namespace loopstone
