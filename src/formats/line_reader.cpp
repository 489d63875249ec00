#include "formats/line_reader.hpp"

#include <algorithm>
#include <cstring>
#include <utility>

namespace loopstone {

LineReader::LineReader(std::unique_ptr<ByteSource> source)
    : source_(std::move(source)), buffer_(std::size_t{1} << 18) {}

/// Moves the unread rest to the front and reads more behind it. False when nothing more came.
bool LineReader::refill() {
  if (at_end_) return false;
  if (begin_ > 0) {
    std::memmove(buffer_.data(), buffer_.data() + begin_, end_ - begin_);
    end_ -= begin_;
    begin_ = 0;
  }
  if (end_ == buffer_.size()) {
    buffer_.resize(std::min(buffer_.size() * 2, 2 * kLongestLineBytes));
  }
  const std::size_t count = source_->read({buffer_.data() + end_, buffer_.size() - end_});
  end_ += count;
  at_end_ = count == 0;
  return count > 0;
}

std::optional<LineReader::Line> LineReader::next() {
  std::size_t searched = 0;  // bytes after begin_ known to hold no line end
  for (;;) {
    const char* const first = buffer_.data() + begin_;
    const void* const found = std::memchr(first + searched, '\n', end_ - begin_ - searched);
    std::size_t length = end_ - begin_;
    if (found != nullptr) {
      length = static_cast<std::size_t>(static_cast<const char*>(found) - first);
    } else if (length <= kLongestLineBytes) {
      searched = length;
      if (refill()) continue;
      if (begin_ == end_) return std::nullopt;
      length = end_ - begin_;
    }
    ++number_;
    Line line{{buffer_.data() + begin_, length}, number_, length > kLongestLineBytes};
    begin_ = std::min(begin_ + length + 1, end_);
    if (line.too_long && found == nullptr) {
      // Pass over the rest of this line; what a caller sees is its length limit, not its text.
      line.text = {};
      begin_ = end_;
      for (bool ended = false; !ended && refill();) {
        const void* const rest = std::memchr(buffer_.data() + begin_, '\n', end_ - begin_);
        ended = rest != nullptr;
        begin_ = ended
                     ? static_cast<std::size_t>(static_cast<const char*>(rest) - buffer_.data()) + 1
                     : end_;
      }
      return line;
    }
    if (line.text.ends_with('\r')) line.text.remove_suffix(1);
    return line;
  }
}

}  // namespace loopstone
