#include "devices/rplidar_bytes.hpp"

#include <fmt/format.h>

namespace loopstone {
namespace {

constexpr char kRequest = '\xA5';
constexpr std::string_view kDescriptor = "\xA5\x5A";
constexpr std::size_t kDescriptorLength = 7;

}  // namespace

std::string rplidar_request(RplidarCommand command, std::string_view payload) {
  std::string request{kRequest, static_cast<char>(command)};
  if (payload.empty()) return request;
  request += static_cast<char>(payload.size());
  request += payload;
  unsigned checksum = 0;
  for (const char c : request) checksum ^= static_cast<unsigned char>(c);
  request += static_cast<char>(checksum);
  return request;
}

std::optional<RplidarDescriptor> find_descriptor(std::string_view bytes, RplidarAnswer type) {
  constexpr std::uint64_t kLengthMask = 0x3FFFFFFF;
  constexpr unsigned kModeShift = 30;
  for (std::size_t at = bytes.find(kDescriptor); at != std::string_view::npos;
       at = bytes.find(kDescriptor, at + 1)) {
    if (bytes.size() - at < kDescriptorLength) return {};
    const std::uint64_t word = little_endian(bytes.substr(at + 2, 4));
    const auto found = static_cast<RplidarAnswer>(static_cast<unsigned char>(bytes[at + 6]));
    if (found == type)
      return RplidarDescriptor{static_cast<std::size_t>(word & kLengthMask),
                               word >> kModeShift == 1, found, at + kDescriptorLength};
  }
  return {};
}

std::optional<std::string> find_answer(std::string_view bytes, RplidarAnswer type,
                                       std::size_t length_min, std::string_view beginning) {
  constexpr std::size_t kLongest = 256;
  while (const auto descriptor = find_descriptor(bytes, type)) {
    bytes.remove_prefix(descriptor->end);
    const bool fits = !descriptor->is_stream && descriptor->length >= length_min &&
                      descriptor->length <= kLongest;
    if (fits && bytes.size() >= descriptor->length && bytes.starts_with(beginning))
      return std::string(bytes.substr(0, descriptor->length));
  }
  return {};
}

std::string little_endian(std::uint64_t number, int bytes) {
  std::string text;
  for (int i = 0; i < bytes; ++i) text += static_cast<char>(number >> (8 * i) & 0xFFU);
  return text;
}

std::uint64_t little_endian(std::string_view bytes) {
  std::uint64_t number = 0;
  for (std::size_t i = bytes.size(); i-- > 0;)
    number = number << 8U | static_cast<unsigned char>(bytes[i]);
  return number;
}

// The upper half of a model's number is its series, the lower one its model: 0x18 is an A1M8. From
// 4 on they are of the C series, from 6 on of the S series.
std::string RplidarInfo::name() const {
  constexpr int kFirstC = 4;
  constexpr int kFirstS = 6;
  constexpr int kAfterS = 9;
  const int minor = model & 0xF;
  if (series() < kFirstC) return fmt::format("A{}M{}", series(), minor);
  if (series() < kFirstS) return fmt::format("C{}M{}", series() - kFirstC + 1, minor);
  if (series() < kAfterS) return fmt::format("S{}M{}", series() - kFirstS + 1, minor);
  return fmt::format("model {}", model);
}

RplidarInfo rplidar_info(std::string_view answer) {
  constexpr std::size_t kSerialAt = 4;
  const auto byte = [&](std::size_t i) {
    return static_cast<int>(little_endian(answer.substr(i, 1)));
  };
  RplidarInfo info{
      .model = byte(0), .firmware_major = byte(2), .firmware_minor = byte(1), .hardware = byte(3)};
  for (const char c : answer.substr(kSerialAt))
    info.serial += fmt::format("{:02X}", static_cast<unsigned char>(c));
  return info;
}

}  // namespace loopstone
