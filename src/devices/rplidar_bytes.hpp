#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace loopstone {

// Requests to an RPLIDAR and what it replies. Numbers are little-endian.
// Source: Slamtec, "RPLIDAR interface protocol and application notes"; of modes, motors and dense
// capsules their SDK (rplidar_sdk).

enum class RplidarCommand : std::uint8_t {
  kScan = 0x20,
  kStop = 0x25,
  kReset = 0x40,
  kInfo = 0x50,
  kHealth = 0x52,
  kSampleRate = 0x59,
  kExpressScan = 0x82,
  kConfiguration = 0x84,
  kMotorPwm = 0xF0,
  kAccessoryBoard = 0xFF,
};

/// What follows a descriptor.
enum class RplidarAnswer : std::uint8_t {
  kInfo = 0x04,
  kHealth = 0x06,
  kSampleRate = 0x15,
  kConfiguration = 0x20,
  kNodes = 0x81,          ///< of 5 bytes, a measurement each
  kCapsules = 0x82,       ///< of 84 bytes, 32 measurements each
  kDenseCapsules = 0x85,  ///< of 84 bytes, 40 measurements each
  kAccessoryBoard = 0xFF,
};

/// What is asked for by kConfiguration.
enum class RplidarSetting : std::uint32_t {
  kModeCount = 0x70,
  kSampleTime = 0x71,   ///< of a mode [us / 256]
  kMaxDistance = 0x74,  ///< of a mode [m / 256]
  kAnswer = 0x75,       ///< of a mode
  kModeName = 0x7F,
};

/// The bytes of a request; with a payload it ends with a checksum.
[[nodiscard]] std::string rplidar_request(RplidarCommand command, std::string_view payload = {});

/// A descriptor and where it ends: A5 5A, 30 bits of length, 2 of mode, the type.
struct RplidarDescriptor {
  std::size_t length = 0;
  bool is_stream = false;
  RplidarAnswer type{};
  std::size_t end = 0;  ///< offset of what follows
};
/// The first descriptor of that type, whatever stands before.
[[nodiscard]] std::optional<RplidarDescriptor> find_descriptor(std::string_view bytes,
                                                               RplidarAnswer type);
/// The bytes that follow it; nothing while they are not all there, or fewer than asked for.
/// \param beginning  of the bytes; others are passed over
[[nodiscard]] std::optional<std::string> find_answer(std::string_view bytes, RplidarAnswer type,
                                                     std::size_t length_min,
                                                     std::string_view beginning = {});

/// As many bytes as the number has, the lowest first.
[[nodiscard]] std::string little_endian(std::uint64_t number, int bytes);
[[nodiscard]] std::uint64_t little_endian(std::string_view bytes);

/// What GET_INFO tells.
struct RplidarInfo {
  int model = 0;
  int firmware_major = 0;
  int firmware_minor = 0;
  int hardware = 0;
  std::string serial{};

  /// The series A (by triangulation) has no others.
  [[nodiscard]] int series() const { return model >> 4; }
  /// "A1M8", "S1M1".
  [[nodiscard]] std::string name() const;
  [[nodiscard]] bool has_firmware(int major, int minor) const {
    return firmware_major > major || (firmware_major == major && firmware_minor >= minor);
  }
};
/// \param answer  20 bytes
[[nodiscard]] RplidarInfo rplidar_info(std::string_view answer);

}  // namespace loopstone
