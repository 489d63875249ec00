#include "support/emulated_rplidar.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

namespace loopstone::test {
namespace {

constexpr double kRadians = 3.14159265358979323846 / 180.0;

std::int64_t steady_ns() {
  return std::chrono::nanoseconds(std::chrono::steady_clock::now().time_since_epoch()).count();
}
std::int64_t system_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

char byte(std::int64_t number) {
  return static_cast<char>(static_cast<unsigned char>(number & 255));
}
std::string two(std::int64_t number) { return {byte(number), byte(number >> 8)}; }
std::string four(std::int64_t number) { return two(number) + two(number >> 16); }
std::int64_t number_at(const std::string& bytes, std::size_t at) {
  return static_cast<unsigned char>(bytes[at]) + 256 * static_cast<unsigned char>(bytes[at + 1]);
}

/// How much less than even the angle of a sample of an express capsule is [deg / 8]. Of real ones
/// it depends on the range.
int lag_of(std::int64_t sample) { return 30 + static_cast<int>(sample / 25 % 10); }

}  // namespace

EmulatedRplidar::EmulatedRplidar(EmulatedRoom room, RplidarModel model, RplidarTroubles troubles,
                                 EmulatedLine::Kind kind)
    : room_(std::move(room)),
      model_(model),
      troubles_(std::move(troubles)),
      line_(kind),
      began_steady_ns_(steady_ns()) {
  if (troubles_.is_sending) {
    way_ = Way::kStandard;
    is_measuring_ = true;
  }
  thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
}

std::vector<std::uint8_t> EmulatedRplidar::commands() const {
  const std::lock_guard lock(mutex_);
  return commands_;
}

std::vector<std::int64_t> EmulatedRplidar::turns_ns() const {
  const std::lock_guard lock(mutex_);
  return turns_ns_;
}

double EmulatedRplidar::now_s() const {
  return static_cast<double>(steady_ns() - began_steady_ns_) * 1e-9;
}

double EmulatedRplidar::sample_s() const {
  const double us = way_ == Way::kStandard  ? model_.standard_us
                    : way_ == Way::kExpress ? model_.express_us
                                            : model_.dense_us;
  return us * 1e-6 / model_.clock_rate;
}

int EmulatedRplidar::samples_of_packet() const {
  return way_ == Way::kStandard ? 1 : way_ == Way::kExpress ? 32 : 40;
}

double EmulatedRplidar::time_of(std::int64_t sample) const {
  return way_began_s_ + static_cast<double>(sample) * sample_s();
}

bool EmulatedRplidar::has_measured_for(std::optional<double> seconds) const {
  return way_ != Way::kNone && seconds && time_of(sent_) - way_began_s_ > *seconds;
}

double EmulatedRplidar::turned(std::int64_t sample) const {
  const double since_s = static_cast<double>(sample) * sample_s();
  const double slow_s = model_.spin_up_s;
  const double lag_s = slow_s > 0.0 ? slow_s * (1.0 - std::exp(-since_s / slow_s)) : 0.0;
  constexpr double kFirst = 0.4;  // a scan begins anywhere
  return kFirst + model_.turns_a_second * (since_s - lag_s);
}

double EmulatedRplidar::range_at(std::int64_t sample, double clockwise_deg) const {
  const double range_m = room_.range_m(time_of(sample), -clockwise_deg * kRadians);
  return range_m <= model_.range_max_m ? range_m : 0.0;
}

void EmulatedRplidar::run(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    constexpr int kPatienceMs = 2;
    if (has_measured_for(troubles_.is_unplugged_after_s)) {
      troubles_.is_unplugged_after_s.reset();
      way_ = Way::kNone;
      is_measuring_ = false;
      line_.disconnect();
    }
    const int patience_ms = send_due() ? kPatienceMs : 0;
    for (const char c : line_.read(patience_ms)) take(c);
  }
}

void EmulatedRplidar::take(char c) {
  pending_ += c;
  const auto at = [&](std::size_t i) { return static_cast<unsigned char>(pending_[i]); };
  if (at(0) != 0xA5) {
    pending_.clear();
  } else if (pending_.size() >= 2 && at(1) < 0x80) {
    obey(at(1), {});
    pending_.clear();
  } else if (pending_.size() >= 3 && pending_.size() == static_cast<std::size_t>(at(2)) + 4) {
    int checksum = 0;
    for (std::size_t i = 0; i + 1 < pending_.size(); ++i) checksum ^= at(i);
    if (checksum == at(pending_.size() - 1)) obey(at(1), pending_.substr(3, at(2)));
    pending_.clear();
  }
}

void EmulatedRplidar::answer(std::uint8_t command, std::uint8_t type, const std::string& data) {
  std::string bytes = "\xA5\x5A" + four(static_cast<std::int64_t>(data.size())) + byte(type) + data;
  if (troubles_.answer) bytes = troubles_.answer(command, bytes);
  line_.write(bytes);
}

void EmulatedRplidar::obey(std::uint8_t command, const std::string& payload) {
  {
    const std::lock_guard lock(mutex_);
    commands_.push_back(command);
  }
  const bool old = model_.firmware_minor < 17;
  if (command == 0x25) {
    way_ = Way::kNone;
    is_measuring_ = false;
  } else if (command == 0x40) {
    way_ = Way::kNone;
    is_measuring_ = false;
    troubles_.has_failed = false;
    line_.write("RP LIDAR System.\r\nFirmware Ver 1.29\r\n");
  } else if (command == 0x50) {
    std::string serial;
    for (int i = 0; i < 16; ++i) serial += byte(0xA0 + i);
    answer(command, 0x04,
           std::string{byte(model_.number), byte(model_.firmware_minor),
                       byte(model_.firmware_major), byte(7)} +
               serial);
  } else if (command == 0x52) {
    const bool failed = troubles_.has_failed || troubles_.fails_for_good;
    answer(command, 0x06, std::string{byte(failed ? 2 : 0), byte(failed ? 0x12 : 0), byte(0)});
  } else if (command == 0x59 && !old) {
    answer(command, 0x15,
           two(std::llround(model_.standard_us)) + two(std::llround(model_.express_us)));
  } else if (command == 0x84 && model_.firmware_minor >= 24) {
    obey_setting(payload);
  } else if (command == 0xFF && model_.number >= 0x20) {
    answer(command, 0xFF, four(model_.has_board ? 1 : 0));
  } else if (command == 0xF0 && model_.has_board) {
    motor_pwm_ = static_cast<int>(number_at(payload, 0));
  } else if (command == 0x20) {
    begin(command, Way::kStandard);
  } else if (command == 0x82 && !old && payload.size() == 5) {
    if (payload[0] == 2 && model_.dense_us > 0.0) begin(command, Way::kDense);
    if (payload[0] < 2) begin(command, Way::kExpress);
  }
}

void EmulatedRplidar::obey_setting(const std::string& payload) {
  if (payload.size() < 4) return;
  const std::int64_t setting = number_at(payload, 0);
  const std::int64_t mode = payload.size() >= 6 ? number_at(payload, 4) : 0;
  const auto reply = [&](const std::string& data) { answer(0x84, 0x20, four(setting) + data); };
  const int modes = model_.dense_us > 0.0 ? 3 : 2;
  if (setting == 0x70) return reply(two(modes));
  if (mode >= modes) return reply({});
  const double us = mode == 0   ? model_.standard_us
                    : mode == 1 ? model_.express_us
                                : model_.dense_us;
  if (setting == 0x71) reply(four(std::llround(us * 256.0)));
  if (setting == 0x74) reply(four(std::llround(model_.range_max_m * 256.0)));
  if (setting == 0x75) reply({byte(mode == 0 ? 0x81 : mode == 1 ? 0x82 : 0x85)});
  if (setting == 0x7F) {
    const char* name = mode == 0 ? "Standard" : mode == 1 ? "Express" : "DenseBoost";
    reply(std::string(name) + '\0');
  }
}

void EmulatedRplidar::begin(std::uint8_t command, Way way) {
  const bool stands = model_.has_board && motor_pwm_ == 0;
  const bool failed = troubles_.has_failed || troubles_.fails_for_good;
  if (stands || failed) return;
  way_ = way;
  is_measuring_ = true;
  way_began_s_ = now_s();
  sent_ = 0;
  const int length = way == Way::kStandard ? 5 : 84;
  const int type = way == Way::kStandard ? 0x81 : way == Way::kExpress ? 0x82 : 0x85;
  std::string bytes = "\xA5\x5A" + four(length | std::int64_t{1} << 30) + byte(type);
  if (troubles_.answer) bytes = troubles_.answer(command, bytes);
  line_.write(bytes);
}

// A busy machine may take longer for samples than they last: then it listens every now and then.
bool EmulatedRplidar::send_due() {
  constexpr std::int64_t kMostSamples = 256;
  if (way_ == Way::kNone || has_measured_for(troubles_.is_silent_after_s)) return true;
  const std::int64_t end = sent_ + kMostSamples;
  const auto is_due = [this] { return time_of(sent_ + samples_of_packet()) <= now_s(); };
  std::string due;
  while (sent_ < end && is_due()) {
    std::string packet = way_ == Way::kStandard ? node_of(sent_) : capsule_of(sent_);
    if (troubles_.packet) packet = troubles_.packet(packets_, packet);
    ++packets_;
    due += packet;
    sent_ += samples_of_packet();
  }
  line_.write(due);
  return !is_due();
}

/// Notes when a turn begins.
std::string EmulatedRplidar::node_of(std::int64_t sample) {
  const double angle_deg = 360.0 * (turned(sample) - std::floor(turned(sample)));
  const auto angle_q6 = static_cast<std::int64_t>(angle_deg * 64.0);
  const bool begins = sample > 0 && std::floor(turned(sample)) > std::floor(turned(sample - 1));
  if (begins) {
    const std::lock_guard lock(mutex_);
    turns_ns_.push_back(system_ns() - steady_ns() + began_steady_ns_ +
                        std::llround(time_of(sample) * 1e9));
  }
  const double range_m = range_at(sample, angle_deg);
  const int quality = range_m > 0.0 ? room_.brightness(-angle_deg * kRadians) : 0;
  return std::string{byte(quality << 2 | (begins ? 1 : 2)), byte(angle_q6 << 1 | 1),
                     byte(angle_q6 >> 7)} +
         two(std::llround(range_m * 4000.0));
}

std::string EmulatedRplidar::capsule_of(std::int64_t first) {
  const int count = samples_of_packet();
  const auto start_q6 = [&](std::int64_t sample) {
    return static_cast<std::int64_t>(std::floor(turned(sample) * 360.0 * 64.0));
  };
  const double begin_q6 = static_cast<double>(start_q6(first));
  const double step_q6 = static_cast<double>(start_q6(first + count)) - begin_q6;
  std::string body = two(start_q6(first) % (360 * 64) | (first == 0 ? 0x8000 : 0));
  std::int64_t words[2] = {};
  int lags[2] = {};
  for (int i = 0; i < count; ++i) {
    const std::int64_t sample = first + i;
    const double raw_deg = (begin_q6 + step_q6 * i / count) / 64.0;
    const double before_deg = (begin_q6 + step_q6 * (i - 1) / count) / 64.0;
    if (sample > 0 && std::floor(raw_deg / 360.0) > std::floor(before_deg / 360.0)) {
      const std::lock_guard lock(mutex_);
      turns_ns_.push_back(system_ns() - steady_ns() + began_steady_ns_ +
                          std::llround(time_of(sample) * 1e9));
    }
    if (way_ == Way::kDense) {
      body += two(std::llround(range_at(sample, raw_deg) * 1e3));
      continue;
    }
    lags[i % 2] = lag_of(sample);
    words[i % 2] = std::llround(range_at(sample, raw_deg - lag_of(sample) / 8.0) * 1e3) << 2 |
                   lags[i % 2] >> 4;
    if (i % 2 == 1)
      body += two(words[0]) + two(words[1]) + byte((lags[1] & 15) << 4 | (lags[0] & 15));
  }
  int checksum = 0;
  for (const char c : body) checksum ^= static_cast<unsigned char>(c);
  return std::string{byte(0xA0 | (checksum & 15)), byte(0x50 | checksum >> 4)} + body;
}

}  // namespace loopstone::test
