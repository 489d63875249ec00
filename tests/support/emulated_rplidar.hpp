#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "support/emulated_line.hpp"
#include "support/emulated_room.hpp"

namespace loopstone::test {

/// An RPLIDAR as its documents describe it; the defaults are an A1M8 with firmware 1.29.
struct RplidarModel {
  int number = 0x18;
  int firmware_major = 1;
  int firmware_minor = 29;  ///< below 24 it knows no modes, below 17 no express scans
  double turns_a_second = 10.0;
  double spin_up_s = 0.05;     ///< its motor's time constant
  double standard_us = 500.0;  ///< from one measurement to the next
  double express_us = 250.0;
  double dense_us = 0.0;  ///< 0: it knows no dense scans, as the series A
  double range_max_m = 12.0;
  bool has_board = false;   ///< for its motor, which stands until told
  double clock_rate = 1.0;  ///< a second holds so many seconds of its measurements
};

/// What is wrong with it. Packets are nodes or capsules, counted since it was switched on; seconds
/// are those of the measurements that it has sent since it was last told to measure.
struct RplidarTroubles {
  /// May change what it sends of a packet.
  std::function<std::string(std::int64_t packet, std::string bytes)> packet{};
  /// And what it answers to a command.
  std::function<std::string(std::uint8_t command, std::string bytes)> answer{};
  std::optional<double> is_silent_after_s{};
  std::optional<double> is_unplugged_after_s{};  ///< once, and plugged in at once
  bool is_sending = false;                       ///< standard nodes, when somebody connects
  bool has_failed = false;                       ///< until it is reset
  bool fails_for_good = false;
};

/// An RPLIDAR on a pseudo terminal (or a TCP port): it answers on a thread of its own. DTR is not
/// seen by a pseudo terminal, so its motor turns, unless it has a board. It shares no code with
/// what reads it.
class EmulatedRplidar {
 public:
  explicit EmulatedRplidar(EmulatedRoom room, RplidarModel model = {},
                           RplidarTroubles troubles = {},
                           EmulatedLine::Kind kind = EmulatedLine::Kind::kTerminal);

  /// "rplidar:///tmp/.../port?baud=115200".
  [[nodiscard]] std::string address(const std::string& parameters = "?baud=115200") const {
    return "rplidar://" + line_.place() + parameters;
  }
  [[nodiscard]] bool is_measuring() const { return is_measuring_; }
  [[nodiscard]] int motor_pwm() const { return motor_pwm_; }
  [[nodiscard]] std::vector<std::uint8_t> commands() const;
  /// Moments of the time of day [ns] at which the turns so far began.
  [[nodiscard]] std::vector<std::int64_t> turns_ns() const;

 private:
  enum class Way { kNone, kStandard, kExpress, kDense };

  void run(const std::stop_token& stop);
  void take(char c);
  void obey(std::uint8_t command, const std::string& payload);
  void obey_setting(const std::string& payload);
  void answer(std::uint8_t command, std::uint8_t type, const std::string& data);
  void begin(std::uint8_t command, Way way);
  /// Returns whether that is all that is due.
  [[nodiscard]] bool send_due();
  [[nodiscard]] std::string node_of(std::int64_t sample);
  [[nodiscard]] std::string capsule_of(std::int64_t first);
  [[nodiscard]] double sample_s() const;
  [[nodiscard]] int samples_of_packet() const;
  [[nodiscard]] double now_s() const;
  /// Turned so far when a sample is measured [turns].
  [[nodiscard]] double turned(std::int64_t sample) const;
  [[nodiscard]] double time_of(std::int64_t sample) const;
  /// Sent measurements of so many seconds.
  [[nodiscard]] bool has_measured_for(std::optional<double> seconds) const;
  [[nodiscard]] double range_at(std::int64_t sample, double clockwise_deg) const;

  EmulatedRoom room_;
  RplidarModel model_;
  RplidarTroubles troubles_;
  EmulatedLine line_;
  std::int64_t began_steady_ns_;
  std::string pending_{};
  Way way_ = Way::kNone;
  double way_began_s_ = 0.0;
  std::int64_t sent_ = 0;     ///< samples of this way
  std::int64_t packets_ = 0;  ///< of all ways
  std::atomic<bool> is_measuring_ = false;
  std::atomic<int> motor_pwm_ = 0;
  mutable std::mutex mutex_{};
  std::vector<std::uint8_t> commands_{};
  std::vector<std::int64_t> turns_ns_{};
  std::jthread thread_{};
};

}  // namespace loopstone::test
