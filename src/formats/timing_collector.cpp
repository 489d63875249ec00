#include "formats/timing_collector.hpp"

#include <algorithm>

#include "loopstone/base/median.hpp"

namespace loopstone {

void TimingCollector::add(Stamp stamp) {
  if (timing_.records++ == 0) {
    timing_.first = stamp;
  } else {
    const double interval_s = (stamp - timing_.last).seconds();
    if (intervals_s_.size() < kMostIntervals)
      intervals_s_.push_back(static_cast<float>(interval_s));
    if (interval_s > timing_.largest_gap_s) {
      timing_.largest_gap_s = interval_s;
      timing_.largest_gap_at = timing_.last;
    }
  }
  timing_.last = stamp;
}

TimingSummary TimingCollector::finish() {
  // Recorders write in bursts: the median alone may be far below what is usual.
  const double mean_s = timing_.records < 2 ? 0.0
                                            : (timing_.last - timing_.first).seconds() /
                                                  static_cast<double>(timing_.records - 1);
  if (mean_s > 0.0) timing_.rate_hz = 1.0 / mean_s;
  const double typical_s = std::max(mean_s, static_cast<double>(median_of(intervals_s_)));
  const double gap_s = std::max(0.5, 5.0 * typical_s);
  timing_.gaps = std::count_if(intervals_s_.begin(), intervals_s_.end(), [&](float interval_s) {
    return static_cast<double>(interval_s) > gap_s;
  });
  return timing_;
}

}  // namespace loopstone
