#include "devices/rplidar_scanner.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <deque>
#include <string>
#include <utility>
#include <vector>

#include "devices/clock_mapping.hpp"
#include "devices/rplidar_nodes.hpp"
#include "devices/rplidar_session.hpp"
#include "devices/rplidar_turns.hpp"

namespace loopstone {
namespace {

/// Until the motor turns evenly.
constexpr double kSpinUpS = 5.0;
/// Of measuring; so many turns that hardly differ tell how many beams a scan has.
constexpr std::size_t kAlikeTurns = 3;
constexpr double kAlike = 0.05;
/// The nearest that can be measured, by the datasheets: series A by triangulation, the others by
/// time of flight.
constexpr double kRangeMinOfA = 0.15;
constexpr double kRangeMinOfOthers = 0.05;

/// Turns of a length that is not plausible, one after the other, that noise may make.
constexpr int kMostOdd = 10;

double seconds_since(std::int64_t steady_ns) {
  return static_cast<double>(HostTime::now().steady_ns - steady_ns) * 1e-9;
}

std::string in_small_letters(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

bool is_meant(const RplidarMode& mode, const std::string& word) {
  return in_small_letters(mode.name) == word ||
         (mode.answer == RplidarAnswer::kNodes && word == "standard") ||
         (mode.answer == RplidarAnswer::kCapsules && word == "express") ||
         (mode.answer == RplidarAnswer::kDenseCapsules && word == "dense");
}

/// The mode that is asked for; of those that are left the fastest. Only nodes tell a quality.
RplidarMode chosen_mode(const std::vector<RplidarMode>& modes, bool intensities, const Wire& wire) {
  std::string names;
  std::vector<RplidarMode> left;
  const std::string word = in_small_letters(wire.address().mode);
  for (const RplidarMode& mode : modes) {
    names += (names.empty() ? "" : ", ") + mode.name;
    if (word.empty() ? !intensities || mode.answer == RplidarAnswer::kNodes : is_meant(mode, word))
      left.push_back(mode);
  }
  if (left.empty() && word.empty()) left = modes;
  if (left.empty())
    wire.fail("has no mode '" + word + "' that is understood here; it has " + names);
  return *std::min_element(left.begin(), left.end(),
                           [](const auto& a, const auto& b) { return a.sample_s < b.sample_s; });
}

/// The clock of a device without clock: it measures at an even rate.
class RplidarClock {
 public:
  explicit RplidarClock(double sample_s) : sample_s_(sample_s) {}

  /// So many samples were measured when the last packet was begun to be sent.
  void hear(std::int64_t samples, const HostTime& heard, double sending_s) {
    clock_.hear(heard);
    mapping_.hear(device_ns(samples), heard.steady_ns - std::llround(sending_s * 1e9));
  }
  void forget() { mapping_.forget(); }
  [[nodiscard]] Stamp stamp(std::int64_t sample) const {
    return {clock_.system_ns(mapping_.steady_ns(device_ns(sample)))};
  }
  [[nodiscard]] double seconds_of(std::int64_t samples) const {
    return static_cast<double>(samples) * sample_s_ * mapping_.rate();
  }

 private:
  [[nodiscard]] std::int64_t device_ns(std::int64_t samples) const {
    return std::llround(static_cast<double>(samples) * sample_s_ * 1e9);
  }

  double sample_s_;
  // Devices tell their sample time in whole microseconds, of about 30 to 500.
  ClockMapping mapping_{ClockMapping::Numbers{
      .window_s = 10.0, .bucket_s = 0.05, .rate_after_s = 0.2, .rate_error_max = 0.05}};
  HostClock clock_{};
};

class RplidarScanner final : public Scanner {
 public:
  RplidarScanner(const DeviceAddress& address, const ScannerOptions& options)
      : session_(address, options), silence_s_(options.silence_s) {
    session_.quiet();
    info_ = session_.ask_info();
    session_.make_healthy();
    mode_ = chosen_mode(session_.ask_modes(info_), options.intensities, session_.wire());
    session_.start_motor(info_);
    begin();
    facts_.intensities = options.intensities && mode_.answer == RplidarAnswer::kNodes;
    tell_facts(learn_samples_of_turn());
  }
  ~RplidarScanner() override { session_.rest(); }

  const ScannerFacts& facts() const override { return facts_; }
  SkippedScans skipped() const override { return {turns_.broken() + odd_turns_, lost_}; }

  std::optional<LaserScan> next() override {
    try {
      const std::int64_t began_ns = HostTime::now().steady_ns;
      for (int odd = 0;; ++odd) {
        if (odd >= kMostOdd && seconds_since(began_ns) > silence_s_)
          session_.wire().fail(
              "turns much faster or slower than when it was opened; is its motor free? Open it "
              "again");
        const RplidarTurn turn = next_turn(silence_s_);
        if (is_plausible(turn)) return finish(turn);
        ++odd_turns_;
      }
    } catch (const StopAsked&) {
      return {};
    }
  }

 private:
  void begin() {
    const std::string begun = session_.start(mode_);
    nodes_ = RplidarNodes(mode_.answer);
    clock_ = RplidarClock(mode_.sample_s);
    hear(begun);
  }

  void hear(std::string_view bytes) {
    const std::int64_t samples = nodes_.samples();
    const std::int64_t gaps = nodes_.gaps();
    for (const RplidarNode& node : nodes_.add(bytes)) {
      if (auto turn = turns_.add(node)) waiting_.push_back(*std::move(turn));
    }
    if (nodes_.gaps() != gaps) clock_.forget();  // how many samples were lost, nobody knows
    if (nodes_.samples() != samples)
      clock_.hear(nodes_.samples(), session_.wire().heard(),
                  session_.wire().seconds_for(nodes_.bytes_since()));
  }

  RplidarTurn next_turn(double patience_s) {
    const std::int64_t began_ns = HostTime::now().steady_ns;
    for (double waited_s = 0.0; waiting_.empty();) {
      if (waited_s > patience_s) give_up(patience_s);
      waited_s = seconds_since(began_ns);
      const std::string_view bytes = session_.wire().read(patience_s - waited_s);
      hear(bytes);
    }
    RplidarTurn turn = std::move(waiting_.front());
    waiting_.pop_front();
    return turn;
  }

  [[noreturn]] void give_up(double waited_s) const {
    const bool sends = seconds_since(session_.wire().heard().steady_ns) < waited_s / 2;
    session_.wire().fail(
        sends
            ? fmt::format("has not ended a turn for {:.1f} s; does its motor turn?", waited_s)
            : fmt::format("has been silent for {:.1f} s; is it powered and plugged in?", waited_s));
  }

  /// Waits until the motor turns evenly.
  std::int64_t learn_samples_of_turn() {
    constexpr std::int64_t kFewest = 16;
    const std::int64_t began_ns = HostTime::now().steady_ns;
    std::deque<std::int64_t> counts;
    for (;;) {
      counts.push_back(next_turn(silence_s_ + kSpinUpS).samples());
      if (counts.size() > kAlikeTurns) counts.pop_front();
      std::vector<std::int64_t> sorted(counts.begin(), counts.end());
      std::sort(sorted.begin(), sorted.end());
      const auto spread = static_cast<double>(sorted.back() - sorted.front());
      if (sorted.size() == kAlikeTurns && sorted.front() >= kFewest &&
          spread <= kAlike * static_cast<double>(sorted.back()))
        return sorted[kAlikeTurns / 2];
      if (seconds_since(began_ns) > silence_s_ + kSpinUpS)
        session_.wire().fail("turns unevenly; is its motor free, and the power enough?");
    }
  }

  void tell_facts(std::int64_t samples) {
    grid_ = {rplidar_beams(samples), info_.series() < 4 ? kRangeMinOfA : kRangeMinOfOthers,
             mode_.range_max_m};
    samples_of_turn_ = samples;
    facts_.address = session_.wire().address().text;
    facts_.vendor = "Slamtec";
    facts_.model = "RPLIDAR " + info_.name();
    facts_.serial = info_.serial;
    facts_.firmware = fmt::format("{}.{:02}, hardware {}", info_.firmware_major,
                                  info_.firmware_minor, info_.hardware);
    facts_.mode = mode_.name;
    facts_.beams = grid_.beams;
    facts_.angle_min_rad = 0.0;
    facts_.angle_increment_rad = grid_.angle_increment_rad();
    facts_.range_min_m = grid_.range_min_m;
    facts_.range_max_m = grid_.range_max_m;
    facts_.rate_hz = 1.0 / clock_.seconds_of(samples);
  }

  /// Flags that noise made end turns early.
  [[nodiscard]] bool is_plausible(const RplidarTurn& turn) const {
    return 2 * turn.samples() > samples_of_turn_ && turn.samples() < 2 * samples_of_turn_;
  }

  LaserScan finish(const RplidarTurn& turn) {
    LaserScan scan = grid_.scan_of(turn, facts_.intensities);
    const double turn_s = clock_.seconds_of(turn.samples());
    scan.stamp = clock_.stamp(turn.first_sample);
    if (has_scan_) {
      if (turn.after_gap) {
        const double missing = (scan.stamp - end_).seconds() / turn_s;
        lost_ +=
            std::max<std::int64_t>(0, std::llround(missing) - (skipped().broken - last_broken_));
      }
      scan.stamp = std::max(scan.stamp, last_stamp_ + Duration::from_seconds(turn_s / 4));
    }
    scan.time_increment_s = turn_s / grid_.beams;
    has_scan_ = true;
    last_stamp_ = scan.stamp;
    end_ = scan.stamp + Duration::from_seconds(turn_s);
    last_broken_ = skipped().broken;
    return scan;
  }

  RplidarSession session_;
  double silence_s_;
  RplidarInfo info_{};
  RplidarMode mode_{};
  RplidarNodes nodes_{RplidarAnswer::kNodes};
  RplidarTurns turns_{};
  RplidarClock clock_{1.0};
  std::deque<RplidarTurn> waiting_{};
  RplidarGrid grid_{};
  std::int64_t samples_of_turn_ = 0;
  ScannerFacts facts_{};
  std::int64_t odd_turns_ = 0;
  std::int64_t lost_ = 0;
  bool has_scan_ = false;
  Stamp last_stamp_{};
  Stamp end_{};  ///< of the last scan
  std::int64_t last_broken_ = 0;
};

}  // namespace

std::unique_ptr<Scanner> open_rplidar_scanner(const DeviceAddress& address,
                                              const ScannerOptions& options) {
  return std::make_unique<RplidarScanner>(address, options);
}

}  // namespace loopstone
