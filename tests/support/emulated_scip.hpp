#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "support/emulated_line.hpp"
#include "support/emulated_room.hpp"

namespace loopstone::test {

/// A scanner of Hokuyo's as its documents describe it; the defaults are a UTM-30LX.
struct ScipModel {
  std::string name = "SOKUIKI Sensor UTM-30LX";
  int shortest_mm = 23;
  int longest_mm = 60000;
  int steps_of_turn = 1440;
  int first_step = 0;
  int last_step = 1080;
  int front_step = 540;
  int turns_a_minute = 2400;
  int nothing = 1;                 ///< the number of a beam that meets nothing
  bool knows_intensities = true;   ///< the command ME
  std::int64_t clock_ms = 0x1234;  ///< of its 24-bit clock when it is switched on
  double clock_rate = 1.0;         ///< seconds of its clock in a second
};

/// What is wrong with it. Numbers of scans count those that it sent since it was switched on.
struct ScipTroubles {
  /// May change what it replies to a command.
  std::function<std::string(const std::string& command, std::string reply)> reply{};
  /// And what it sends of a scan.
  std::function<std::string(int scan, std::string bytes)> scan{};
  /// How late a scan is sent [s].
  std::function<double(int scan)> late_s{};
  std::optional<int> disconnects_after{};  ///< once
  std::optional<int> is_silent_after{};    ///< for good
  std::optional<int> restarts_after{};     ///< its clock begins anew, at 0, and it sends on
  bool is_sending = false;                 ///< already, when somebody connects first
  std::string said_before{};               ///< lies in its buffer when somebody connects first
  bool laser_fails_until_reset = false;
};

/// A Hokuyo scanner on a wire: it lies in wait on a thread of its own, off until BM or MD, and
/// speaks SCIP 2.0 with the commands VV, PP, II, BM, QT, RS, TM, MD, MS and ME. It shares no code
/// with what reads it.
class EmulatedScip {
 public:
  explicit EmulatedScip(EmulatedRoom room, ScipModel model = {}, ScipTroubles troubles = {},
                        EmulatedLine::Kind kind = EmulatedLine::Kind::kTcp, std::uint16_t port = 0);

  /// "scip://127.0.0.1:40123".
  [[nodiscard]] std::string address() const { return "scip://" + line_.place(); }
  [[nodiscard]] bool laser_is_on() const { return laser_is_on_; }
  [[nodiscard]] int scans() const { return sent_; }
  /// All commands so far.
  [[nodiscard]] std::vector<std::string> commands() const;
  /// Moments of the time of day [ns] at which the first beams of the scans so far were measured.
  [[nodiscard]] std::vector<std::int64_t> first_beams_ns() const;

 private:
  struct Stream {
    std::string command{};  ///< less the number of scans
    int first = 0;
    int last = 0;
    int cluster = 1;
    int interval = 0;
    int left = 0;  ///< scans; negative: without end
    int characters = 3;
    bool intensities = false;
  };

  void run(const std::stop_token& stop);
  void obey(const std::string& command);
  void reply(const std::string& command, std::string_view status, const std::string& lines = {});
  [[nodiscard]] std::string facts(const std::string& command) const;
  void obey_time(const std::string& command);
  void begin_stream(const std::string& command);
  [[nodiscard]] int send_due();
  void send_scan(std::int64_t turn);
  [[nodiscard]] std::string data_of(double began_s) const;
  [[nodiscard]] std::uint32_t clock_at(double time_s) const;
  [[nodiscard]] double turn_s() const { return 60.0 / model_.turns_a_minute; }
  [[nodiscard]] double now_s() const;
  /// From the rear, where a turn begins, to a step.
  [[nodiscard]] double seconds_to(int step) const;

  EmulatedRoom room_;
  ScipModel model_;
  ScipTroubles troubles_;
  EmulatedLine line_;
  std::int64_t began_steady_ns_;
  std::string pending_{};
  std::optional<Stream> stream_{};
  bool has_said_ = false;
  bool tells_time_ = false;
  std::atomic<bool> laser_is_on_ = false;
  std::atomic<int> sent_ = 0;
  double restarted_s_ = -1.0;
  std::int64_t next_turn_ = 0;
  mutable std::mutex mutex_{};
  std::vector<std::string> commands_{};
  std::vector<std::int64_t> first_beams_ns_{};
  std::jthread thread_{};
};

}  // namespace loopstone::test
