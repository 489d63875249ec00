#include "loopstone/formats/log_format.hpp"

#include <algorithm>
#include <array>
#include <variant>

#include "loopstone/formats/log_format_words.hpp"

namespace loopstone {
namespace {

// In the order of SensorMessage.
constexpr std::array<MessageKind, std::variant_size_v<SensorMessage>> kKinds{{
    {"scans", &LogContents::scans},
    {"odometry poses", &LogContents::odometry_poses},
    {"wheel readings", &LogContents::wheel_ticks},
    {"inertial readings", &LogContents::imu_samples},
    {"camera frames", &LogContents::rgbd_frames},
}};
static_assert(kKinds.back().held != nullptr, "every kind of message needs its line");

}  // namespace

std::span<const MessageKind> message_kinds() { return kKinds; }

bool holds(const LogContents& contents, const SensorMessage& message) {
  return contents.*kKinds[message.index()].held;
}

const LogFormat* find_log_format(std::string_view name) {
  for (const LogFormat& format : log_formats()) {
    if (format.name == name) return &format;
  }
  return nullptr;
}

const LogFormat& log_format(std::string_view name) {
  if (const LogFormat* const format = find_log_format(name)) return *format;
  std::vector<std::string> names;
  for (const LogFormat& format : log_formats()) names.emplace_back(format.name);
  throw UsageError("there is no log format '" + std::string(name) + "'; there are " +
                   listed(names, "and"));
}

bool has_log_ending(const LogFormat& format, std::string_view file_name) {
  for (const std::string_view packing : format.packings) {
    if (file_name.ends_with(packing)) file_name.remove_suffix(packing.size());
  }
  return std::any_of(format.endings.begin(), format.endings.end(),
                     [&](std::string_view ending) { return file_name.ends_with(ending); });
}

bool has_log_ending(std::string_view file_name) {
  const auto formats = log_formats();
  return std::any_of(formats.begin(), formats.end(),
                     [&](const LogFormat& format) { return has_log_ending(format, file_name); });
}

}  // namespace loopstone
