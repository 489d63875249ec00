#pragma once

#include <cstdint>
#include <deque>
#include <optional>

namespace loopstone {

/// One moment on two clocks of this machine: the one that never jumps, and the one that tells the
/// time of day.
struct HostTime {
  std::int64_t steady_ns = 0;
  std::int64_t system_ns = 0;

  [[nodiscard]] static HostTime now();
};

/// The time of day for moments of the steady clock. It follows the time of day as it is slewed, but
/// goes on as if nothing had happened when somebody sets it: scans keep their distances.
class HostClock {
 public:
  /// Told the time now and then, a few times a second.
  void hear(const HostTime& now);
  [[nodiscard]] std::int64_t system_ns(std::int64_t steady_ns) const;

 private:
  std::optional<std::int64_t> offset_ns_{};  ///< time of day - steady clock, as last heard
  std::int64_t jumped_ns_ = 0;               ///< of it, what came by jumps
};

/// A device's counter that wraps, as time that does not. Tells when the device began anew.
class WrappingClock {
 public:
  /// \param modulus  the counter goes from 0 to one less
  /// \param tick_ns  of one count
  WrappingClock(std::int64_t modulus, std::int64_t tick_ns)
      : modulus_(modulus), tick_ns_(tick_ns) {}

  struct Reading {
    std::int64_t device_ns = 0;
    bool is_new = false;  ///< the device was started anew: nothing connects it with what was before
  };
  /// \param steady_ns  when the count was heard; tells how often the counter went round meanwhile
  [[nodiscard]] Reading read(std::int64_t count, std::int64_t steady_ns);

 private:
  struct Last {
    std::int64_t count = 0;
    std::int64_t device_ns = 0;
    std::int64_t steady_ns = 0;
  };

  std::int64_t modulus_;
  std::int64_t tick_ns_;
  std::optional<Last> last_{};
};

/// Maps a device's clock to the host's. What the device says is heard later than it says by a delay
/// that varies; the smallest delay is taken as constant, so the map is the line below all (device
/// time, time heard - device time) of a sliding window that is nearest to them, and the varying
/// part of the delay does not get into stamps.
/// Source: Moon, Skelly and Towsley 1999, "Estimation and removal of clock skew from network delay
/// measurements"; of the line the edge of the lower convex hull over the middle of the window.
class ClockMapping {
 public:
  struct Numbers {
    double window_s = 20.0;
    double bucket_s = 0.5;          ///< of the window only the earliest of so long is kept
    double rate_after_s = 5.0;      ///< before it has seen so long, the rates are taken as equal
    double rate_error_max = 0.001;  ///< quartz is at least so good
  };

  explicit ClockMapping(const Numbers& numbers) : numbers_(numbers) {}

  /// Something that happened at a time of the device's clock was heard at a time of the host's.
  /// Device times may come again, but not go back.
  void hear(std::int64_t device_ns, std::int64_t steady_ns);
  /// The steady time at which a moment of the device's clock is heard without delay. After hear.
  [[nodiscard]] std::int64_t steady_ns(std::int64_t device_ns) const;
  /// Seconds of the host in a second of the device.
  [[nodiscard]] double rate() const { return 1.0 + slope_; }
  /// The device's clock began anew, at the rate that it had.
  void forget();

 private:
  struct Heard {
    std::int64_t device_ns = 0;
    std::int64_t delay_ns = 0;  ///< heard less device: with an offset that nobody knows
  };
  [[nodiscard]] double hull_slope() const;
  void fit();

  Numbers numbers_;
  std::deque<Heard> window_{};  ///< the earliest of each bucket
  std::int64_t bucket_began_ns_ = 0;
  double slope_ = 0.0;
  Heard touched_{};  ///< lies on the line
};

}  // namespace loopstone
