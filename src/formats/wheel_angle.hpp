#pragma once

#include <cstdint>
#include <optional>

#include "loopstone/base/stamp.hpp"

namespace loopstone {

/// How far a wheel has turned, by what a driver says of its joint.
///
/// Positions count; of drivers that begin again at a turn (from -pi or 0 to pi or 2 pi) turns are
/// added. A jump by which the wheel would be faster than any is that of a driver that began anew:
/// there the speed counts, if it is told.
class WheelAngle {
 public:
  /// \param most_rad_s  no wheel turns faster
  explicit WheelAngle(double most_rad_s) : most_rad_s_(most_rad_s) {}

  /// \param position_rad  nothing, or no number: not told
  /// Readings that are not newer than the last are ignored.
  void add(Stamp stamp, std::optional<double> position_rad, std::optional<double> speed_rad_s);

  /// Since the first reading [rad], by positions and by speeds.
  [[nodiscard]] double by_position_rad() const { return by_position_rad_; }
  [[nodiscard]] double by_speed_rad() const { return by_speed_rad_; }
  /// Positions are of no use: there are none, or they stood still while the speeds did not.
  [[nodiscard]] bool needs_speed() const;
  /// How often it began anew.
  [[nodiscard]] std::int64_t resets() const { return resets_; }
  [[nodiscard]] bool has_moved() const { return moved_ || by_speed_rad_ != 0.0; }

 private:
  [[nodiscard]] double unwrapped(double step_rad, double expected_rad) const;
  void add_position(double position_rad, double seconds, std::optional<double> by_speed_rad);
  [[nodiscard]] std::optional<double> turned_by_speed(std::optional<double> speed_rad_s,
                                                      double seconds) const;

  double most_rad_s_;
  std::optional<Stamp> last_{};
  std::optional<double> position_rad_{};
  std::optional<double> speed_rad_s_{};
  double rate_rad_s_ = 0.0;  ///< of the last step by positions
  double lowest_rad_ = 0.0;
  double highest_rad_ = 0.0;
  double by_position_rad_ = 0.0;
  double by_speed_rad_ = 0.0;
  double farthest_by_speed_rad_ = 0.0;
  std::int64_t resets_ = 0;
  bool moved_ = false;  ///< by positions
};

/// The same of an encoder's counts.
class WheelCount {
 public:
  /// \param bits           where the counter wraps
  /// \param is_cumulative  counts since the start, else since the last reading
  WheelCount(int bits, bool is_cumulative) : bits_(bits), is_cumulative_(is_cumulative) {}

  /// \param most_per_second  no wheel counts faster
  void add(Stamp stamp, std::int64_t count, double most_per_second);
  /// Since the first reading.
  [[nodiscard]] std::int64_t total() const { return total_; }
  [[nodiscard]] std::int64_t resets() const { return resets_; }

 private:
  int bits_;
  bool is_cumulative_;
  std::optional<Stamp> last_{};
  std::int64_t count_ = 0;
  std::int64_t total_ = 0;
  std::int64_t resets_ = 0;
};

}  // namespace loopstone
