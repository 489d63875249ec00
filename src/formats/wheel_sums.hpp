#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "formats/wheel_names.hpp"
#include "loopstone/base/stamp.hpp"
#include "loopstone/sensor/messages.hpp"

namespace loopstone {

/// Brings wheels that are told each by itself to readings of all of them at once, at the times of
/// the first one; the others are interpolated. Wheels of one side and row are averaged; a side
/// without rows counts for both.
class WheelSums {
 public:
  static constexpr std::size_t kMostWaiting = 4096;

  explicit WheelSums(std::vector<WheelSpot> spots);

  /// \param rolled  since the start, in counts of the readings; finite
  /// Stamps of one wheel increase; others are ignored.
  void add(std::size_t wheel, Stamp stamp, double rolled);

  /// Readings that are complete, each of the counts since the one before. A wheel that falls silent
  /// for good ends them.
  [[nodiscard]] std::vector<WheelTicks> take();

 private:
  struct Sample {
    Stamp stamp{};
    double rolled = 0.0;
  };
  [[nodiscard]] static double at(const std::deque<Sample>& samples, Stamp stamp);
  [[nodiscard]] std::array<double, 4> totals(Stamp stamp) const;

  std::vector<WheelSpot> spots_;
  std::vector<std::deque<Sample>> waiting_;   ///< of each wheel
  std::vector<std::optional<Stamp>> newest_;  ///< of each wheel
  std::optional<std::array<std::int64_t, 4>> last_{};
};

}  // namespace loopstone
