#include "loopstone/live/scanner_source.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "formats/skip_tally.hpp"
#include "loopstone/devices/scanner.hpp"
#include "loopstone/geometry/angle.hpp"

namespace loopstone {
namespace {

/// A scanner, read as a log is.
class ScannerLog final : public LogReader {
 public:
  ScannerLog(std::unique_ptr<Scanner> scanner, LogOptions how)
      : scanner_(std::move(scanner)), how_(std::move(how)) {}

  [[nodiscard]] std::optional<SensorMessage> next() override {
    auto scan = scanner_->next();
    const SkippedScans now = scanner_->skipped();
    tell(now.broken - told_.broken, "a scan came broken");
    tell(now.lost - told_.lost, "a scan was lost on the way");
    told_ = now;
    if (!scan) return {};
    ++scans_;
    return SensorMessage(std::move(*scan));
  }
  [[nodiscard]] ReadProgress progress() const override { return {scans_, 0}; }
  [[nodiscard]] std::string format() const override { return "scanner"; }
  [[nodiscard]] RobotModel robot(RobotModel base) const override {
    base.lidars = {LidarMount{.name = scanner_->facts().model, .robot_T_lidar = {}}};
    return base;
  }
  [[nodiscard]] const SkippedRecords& skipped() const override { return skipped_.skipped(); }
  [[nodiscard]] std::vector<std::string> choices() const override {
    const ScannerFacts& facts = scanner_->facts();
    return {fmt::format(
        "scanner: {} {} ({}, serial {}): {} beams over {:.0f} deg, {:.2f} to {:.1f} m, {:.1f} Hz",
        facts.vendor, facts.model, facts.mode, facts.serial, facts.beams,
        degrees(std::abs(facts.angle_increment_rad) * facts.beams), facts.range_min_m,
        facts.range_max_m, facts.rate_hz)};
  }

 private:
  void tell(std::int64_t count, const char* reason) {
    for (std::int64_t i = 0; i < count; ++i) {
      const LogProblem problem{{{scanner_->facts().address}, reason}, true};
      skipped_.add(problem);
      if (how_.on_problem) how_.on_problem(problem);
    }
  }

  std::unique_ptr<Scanner> scanner_;
  LogOptions how_;
  SkippedScans told_{};
  SkipTally skipped_{};
  std::int64_t scans_ = 0;
};

}  // namespace

LiveSource scanner_source(const std::string& address) {
  return {.name = address,
          .open = [address](const LogOptions& how) -> std::unique_ptr<LogReader> {
            auto scanner =
                open_scanner(address, {.stop = how.stop, .intensities = how.intensities});
            if (!scanner) throw ReadingStopped();
            return std::make_unique<ScannerLog>(std::move(scanner), how);
          },
          .waits = false};
}

}  // namespace loopstone
