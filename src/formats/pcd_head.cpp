#include "formats/pcd_head.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "formats/cloud_parts.hpp"
#include "formats/text_lines.hpp"
#include "formats/text_numbers.hpp"

namespace loopstone {
namespace {

constexpr std::int64_t kMostPoints = std::int64_t{1} << 40;

class HeadParser {
 public:
  HeadParser(std::string_view bytes, const std::string& path) : lines_(bytes, path) {}

  PcdHead parse() {
    while (true) {
      const std::vector<std::string_view> words = split_words(lines_.next());
      if (words.empty() || words[0].starts_with('#')) continue;
      const std::vector<std::string_view> values(words.begin() + 1, words.end());
      if (words[0] == "DATA") {
        take_data(values);
        break;
      }
      take(words[0], values);
    }
    finish();
    return std::move(head_);
  }

 private:
  using Values = std::vector<std::string_view>;

  std::int64_t whole(std::string_view word, std::int64_t least, std::int64_t most) const {
    const auto value = parse_integer(word);
    if (!value || *value < least || *value > most) {
      lines_.fail(show_word(word) +
                  fmt::format(" must be a whole number from {} to {}", least, most));
    }
    return *value;
  }
  std::int64_t only(const Values& values) const {
    if (values.size() != 1) lines_.fail("one number was expected");
    return whole(values[0], 0, kMostPoints);
  }
  void one_per_field(std::string_view key, const Values& values) const {
    if (head_.fields.empty()) lines_.fail(std::string(key) + " stands before FIELDS");
    if (values.size() != head_.fields.size()) {
      lines_.fail(
          fmt::format("{} has {} values for {} fields", key, values.size(), head_.fields.size()));
    }
  }

  void take(std::string_view key, const Values& values) {
    if (key == "FIELDS" || key == "COLUMNS") {
      if (!head_.fields.empty()) lines_.fail("FIELDS stands there twice");
      for (const std::string_view name : values) head_.fields.push_back({std::string(name)});
      if (head_.fields.empty()) lines_.fail("FIELDS names none");
    } else if (key == "SIZE") {
      one_per_field(key, values);
      for (std::size_t i = 0; i < values.size(); ++i) {
        head_.fields[i].type.bytes = static_cast<int>(whole(values[i], 1, 8));
      }
    } else if (key == "TYPE") {
      one_per_field(key, values);
      for (std::size_t i = 0; i < values.size(); ++i) {
        if (values[i] != "F" && values[i] != "I" && values[i] != "U") {
          lines_.fail("TYPE " + show_word(values[i]) + " is none of F, I, U");
        }
        head_.fields[i].type.kind = values[i] == "F" ? 'f' : values[i] == "I" ? 'i' : 'u';
      }
    } else if (key == "COUNT") {
      one_per_field(key, values);
      for (std::size_t i = 0; i < values.size(); ++i) {
        head_.fields[i].count = static_cast<std::size_t>(whole(values[i], 0, 1'000'000));
      }
    } else if (key == "WIDTH") {
      width_ = only(values);
    } else if (key == "HEIGHT") {
      height_ = only(values);
    } else if (key == "POINTS") {
      points_ = only(values);
    } else if (key != "VERSION" && key != "VIEWPOINT") {
      lines_.fail(show_word(key) + " is no entry of a PCD head");
    }
  }

  void take_data(const Values& values) {
    const std::string_view kind = values.empty() ? std::string_view{} : values[0];
    if (kind == "ascii") {
      head_.data = PcdData::kAscii;
    } else if (kind == "binary") {
      head_.data = PcdData::kBinary;
    } else if (kind == "binary_compressed") {
      head_.data = PcdData::kBinaryCompressed;
    } else {
      lines_.fail("DATA " + show_word(kind) + " is none of ascii, binary, binary_compressed");
    }
  }

  void finish() {
    if (head_.fields.empty()) lines_.fail("FIELDS is missing");
    for (PcdField& field : head_.fields) {
      if (!field.type.valid()) {
        lines_.fail(fmt::format("field {} is of a type and size that do not go together",
                                show_word(field.name)));
      }
      field.byte_offset = head_.point_bytes;
      field.word_offset = head_.point_words;
      head_.point_bytes += field.size();
      head_.point_words += field.count;
    }
    if (!points_ && !width_) lines_.fail("WIDTH and POINTS are missing");
    const std::int64_t width = width_.value_or(points_.value_or(0));
    const std::int64_t height = height_.value_or(1);
    if (width != 0 && height > kMostPoints / width) lines_.fail("WIDTH times HEIGHT is impossible");
    if (points_ && *points_ != width * height) {
      lines_.fail(
          fmt::format("POINTS is {}, but WIDTH times HEIGHT is {}", *points_, width * height));
    }
    head_.points = static_cast<std::size_t>(width * height);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::string name(1, static_cast<char>('x' + axis));
      const auto field =
          std::find_if(head_.fields.begin(), head_.fields.end(),
                       [&](const PcdField& f) { return f.name == name && f.count > 0; });
      if (field != head_.fields.end()) head_.xyz[axis] = *field;
    }
    if (!head_.xyz[0] || !head_.xyz[1]) lines_.fail("the FIELDS x and y are missing");
    head_.data_offset = lines_.offset();
    head_.head_lines = lines_.line();
  }

  HeadLines lines_;
  PcdHead head_;
  std::optional<std::int64_t> width_;
  std::optional<std::int64_t> height_;
  std::optional<std::int64_t> points_;
};

}  // namespace

PcdHead parse_pcd_head(std::string_view bytes, const std::string& path) {
  return HeadParser(bytes, path).parse();
}

}  // namespace loopstone
