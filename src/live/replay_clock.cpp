#include "loopstone/live/replay_clock.hpp"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <utility>

namespace loopstone {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kPatience{50};
/// Who is later than this is not waited for to catch up.
constexpr std::chrono::milliseconds kMostLate{200};

}  // namespace

class ReplayClock::Impl {
 public:
  Impl(PlaybackRange range, double speed, std::function<void(const PlaybackState&)> tell)
      : range_(range), speed_(speed), tell_(std::move(tell)), now_(range.start) {
    say(false, {});
  }

  void control(const PlaybackControl& control);
  Turn wait_for(Stamp stamp, const std::function<bool()>& go_on);
  Turn wait_at_end(const std::function<bool()>& go_on);
  [[nodiscard]] std::optional<Stamp> goal() const {
    const std::scoped_lock lock(mutex_);
    return goal_;
  }

 private:
  /// Nothing while it is not due.
  [[nodiscard]] std::optional<Turn> turn_at(Stamp stamp);
  [[nodiscard]] PlaybackStatus status() const;
  void say(bool did_seek, std::string request);
  void count_from(Stamp stamp) { counted_from_ = {Clock::now(), stamp}; }

  PlaybackRange range_;
  double speed_;
  std::function<void(const PlaybackState&)> tell_;

  mutable std::mutex mutex_{};
  std::condition_variable changed_{};
  bool plays_ = true;
  bool is_at_end_ = false;
  bool goes_back_ = false;
  std::optional<Stamp> goal_{};
  Stamp now_{};
  std::optional<std::pair<Clock::time_point, Stamp>> counted_from_{};
  Clock::time_point due_{};
};

PlaybackStatus ReplayClock::Impl::status() const {
  if (goal_) return PlaybackStatus::kBuffering;
  if (is_at_end_) return PlaybackStatus::kEnded;
  return plays_ ? PlaybackStatus::kPlaying : PlaybackStatus::kPaused;
}

void ReplayClock::Impl::say(bool did_seek, std::string request) {
  tell_({.status = status(),
         .now = goal_.value_or(now_),
         .speed = speed_,
         .did_seek = did_seek,
         .request = std::move(request)});
}

void ReplayClock::Impl::control(const PlaybackControl& control) {
  const std::scoped_lock lock(mutex_);
  plays_ = control.play;
  speed_ = control.speed;
  counted_from_.reset();
  std::optional<Stamp> wish = control.seek_to;
  // To play what was played to its end is to begin again.
  if (!wish && is_at_end_ && control.play) wish = range_.start;
  if (wish) {
    goal_ = std::clamp(*wish, range_.start, range_.end);
    goes_back_ = goes_back_ || is_at_end_ || *goal_ < now_;
    is_at_end_ = false;
  }
  say(wish.has_value(), control.request);
  changed_.notify_all();
}

std::optional<ReplayClock::Turn> ReplayClock::Impl::turn_at(Stamp stamp) {
  if (std::exchange(goes_back_, false)) {
    now_ = range_.start;
    return Turn::kSeekBack;
  }
  if (goal_) {
    now_ = stamp;
    if (stamp < *goal_) return Turn::kGoOn;
    goal_.reset();
    count_from(stamp);
    say(false, {});
    return Turn::kGoOn;
  }
  if (!plays_) return {};
  if (!counted_from_) count_from(stamp);
  if (speed_ > 0.0) {
    const std::chrono::duration<double> after((stamp - counted_from_->second).seconds() / speed_);
    due_ = counted_from_->first + std::chrono::duration_cast<Clock::duration>(after);
    const Clock::time_point now = Clock::now();
    if (now < due_) return {};
    if (now - due_ > kMostLate) count_from(stamp);
  }
  now_ = stamp;
  return Turn::kGoOn;
}

ReplayClock::Turn ReplayClock::Impl::wait_for(Stamp stamp, const std::function<bool()>& go_on) {
  std::unique_lock lock(mutex_);
  while (true) {
    if (const auto turn = turn_at(stamp)) return *turn;
    Clock::time_point until = Clock::now() + kPatience;
    if (plays_) until = std::min(until, due_);
    lock.unlock();
    const bool goes_on = go_on();
    lock.lock();
    if (!goes_on) return Turn::kStopped;
    changed_.wait_until(lock, until);
  }
}

ReplayClock::Turn ReplayClock::Impl::wait_at_end(const std::function<bool()>& go_on) {
  std::unique_lock lock(mutex_);
  if (!goes_back_) {
    is_at_end_ = true;
    goal_.reset();
    now_ = range_.end;
    say(false, {});
  }
  while (!goes_back_) {
    lock.unlock();
    const bool goes_on = go_on();
    lock.lock();
    if (!goes_on) return Turn::kStopped;
    if (!goes_back_) changed_.wait_for(lock, kPatience);
  }
  goes_back_ = false;
  now_ = range_.start;
  return Turn::kSeekBack;
}

ReplayClock::ReplayClock(PlaybackRange range, double speed,
                         std::function<void(const PlaybackState&)> tell)
    : impl_(std::make_unique<Impl>(range, speed, std::move(tell))) {}
ReplayClock::~ReplayClock() = default;

void ReplayClock::control(const PlaybackControl& control) { impl_->control(control); }
ReplayClock::Turn ReplayClock::wait_for(Stamp stamp, const std::function<bool()>& go_on) {
  return impl_->wait_for(stamp, go_on);
}
ReplayClock::Turn ReplayClock::wait_at_end(const std::function<bool()>& go_on) {
  return impl_->wait_at_end(go_on);
}
std::optional<Stamp> ReplayClock::goal() const { return impl_->goal(); }

}  // namespace loopstone
