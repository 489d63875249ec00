#include "support/emulated_scip.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

namespace loopstone::test {
namespace {

constexpr double kTurn = 2.0 * 3.14159265358979323846;

std::int64_t steady_ns() {
  return std::chrono::nanoseconds(std::chrono::steady_clock::now().time_since_epoch()).count();
}
std::int64_t system_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

/// A line with its checksum: the sum of its characters, its lower six bits, 0x30 added.
std::string summed(std::string_view text) {
  int sum = 0;
  for (const char c : text) sum += c;
  return std::string(text) + static_cast<char>(sum % 64 + '0') + "\n";
}
/// The checksum of a fact leaves out its semicolon.
std::string fact(const std::string& key, const std::string& value) {
  std::string line = summed(key + ":" + value);
  line.insert(line.size() - 2, ";");
  return line;
}

std::string encoded(std::uint32_t number, int characters) {
  std::string text;
  for (int i = characters - 1; i >= 0; --i)
    text += static_cast<char>((number >> (6 * i)) % 64 + '0');
  return text;
}

int digits(const std::string& text, std::size_t at, std::size_t count) {
  int number = 0;
  for (const char c : text.substr(at, count)) {
    if (c < '0' || c > '9') return -1;
    number = 10 * number + (c - '0');
  }
  return number;
}

}  // namespace

EmulatedScip::EmulatedScip(EmulatedRoom room, ScipModel model, ScipTroubles troubles,
                           EmulatedLine::Kind kind, std::uint16_t port)
    : room_(std::move(room)),
      model_(std::move(model)),
      troubles_(std::move(troubles)),
      line_(kind, port),
      began_steady_ns_(steady_ns()) {
  if (troubles_.is_sending)
    stream_ = Stream{fmt::format("MD{:04}{:04}010", model_.first_step, model_.last_step),
                     model_.first_step,
                     model_.last_step,
                     1,
                     0,
                     -1,
                     3,
                     false};
  thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
}

std::vector<std::string> EmulatedScip::commands() const {
  const std::lock_guard lock(mutex_);
  return commands_;
}

std::vector<std::int64_t> EmulatedScip::first_beams_ns() const {
  const std::lock_guard lock(mutex_);
  return first_beams_ns_;
}

double EmulatedScip::now_s() const {
  return static_cast<double>(steady_ns() - began_steady_ns_) * 1e-9;
}

double EmulatedScip::seconds_to(int step) const {
  return turn_s() * (static_cast<double>(step - model_.front_step) / model_.steps_of_turn + 0.5);
}

std::uint32_t EmulatedScip::clock_at(double time_s) const {
  const double since_s = restarted_s_ < 0.0 ? time_s : time_s - restarted_s_;
  const std::int64_t began_ms = restarted_s_ < 0.0 ? model_.clock_ms : 0;
  const auto ms =
      began_ms + static_cast<std::int64_t>(std::floor(since_s * model_.clock_rate * 1e3));
  return static_cast<std::uint32_t>(ms & 0xFFFFFF);
}

/// A scan that is due; returns for how long nothing else is [ms].
int EmulatedScip::send_due() {
  constexpr int kMostMs = 10;
  if (!stream_) return kMostMs;
  // The turns that ended while nobody asked for scans are over.
  const double end_s = turn_s() * static_cast<double>(next_turn_) + seconds_to(stream_->last);
  const double late_s = troubles_.late_s ? troubles_.late_s(sent_) : 0.0;
  const double left_s = end_s + late_s - now_s();
  if (left_s > 0.0) return std::min(kMostMs, static_cast<int>(std::ceil(left_s * 1e3)));
  const std::int64_t turn = next_turn_;
  next_turn_ += 1 + stream_->interval;
  send_scan(turn);
  return 0;
}

// Between any two scans it listens: a busy machine may take longer for a scan than a turn lasts.
void EmulatedScip::run(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    const int patience_ms = send_due();
    const std::string bytes = line_.read(patience_ms);
    if (!has_said_ && !bytes.empty()) {
      has_said_ = true;
      line_.write(troubles_.said_before);
    }
    for (const char c : bytes) {
      if (c != '\n' && c != '\r') {
        pending_ += c;
      } else if (!pending_.empty()) {
        obey(std::exchange(pending_, {}));
      }
    }
  }
}

void EmulatedScip::reply(const std::string& command, std::string_view status,
                         const std::string& lines) {
  std::string bytes = command + "\n" + summed(status) + lines + "\n";
  if (troubles_.reply) bytes = troubles_.reply(command, bytes);
  line_.write(bytes);
}

std::string EmulatedScip::facts(const std::string& command) const {
  const auto number = [](int value) { return std::to_string(value); };
  if (command == "VV")
    return fact("VEND", "Hokuyo Automatic Co.,Ltd.") + fact("PROD", model_.name) +
           fact("FIRM", "1.18.01(25/Jul./2011)") + fact("PROT", "SCIP 2.0") +
           fact("SERI", "H1234567");
  if (command == "PP")
    return fact("MODL", model_.name) + fact("DMIN", number(model_.shortest_mm)) +
           fact("DMAX", number(model_.longest_mm)) + fact("ARES", number(model_.steps_of_turn)) +
           fact("AMIN", number(model_.first_step)) + fact("AMAX", number(model_.last_step)) +
           fact("AFRT", number(model_.front_step)) + fact("SCAN", number(model_.turns_a_minute));
  return fact("MODL", model_.name) + fact("LASR", laser_is_on_ ? "ON" : "OFF") +
         fact("SCSP", number(model_.turns_a_minute)) +
         fact("MESM", stream_ ? "Measuring" : "Idle") + fact("SBPS", "USB Full Speed") +
         fact("TIME", fmt::format("{:06X}", clock_at(now_s()))) +
         fact("STAT", "Stable 000 no error.");
}

void EmulatedScip::obey(const std::string& command) {
  {
    const std::lock_guard lock(mutex_);
    commands_.push_back(command);
  }
  if (command == "VV" || command == "PP" || command == "II") {
    reply(command, "00", facts(command));
  } else if (command == "BM") {
    const char* status = troubles_.laser_fails_until_reset ? "01" : laser_is_on_ ? "02" : "00";
    laser_is_on_ = !troubles_.laser_fails_until_reset;
    reply(command, status);
  } else if (command == "QT") {
    stream_.reset();
    laser_is_on_ = false;
    reply(command, "00");
  } else if (command == "RS") {
    stream_.reset();
    laser_is_on_ = tells_time_ = troubles_.laser_fails_until_reset = false;
    restarted_s_ = now_s();
    reply(command, "00");
  } else if (command.size() == 3 && command.starts_with("TM")) {
    obey_time(command);
  } else if (command.starts_with("MD") || command.starts_with("MS") ||
             (command.starts_with("ME") && model_.knows_intensities)) {
    begin_stream(command);
  } else {
    reply(command, "0E");
  }
}

void EmulatedScip::obey_time(const std::string& command) {
  if (command == "TM0") {
    reply(command, tells_time_ ? "02" : "00");
    tells_time_ = true;
  } else if (command == "TM1") {
    if (!tells_time_) return reply(command, "04");
    reply(command, "00", summed(encoded(clock_at(now_s()), 4)));
  } else if (command == "TM2") {
    reply(command, tells_time_ ? "00" : "03");
    tells_time_ = false;
  } else {
    reply(command, "01");
  }
}

void EmulatedScip::begin_stream(const std::string& command) {
  if (command.size() < 15) return reply(command, command.size() < 10 ? "0C" : "0D");
  const int left = digits(command, 13, 2);
  Stream stream{.command = command.substr(0, 13),
                .first = digits(command, 2, 4),
                .last = digits(command, 6, 4),
                .cluster = digits(command, 10, 2),
                .interval = digits(command, 12, 1),
                .left = left == 0 ? -1 : left,
                .characters = command[1] == 'S' ? 2 : 3,
                .intensities = command[1] == 'E'};
  if (stream.first < 0) return reply(command, "01");
  if (stream.last < 0) return reply(command, "02");
  if (stream.cluster < 0) return reply(command, "03");
  if (stream.last > model_.last_step) return reply(command, "04");
  if (stream.last < stream.first) return reply(command, "05");
  if (stream.interval < 0) return reply(command, "06");
  if (left < 0) return reply(command, "07");
  laser_is_on_ = true;
  reply(command, "00");
  stream_ = stream;
  next_turn_ = std::max(next_turn_, static_cast<std::int64_t>(std::ceil(now_s() / turn_s())));
}

std::string EmulatedScip::data_of(double began_s) const {
  const int characters = stream_->characters;
  const auto most = characters == 2 ? 4095.0 : static_cast<double>(model_.longest_mm);
  std::string data;
  for (int step = stream_->first; step <= stream_->last; step += std::max(1, stream_->cluster)) {
    double nearest_mm = 1e9;
    const double angle_rad = (step - model_.front_step) * kTurn / model_.steps_of_turn;
    for (int k = 0; k < std::max(1, stream_->cluster) && step + k <= stream_->last; ++k) {
      const double range_m = room_.range_m(began_s + seconds_to(step + k),
                                           angle_rad + k * kTurn / model_.steps_of_turn);
      nearest_mm = std::min(nearest_mm, std::round(range_m * 1e3));
    }
    const bool nothing = !(nearest_mm <= most);
    const bool near = nearest_mm < model_.shortest_mm;
    constexpr int kTooNear = 2;
    data += encoded(static_cast<std::uint32_t>(nothing ? model_.nothing
                                               : near  ? kTooNear
                                                       : static_cast<int>(nearest_mm)),
                    characters);
    if (stream_->intensities)
      data += encoded(static_cast<std::uint32_t>(nothing ? 0 : room_.brightness(angle_rad)), 3);
  }
  return data;
}

void EmulatedScip::send_scan(std::int64_t turn) {
  if (troubles_.is_silent_after && sent_ >= *troubles_.is_silent_after) return;
  const double began_s = turn_s() * static_cast<double>(turn);
  if (troubles_.restarts_after && sent_ >= *troubles_.restarts_after) {
    restarted_s_ = began_s;
    troubles_.restarts_after.reset();
  }
  const int left = stream_->left < 0 ? 0 : --stream_->left;
  std::string bytes = fmt::format("{}{:02}\n", stream_->command, left) + summed("99") +
                      summed(encoded(clock_at(began_s), 4));
  const std::string data = data_of(began_s);
  for (std::size_t at = 0; at < data.size(); at += 64) bytes += summed(data.substr(at, 64));
  bytes += "\n";
  const int number = sent_++;
  {
    const std::lock_guard lock(mutex_);
    first_beams_ns_.push_back(system_ns() - steady_ns() + began_steady_ns_ +
                              std::llround((began_s + seconds_to(stream_->first)) * 1e9));
  }
  if (troubles_.scan) bytes = troubles_.scan(number, bytes);
  const bool breaks = troubles_.disconnects_after && sent_ >= *troubles_.disconnects_after;
  line_.write(std::string_view(bytes).substr(0, breaks ? bytes.size() / 2 : bytes.size()));
  if (stream_->left == 0) stream_.reset();
  if (breaks) {
    troubles_.disconnects_after.reset();
    line_.disconnect();
  }
}

}  // namespace loopstone::test
