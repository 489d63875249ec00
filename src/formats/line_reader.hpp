#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "formats/byte_source.hpp"

namespace loopstone {

/// Lines of a text, read in large blocks. Ends in "\n" or "\r\n"; the last line needs no end.
class LineReader {
 public:
  /// Longer lines are cut: their beginning comes out with `too_long` set and the rest is passed
  /// over.
  static constexpr std::size_t kLongestLineBytes = std::size_t{1} << 21;

  struct Line {
    std::string_view text;    ///< without its end; valid until the next call
    std::int64_t number = 0;  ///< 1-based
    bool too_long = false;
  };

  explicit LineReader(std::unique_ptr<ByteSource> source);

  [[nodiscard]] std::optional<Line> next();
  [[nodiscard]] const ByteSource& source() const { return *source_; }
  [[nodiscard]] std::int64_t lines_read() const { return number_; }

 private:
  bool refill();

  std::unique_ptr<ByteSource> source_;
  std::vector<char> buffer_;
  std::size_t begin_ = 0;
  std::size_t end_ = 0;
  std::int64_t number_ = 0;
  bool at_end_ = false;
};

}  // namespace loopstone
