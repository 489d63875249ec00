#include "pace.hpp"

#include <algorithm>
#include <cstddef>
#include <thread>

namespace loopstone::app {

namespace {

/// Ctrl-C is heard within this time.
constexpr std::chrono::milliseconds kPatience{50};

}  // namespace

void Pace::wait_for(Stamp stamp, const std::function<bool()>& go_on) {
  if (!first_stamp_) {
    first_stamp_ = stamp;
    first_time_ = due_ = Clock::now();
  }
  const std::chrono::duration<double> after((stamp - *first_stamp_).seconds() / speed_);
  due_ = std::max(due_, first_time_ + std::chrono::duration_cast<Clock::duration>(after));
  while (Clock::now() < due_ && go_on()) {
    std::this_thread::sleep_until(std::min(due_, Clock::now() + kPatience));
  }
}

void Pace::note_done() {
  latencies_s_.push_back(std::chrono::duration<double>(Clock::now() - due_).count());
}

PaceFigures Pace::figures() const {
  PaceFigures figures{.speed = speed_};
  if (latencies_s_.empty()) return figures;
  std::vector<double> sorted = latencies_s_;
  std::sort(sorted.begin(), sorted.end());
  const auto at = [&](double share) {
    return sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1))];
  };
  figures.median_s = at(0.5);
  figures.p99_s = at(0.99);
  figures.worst_s = sorted.back();
  return figures;
}

}  // namespace loopstone::app
