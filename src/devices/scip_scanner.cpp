#include "devices/scip_scanner.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <map>
#include <string_view>

#include "devices/scip_session.hpp"
#include "loopstone/geometry/angle.hpp"

namespace loopstone {
namespace {

constexpr std::int64_t kMillisecond = 1'000'000;
/// The device's clock has 24 bits.
constexpr std::int64_t kClockRound = 1 << 24;
/// A scan at 19200 baud takes 1 s.
constexpr std::int64_t kLongestDelayNs = 3'000'000'000;
/// Scans from which it is learned how long they are under way.
constexpr int kLearningScans = 40;
/// Until the motor turns and the laser is steady.
constexpr double kSpinUpS = 5.0;

using Texts = std::map<std::string, std::string>;

std::string text_of(const Texts& texts, const std::string& key) {
  const auto found = texts.find(key);
  return found == texts.end() ? std::string() : found->second;
}

/// How a scanner measures, as PP tells.
struct ScipGeometry {
  int shortest_mm = 0;
  int longest_mm = 0;
  int steps_of_turn = 0;
  int first_step = 0;
  int last_step = 0;
  int front_step = 0;
  int turns_a_minute = 0;

  [[nodiscard]] double step_rad() const { return 2.0 * kPi / steps_of_turn; }
  [[nodiscard]] double turn_s() const { return 60.0 / turns_a_minute; }
  /// From the moment that the device's stamp tells, when the beam points backwards, to a step.
  /// Source: hokuyo's own driver, urg_node, which turns stamps of the rear into such of the first
  /// beam.
  [[nodiscard]] double seconds_to(int step) const {
    return turn_s() * (static_cast<double>(step - front_step) / steps_of_turn + 0.5);
  }
};

int number_of(const Texts& texts, const std::string& key, int lowest, int highest,
              const Wire& wire) {
  const std::string text = text_of(texts, key);
  int number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc{} || end != text.data() + text.size() || number < lowest ||
      number > highest)
    wire.fail(fmt::format("tells {} as '{}', which is no number from {} to {}", key, text, lowest,
                          highest));
  return number;
}

ScipGeometry geometry_of(const Texts& texts, const Wire& wire) {
  constexpr int kMostSteps = 9999;  // four digits of a command
  ScipGeometry geometry;
  geometry.shortest_mm = number_of(texts, "DMIN", 0, 100'000, wire);
  geometry.longest_mm = number_of(texts, "DMAX", geometry.shortest_mm + 1, 262'143, wire);
  geometry.steps_of_turn = number_of(texts, "ARES", 4, 100'000, wire);
  geometry.first_step = number_of(texts, "AMIN", 0, kMostSteps, wire);
  geometry.last_step = number_of(texts, "AMAX", geometry.first_step + 1, kMostSteps, wire);
  geometry.front_step = number_of(texts, "AFRT", 0, kMostSteps, wire);
  geometry.turns_a_minute = number_of(texts, "SCAN", 1, 100'000, wire);
  return geometry;
}

/// Over USB the rate means nothing.
bool is_slow_line(const DeviceAddress& address) {
  if (!address.is_serial()) return false;
  char* real = ::realpath(address.path.c_str(), nullptr);
  const std::string path = real == nullptr ? address.path : std::string(real);
  std::free(real);
  return path.find("/ttyACM") == std::string::npos;
}

ScipRequest request_for(const ScipGeometry& geometry, const Wire& wire, bool intensities) {
  constexpr int kMostOfTwoCharacters = 4095;
  constexpr int kMostLeftOut = 9;
  const bool slow = is_slow_line(wire.address());
  ScipRequest request{
      .first_step = geometry.first_step,
      .last_step = geometry.last_step,
      .characters = slow && !intensities && geometry.longest_mm <= kMostOfTwoCharacters ? 2 : 3,
      .intensities = intensities};
  if (slow) {
    const double scan_s = wire.seconds_for(request.scan_bytes());
    request.interval =
        std::clamp(static_cast<int>(std::ceil(scan_s / geometry.turn_s())) - 1, 0, kMostLeftOut);
  }
  return request;
}

/// A device's stamps as moments of this machine.
class ScipStamps {
 public:
  /// \param reading  of the device's clock beside the host's; without it `delay_s`, the least that
  ///                 a scan can take, is taken for how long it takes
  ScipStamps(const std::optional<ScipSession::ClockReading>& reading, double delay_s)
      : learning_(reading ? kLearningScans : 0), delay_ns_(std::llround(delay_s * 1e9)) {
    if (!reading) return;
    const auto first = counter_.read(reading->count_ms, reading->steady_ns);
    offset_ns_ = reading->steady_ns - first.device_ns;
  }

  struct Moment {
    std::int64_t device_ns = 0;
    std::int64_t system_ns = 0;
    bool is_new = false;  ///< the device's clock began anew
  };
  [[nodiscard]] Moment hear(std::uint32_t stamp_ms, const HostTime& heard) {
    const auto reading = counter_.read(stamp_ms, heard.steady_ns);
    if (reading.is_new) {
      mapping_.forget();
      learning_ = 0;
    }
    clock_.hear(heard);
    mapping_.hear(reading.device_ns, heard.steady_ns);
    const std::int64_t least_ns = mapping_.steady_ns(reading.device_ns);
    if (learning_ > 0) {
      --learning_;
      const std::int64_t delay_ns = least_ns - (reading.device_ns + offset_ns_);
      // Otherwise its scans have another clock than it tells.
      if (delay_ns >= 0 && delay_ns < kLongestDelayNs) delay_ns_ = delay_ns;
    }
    return {reading.device_ns, clock_.system_ns(least_ns - delay_ns_), reading.is_new};
  }

 private:
  WrappingClock counter_{kClockRound, kMillisecond};
  ClockMapping mapping_{ClockMapping::Numbers{}};
  HostClock clock_{};
  int learning_;
  std::int64_t delay_ns_;  ///< of the quickest scan
  std::int64_t offset_ns_ = 0;
};

class ScipScanner final : public Scanner {
 public:
  ScipScanner(const DeviceAddress& address, const ScannerOptions& options)
      : session_(address, options), silence_s_(options.silence_s) {
    session_.quiet();
    const Texts version = session_.ask_facts("VV");
    geometry_ = geometry_of(session_.ask_facts("PP"), session_.wire());
    light();
    begin(options.intensities);
    stamps_.emplace(clock_reading_, geometry_.seconds_to(geometry_.last_step));
    tell_facts(version);
  }

  ~ScipScanner() override {
    try {
      session_.wire().write("QT\n");
    } catch (...) {
      // It is gone, or nobody wants to wait for it.
    }
  }

  const ScannerFacts& facts() const override { return facts_; }
  SkippedScans skipped() const override { return skipped_; }

  std::optional<LaserScan> next() override {
    try {
      return wait_for_scan();
    } catch (const StopAsked&) {
      return {};
    }
  }

 private:
  [[nodiscard]] std::int64_t period_ns() const {
    return std::llround(geometry_.turn_s() * (request_.interval + 1) * 1e9);
  }

  /// Reads the clock, which asks for a laser that is off, and switches it on.
  void light() {
    clock_reading_ = session_.ask_clock();
    ScipReply reply = session_.ask("BM");
    if (reply.status() == "01") {
      (void)session_.ask("RS");  // which sets the clock back, too
      clock_reading_ = session_.ask_clock();
      reply = session_.ask("BM");
    }
    if (reply.status() != "00" && reply.status() != "02") session_.refuse("BM", reply.status());
  }

  /// Asks for scans without end.
  void begin(bool intensities) {
    request_ = request_for(geometry_, session_.wire(), intensities);
    ScipReply reply = session_.ask(request_.command());
    if (reply.status() != "00" && reply.status() != "99" && intensities) {
      request_ = request_for(geometry_, session_.wire(), false);
      reply = session_.ask(request_.command());
    }
    if (reply.status() != "00" && reply.status() != "99")
      session_.refuse(request_.command(), reply.status());
    session_.replies().expect_echo(request_.command());
  }

  void tell_facts(const Texts& version) {
    facts_.address = session_.wire().address().text;
    facts_.vendor = text_of(version, "VEND");
    facts_.model = text_of(version, "PROD");
    facts_.serial = text_of(version, "SERI");
    facts_.firmware = text_of(version, "FIRM");
    facts_.mode = request_.command().substr(0, 2) + " by " + text_of(version, "PROT");
    facts_.beams = request_.beams();
    facts_.angle_increment_rad = geometry_.step_rad();
    facts_.angle_min_rad = (geometry_.first_step - geometry_.front_step) * geometry_.step_rad();
    facts_.range_min_m = geometry_.shortest_mm * 1e-3;
    facts_.range_max_m = geometry_.longest_mm * 1e-3;
    facts_.rate_hz = 1e9 / static_cast<double>(period_ns());
    facts_.intensities = request_.intensities;
  }

  LaserScan wait_for_scan() {
    const double allowed_s = silence_s_ + (has_scan_ ? 0.0 : kSpinUpS);
    const std::int64_t began_ns = HostTime::now().steady_ns;
    for (double waited_s = 0.0;;) {
      while (const auto reply = session_.replies().next()) {
        if (auto scan = scan_of(*reply)) return *std::move(scan);
      }
      if (waited_s > allowed_s) give_up(allowed_s);
      waited_s = static_cast<double>(HostTime::now().steady_ns - began_ns) * 1e-9;
      const std::string_view bytes = session_.wire().read(allowed_s - waited_s);
      session_.replies().add(bytes);
    }
  }

  [[noreturn]] void give_up(double waited_s) const {
    const std::int64_t silent_ns = HostTime::now().steady_ns - session_.wire().heard().steady_ns;
    const bool sends = static_cast<double>(silent_ns) * 1e-9 < waited_s / 2;
    session_.wire().fail(
        sends
            ? fmt::format("has sent no sound scan for {:.1f} s; is the line good?", waited_s)
            : fmt::format("has been silent for {:.1f} s; is it powered and plugged in?", waited_s));
  }

  std::optional<LaserScan> scan_of(const ScipReply& reply) {
    const std::string_view status = reply.status();
    const bool is_whole = reply.echo == request_.command() && !status.empty();
    // The rest of a scan that fell into pieces was counted with its beginning.
    const bool is_rest = reply.echo != request_.command() && was_broken_;
    was_broken_ = !is_whole;
    if (!is_whole) {
      skipped_.broken += is_rest ? 0 : 1;
      return {};
    }
    // It has begun, perhaps was told twice; it goes on after a check of itself; it checks itself.
    if (status == "00" || status == "0B" || status == "98" || (status >= "21" && status <= "49"))
      return {};
    if (status != "99") session_.refuse(request_.command(), status);
    const auto raw = decode_scip_scan(reply, request_);
    if (!raw) {
      was_broken_ = true;
      ++skipped_.broken;
      return {};
    }
    return finish(*raw);
  }

  LaserScan finish(const ScipScan& raw) {
    const auto moment = stamps_->hear(raw.stamp_ms, session_.wire().heard());
    count_lost(moment);
    LaserScan scan;
    scan.stamp = {moment.system_ns +
                  std::llround(geometry_.seconds_to(geometry_.first_step) * 1e9)};
    if (has_scan_)  // of a device that began anew, too
      scan.stamp = std::max(scan.stamp, last_stamp_ + Duration{period_ns() / 4});
    last_stamp_ = scan.stamp;
    has_scan_ = true;
    scan.angle_min_rad = facts_.angle_min_rad;
    scan.angle_increment_rad = facts_.angle_increment_rad;
    scan.range_min_m = facts_.range_min_m;
    scan.range_max_m = facts_.range_max_m;
    scan.time_increment_s = geometry_.turn_s() / geometry_.steps_of_turn;
    const ScipRanges ranges{geometry_.shortest_mm, geometry_.longest_mm};
    for (const std::uint32_t number : raw.ranges) scan.ranges_m.push_back(ranges.range_m(number));
    scan.intensities.assign(raw.intensities.begin(), raw.intensities.end());
    return scan;
  }

  /// What is missing between two stamps of the device, but for what came broken.
  void count_lost(const ScipStamps::Moment& moment) {
    if (has_scan_ && !moment.is_new) {
      const auto missing = static_cast<std::int64_t>(
          std::llround(static_cast<double>(moment.device_ns - last_device_ns_) /
                       static_cast<double>(period_ns())) -
          1);
      skipped_.lost += std::max<std::int64_t>(0, missing - (skipped_.broken - last_broken_));
    }
    last_device_ns_ = moment.device_ns;
    last_broken_ = skipped_.broken;
  }

  ScipSession session_;
  double silence_s_;
  ScipGeometry geometry_{};
  ScipRequest request_{};
  std::optional<ScipSession::ClockReading> clock_reading_{};
  std::optional<ScipStamps> stamps_{};
  ScannerFacts facts_{};
  SkippedScans skipped_{};
  bool was_broken_ = false;  ///< the last reply
  bool has_scan_ = false;
  Stamp last_stamp_{};
  std::int64_t last_device_ns_ = 0;
  std::int64_t last_broken_ = 0;
};

}  // namespace

std::unique_ptr<Scanner> open_scip_scanner(const DeviceAddress& address,
                                           const ScannerOptions& options) {
  return std::make_unique<ScipScanner>(address, options);
}

}  // namespace loopstone
