#include "devices/rplidar_session.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace loopstone {
namespace {

constexpr int kTries = 4;
/// What the makers' driver sets; a full turn takes about a tenth of a second then.
constexpr int kMotorPwm = 660;
/// Of the series A; their datasheets promise 12 m or more.
constexpr double kUsualRangeMaxM = 12.0;
constexpr double kMicrosecond = 1e-6;

double seconds_since(std::int64_t steady_ns) {
  return static_cast<double>(HostTime::now().steady_ns - steady_ns) * 1e-9;
}

bool is_known(RplidarAnswer answer) {
  return answer == RplidarAnswer::kNodes || answer == RplidarAnswer::kCapsules ||
         answer == RplidarAnswer::kDenseCapsules;
}

}  // namespace

RplidarSession::RplidarSession(const DeviceAddress& address, const ScannerOptions& options)
    : wire_(address, options.stop, options.silence_s), silence_s_(options.silence_s) {
  // Of the A1 the motor turns while DTR is off; Linux switches it on with the port.
  wire_.set_dtr(false);
}

// Half a request may lie in the device's buffer and take a STOP for its end: so there are several.
void RplidarSession::quiet() {
  constexpr double kQuietS = 0.1;
  for (int i = 0; i < kTries; ++i) {
    for (int k = 0; k < 2; ++k) wire_.write(rplidar_request(RplidarCommand::kStop));
    const std::int64_t began_ns = HostTime::now().steady_ns;
    while (seconds_since(began_ns) < silence_s_ / 2) {
      if (wire_.read(kQuietS).empty()) return;
    }
  }
  wire_.fail("goes on sending when it is told to stop; is it an RPLIDAR, and the baud rate right?");
}

std::optional<std::string> RplidarSession::ask(RplidarCommand command, std::string_view payload,
                                               RplidarAnswer type, std::size_t length, int tries,
                                               std::string_view beginning) {
  for (int i = 0; i < tries; ++i) {
    wire_.write(rplidar_request(command, payload));
    std::string heard;
    const std::int64_t began_ns = HostTime::now().steady_ns;
    double left_s = silence_s_ / 4;
    do {
      left_s = silence_s_ / 4 - seconds_since(began_ns);
      heard += wire_.read(left_s);
      if (auto answer = find_answer(heard, type, length, beginning)) return answer;
    } while (left_s > 0.0);
  }
  return {};
}

RplidarInfo RplidarSession::ask_info() {
  constexpr std::size_t kInfoBytes = 20;
  const auto answer = ask(RplidarCommand::kInfo, {}, RplidarAnswer::kInfo, kInfoBytes, kTries);
  if (!answer)
    wire_.fail(
        "does not say what it is; is it an RPLIDAR, powered, and the baud rate right? (A1, "
        "A2M8: 115200; A2M7, A2M12, A3, S1: 256000; C1: 460800; S2, S3: 1000000)");
  return rplidar_info(*answer);
}

void RplidarSession::make_healthy() {
  constexpr std::size_t kHealthBytes = 3;
  constexpr int kFailed = 2;
  constexpr double kRestartS = 2.0;
  for (int i = 0; i < 2; ++i) {
    const auto answer =
        ask(RplidarCommand::kHealth, {}, RplidarAnswer::kHealth, kHealthBytes, kTries);
    if (!answer) wire_.fail("does not say how it is; is the line good?");
    if (answer->front() != kFailed) return;
    if (i == 1)
      wire_.fail(
          fmt::format("protects itself with error 0x{:04X}; is its motor free? Switch it off "
                      "and on",
                      little_endian(std::string_view(*answer).substr(1, 2))));
    wire_.write(rplidar_request(RplidarCommand::kReset));
    // It tells its name when it has begun anew.
    (void)wire_.read(kRestartS);
    quiet();
  }
}

std::optional<std::string> RplidarSession::ask_setting(RplidarSetting setting, int mode) {
  constexpr int kSettingBytes = 4;
  const std::string name = little_endian(static_cast<std::uint64_t>(setting), kSettingBytes);
  std::string payload = name;
  if (mode >= 0) payload += little_endian(static_cast<std::uint64_t>(mode), 2);
  // One that was asked for twice may come twice, the second time before this one.
  const auto answer = ask(RplidarCommand::kConfiguration, payload, RplidarAnswer::kConfiguration,
                          kSettingBytes, 2, name);
  if (!answer) return {};
  return answer->substr(kSettingBytes);
}

std::optional<std::uint64_t> RplidarSession::ask_number(RplidarSetting setting, int mode,
                                                        int bytes) {
  const auto data = ask_setting(setting, mode);
  if (!data || data->size() < static_cast<std::size_t>(bytes)) return {};
  return little_endian(std::string_view(*data).substr(0, static_cast<std::size_t>(bytes)));
}

std::vector<RplidarMode> RplidarSession::ask_configured_modes() {
  constexpr double kOneOf = 256.0;  // fixed point
  constexpr std::uint64_t kMostModes = 16;
  std::vector<RplidarMode> modes;
  const std::uint64_t count = ask_number(RplidarSetting::kModeCount, -1, 2).value_or(0);
  for (int i = 0; i < static_cast<int>(std::min(count, kMostModes)); ++i) {
    const auto answer = ask_number(RplidarSetting::kAnswer, i, 1);
    const auto sample = ask_number(RplidarSetting::kSampleTime, i, 4);
    const auto distance = ask_number(RplidarSetting::kMaxDistance, i, 4);
    const auto name = ask_setting(RplidarSetting::kModeName, i);
    if (!answer || !sample || *sample == 0 || !distance || *distance == 0) continue;
    RplidarMode mode{.name = name.value_or(""),
                     .number = i,
                     .answer = static_cast<RplidarAnswer>(*answer),
                     .sample_s = static_cast<double>(*sample) / kOneOf * kMicrosecond,
                     .range_max_m = static_cast<double>(*distance) / kOneOf};
    mode.name = mode.name.substr(0, mode.name.find('\0'));
    if (is_known(mode.answer)) modes.push_back(std::move(mode));
  }
  return modes;
}

// Modes are told from firmware 1.24 on, sample times and express scans from 1.17 on.
std::vector<RplidarMode> RplidarSession::ask_modes(const RplidarInfo& info) {
  constexpr double kFirstSampleTime = 476.0;  // of older firmware [us]
  if (info.has_firmware(1, 24)) {
    auto modes = ask_configured_modes();
    if (!modes.empty()) return modes;
  }
  std::vector<RplidarMode> modes{
      {"Standard", 0, RplidarAnswer::kNodes, kFirstSampleTime * kMicrosecond, kUsualRangeMaxM}};
  if (!info.has_firmware(1, 17)) return modes;
  constexpr std::size_t kTimesBytes = 4;
  const auto times =
      ask(RplidarCommand::kSampleRate, {}, RplidarAnswer::kSampleRate, kTimesBytes, 2);
  if (!times) return modes;
  const auto time = [&](std::size_t at) {
    return static_cast<double>(little_endian(std::string_view(*times).substr(at, 2))) *
           kMicrosecond;
  };
  if (time(0) > 0.0) modes.front().sample_s = time(0);
  if (time(2) > 0.0)
    modes.push_back({"Express", 0, RplidarAnswer::kCapsules, time(2), kUsualRangeMaxM});
  return modes;
}

// An A2 or A3 sits on a board that sets its motor's speed; those of the A1 and of the others turn
// by DTR or by themselves.
void RplidarSession::start_motor(const RplidarInfo& info) {
  constexpr int kFirstWithBoard = 2;
  constexpr int kFirstWithout = 4;
  constexpr std::size_t kFlagBytes = 4;
  if (info.series() < kFirstWithBoard || info.series() >= kFirstWithout) return;
  const auto flags = ask(RplidarCommand::kAccessoryBoard, little_endian(0, kFlagBytes),
                         RplidarAnswer::kAccessoryBoard, kFlagBytes, 2);
  has_pwm_ = flags && (little_endian(*flags) & 1U) == 1;
  if (has_pwm_)
    wire_.write(rplidar_request(RplidarCommand::kMotorPwm, little_endian(kMotorPwm, 2)));
}

std::string RplidarSession::start(const RplidarMode& mode) {
  constexpr int kExpressBytes = 5;  // the mode, and four that are 0
  for (int i = 0; i < kTries; ++i) {
    wire_.write(mode.answer == RplidarAnswer::kNodes
                    ? rplidar_request(RplidarCommand::kScan)
                    : rplidar_request(
                          RplidarCommand::kExpressScan,
                          little_endian(static_cast<std::uint64_t>(mode.number), kExpressBytes)));
    std::string heard;
    const std::int64_t began_ns = HostTime::now().steady_ns;
    double left_s = silence_s_;
    do {
      left_s = silence_s_ - seconds_since(began_ns);
      heard += wire_.read(left_s);
      if (const auto descriptor = find_descriptor(heard, mode.answer))
        return heard.substr(descriptor->end);
    } while (left_s > 0.0);
    quiet();
  }
  wire_.fail("does not begin to measure in mode " + mode.name + "; try another by ?mode=");
}

void RplidarSession::rest() noexcept {
  try {
    wire_.write(rplidar_request(RplidarCommand::kStop));
    if (has_pwm_) wire_.write(rplidar_request(RplidarCommand::kMotorPwm, little_endian(0, 2)));
    wire_.set_dtr(true);
  } catch (...) {
    // It is gone, or nobody wants to wait for it.
  }
}

}  // namespace loopstone
