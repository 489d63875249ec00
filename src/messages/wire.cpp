#include "messages/wire.hpp"

#include <fmt/format.h>

#include <limits>

namespace loopstone {
namespace {

constexpr std::int64_t kSecond = 1'000'000'000;
constexpr std::size_t kEncapsulation = 4;

/// Appends a character of Unicode as UTF-8 (RFC 3629).
void append_utf8(std::string& text, std::uint32_t c) {
  if (c < 0x80) {
    text += static_cast<char>(c);
    return;
  }
  const int more = c < 0x800 ? 1 : c < 0x10000 ? 2 : 3;
  constexpr std::array<unsigned, 4> kFirst{0, 0xc0, 0xe0, 0xf0};
  text += static_cast<char>(kFirst[static_cast<std::size_t>(more)] | c >> (6 * more));
  for (int i = more - 1; i >= 0; --i) text += static_cast<char>(0x80 | (c >> (6 * i) & 0x3f));
}

/// Why bytes with this encapsulation can't be read; empty when they can.
std::string why_not(unsigned representation) {
  if (representation <= 1) return {};
  if (representation <= 3) return "are a parameter list (PL_CDR), which is not read";
  if (representation >= 6 && representation <= 0xb) {
    return fmt::format(
        "are of version 2 of CDR (XCDR2, encapsulation {:#06x}); only version 1 is read",
        representation);
  }
  return fmt::format("begin with {:#06x}, which is no encapsulation of CDR", representation);
}

}  // namespace

WireReader::WireReader(WireFormat format, std::span<const char> bytes)
    : format_(format),
      begin_(bytes.data()),
      at_(begin_),
      end_(begin_ + bytes.size()),
      origin_(begin_) {
  bool little = true;
  if (format == WireFormat::kCdr) {
    if (bytes.size() < kEncapsulation) fail_short(kEncapsulation);
    const unsigned representation =
        static_cast<unsigned char>(bytes[0]) * 256U + static_cast<unsigned char>(bytes[1]);
    const std::string reason = why_not(representation);
    if (!reason.empty()) throw MessageError(0, "the message's bytes " + reason);
    little = representation == 1;
    at_ += kEncapsulation;
    origin_ = at_;
  }
  swapped_ = little != (std::endian::native == std::endian::little);
}

std::size_t WireReader::count(std::size_t least_bytes) {
  const auto elements = number<std::uint32_t>();
  if (least_bytes > 0 && elements > remaining() / least_bytes) {
    throw MessageError(offset(),
                       fmt::format("the message tells of {} elements, but only {} bytes follow",
                                   elements, remaining()));
  }
  return elements;
}

std::string_view WireReader::text() {
  const std::size_t size = count(1);
  std::string_view value(at_, size);
  at_ += size;
  if (format_ == WireFormat::kCdr && value.ends_with('\0')) value.remove_suffix(1);
  return value;
}

std::string WireReader::wide_text() {
  std::string value;
  const std::size_t size = count(sizeof(char16_t));
  for (std::size_t i = 0; i < size; ++i) {
    std::uint32_t c = number<std::uint16_t>();
    if (c >= 0xd800 && c < 0xdc00 && i + 1 < size) {
      ++i;
      c = 0x10000 + ((c & 0x3ff) << 10 | (number<std::uint16_t>() & 0x3ff));
    }
    append_utf8(value, c);
  }
  return value;
}

std::int64_t WireReader::nanoseconds(bool is_duration) {
  const bool ros1 = format_ == WireFormat::kRos1;
  const auto seconds = number<std::uint32_t>();
  const auto rest = number<std::uint32_t>();
  const auto as_signed = [](std::uint32_t value) {
    return std::int64_t{static_cast<std::int32_t>(value)};
  };
  // ROS 1: a time has two unsigned numbers, a duration two signed ones. ROS 2: one of each.
  return (ros1 && !is_duration ? std::int64_t{seconds} : as_signed(seconds)) * kSecond +
         (ros1 && is_duration ? as_signed(rest) : std::int64_t{rest});
}

void WireReader::skip(std::size_t count, std::size_t size) {
  if (count == 0) return;
  require(count, size);
  at_ += count * size;
}

void WireReader::expect_end() const {
  // DDS fills up to 4 bytes; some writers up to 8.
  const std::size_t most = format_ == WireFormat::kCdr ? 7 : 0;
  if (remaining() > most) {
    throw MessageError(offset(),
                       fmt::format("the message has {} bytes behind its end", remaining()));
  }
}

void WireReader::fail_short(std::size_t size) const {
  throw MessageError(
      offset(), fmt::format("the message ends after {} bytes, where values of {} were expected",
                            end_ - begin_, size));
}

WireWriter::WireWriter(WireFormat format, std::string& bytes, std::endian order)
    : format_(format), swapped_(order != std::endian::native), bytes_(bytes) {
  bytes_.clear();
  if (format != WireFormat::kCdr) return;
  bytes_.assign(kEncapsulation, '\0');
  bytes_[1] = order == std::endian::little ? '\1' : '\0';
}

void WireWriter::count(std::size_t elements) {
  if (elements > std::numeric_limits<std::uint32_t>::max()) {
    throw MessageError(bytes_.size(), "more elements than 32 bits count");
  }
  number(static_cast<std::uint32_t>(elements));
}

void WireWriter::text(std::string_view value) {
  const bool cdr = format_ == WireFormat::kCdr;
  count(value.size() + (cdr ? 1 : 0));
  bytes_.append(value);
  if (cdr) bytes_ += '\0';
}

void WireWriter::nanoseconds(std::int64_t value, bool is_duration) {
  std::int64_t seconds = value / kSecond;
  if (value % kSecond < 0) --seconds;
  const bool is_signed = format_ == WireFormat::kCdr || is_duration;
  const std::int64_t least = is_signed ? std::numeric_limits<std::int32_t>::min() : 0;
  const std::int64_t most = is_signed ? std::int64_t{std::numeric_limits<std::int32_t>::max()}
                                      : std::int64_t{std::numeric_limits<std::uint32_t>::max()};
  if (seconds < least || seconds > most) {
    throw MessageError(bytes_.size(),
                       fmt::format("a time of {} s does not fit into a message", seconds));
  }
  number(static_cast<std::uint32_t>(seconds));
  number(static_cast<std::uint32_t>(value - seconds * kSecond));
}

}  // namespace loopstone
