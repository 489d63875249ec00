#pragma once

#include <string>
#include <utility>
#include <vector>

#include "loopstone/formats/log_reader.hpp"

namespace loopstone::test {

/// All that a reader gives, sorted into kinds, with what it complained about.
struct LogContent {
  std::vector<SensorMessage> messages{};
  std::vector<LaserScan> scans{};
  std::vector<OdometryPose> odometry{};
  std::vector<WheelTicks> ticks{};
  std::vector<ImuSample> imu{};
  std::vector<RgbdFrame> frames{};
  std::vector<Problem> problems{};
  std::vector<std::string> notes{};
  std::int64_t skipped = 0;
  bool in_time_order = true;

  void add(SensorMessage message) {
    if (!messages.empty() && stamp_of(message) < stamp_of(messages.back())) in_time_order = false;
    if (const auto* scan = std::get_if<LaserScan>(&message)) scans.push_back(*scan);
    if (const auto* pose = std::get_if<OdometryPose>(&message)) odometry.push_back(*pose);
    if (const auto* reading = std::get_if<WheelTicks>(&message)) ticks.push_back(*reading);
    if (const auto* sample = std::get_if<ImuSample>(&message)) imu.push_back(*sample);
    if (const auto* frame = std::get_if<RgbdFrame>(&message)) frames.push_back(*frame);
    messages.push_back(std::move(message));
  }
  [[nodiscard]] bool has_note(const std::string& part) const {
    for (const std::string& note : notes) {
      if (note.find(part) != note.npos) return true;
    }
    return false;
  }
};

/// Opens with open(LogOptions) and reads to the end.
template <typename Open>
[[nodiscard]] LogContent read_all(Open&& open) {
  LogContent content;
  LogOptions options;
  options.on_problem = [&](const Problem& problem) { content.problems.push_back(problem); };
  const auto log = open(options);
  while (auto message = log->next()) content.add(std::move(*message));
  content.notes = log->notes();
  content.skipped = log->records_skipped();
  return content;
}

[[nodiscard]] inline LogContent read_log(const std::string& path) {
  return read_all([&](LogOptions options) {
    options.topics.pictures = true;
    return open_log(path, options);
  });
}

}  // namespace loopstone::test
