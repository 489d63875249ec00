#include "pace.hpp"

#include <algorithm>
#include <cstddef>
#include <thread>

namespace loopstone::app {

namespace {

/// Ctrl-C is heard within this time.
constexpr std::chrono::milliseconds kPatience{50};

LatencyFigures figures_of(std::vector<double> seconds) {
  if (seconds.empty()) return {};
  std::sort(seconds.begin(), seconds.end());
  const auto at = [&](double share) {
    return seconds[static_cast<std::size_t>(share * static_cast<double>(seconds.size() - 1))];
  };
  return {.median_s = at(0.5), .p99_s = at(0.99), .worst_s = seconds.back()};
}

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

void Pace::note_pose() {
  const Clock::time_point now = Clock::now();
  const auto seconds_since = [&](Clock::time_point then) {
    return std::chrono::duration<double>(now - then).count();
  };
  if (scans_.empty()) return;
  after_arrival_s_.push_back(seconds_since(scans_.front()));
  computing_s_.push_back(seconds_since(due_));
  scans_.pop_front();
}

PaceFigures Pace::figures() const {
  return {.speed = speed_,
          .arrival = figures_of(after_arrival_s_),
          .computing = figures_of(computing_s_)};
}

}  // namespace loopstone::app
