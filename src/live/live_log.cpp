#include "loopstone/live/live_log.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <deque>
#include <exception>
#include <map>
#include <mutex>
#include <thread>
#include <utility>
#include <variant>

#include "formats/skip_tally.hpp"
#include "live/live_clock.hpp"
#include "loopstone/base/error.hpp"

namespace loopstone {
namespace {

using Clock = std::chrono::steady_clock;
using Seconds = std::chrono::duration<double>;

constexpr std::chrono::milliseconds kPatience{50};
/// A source that was opened may take so long until its first scan; with none it has no laser.
constexpr double kFirstScanS = 1.0;
/// Clocks of two sources that differ by less are the same clock.
constexpr double kSameClockS = 1.0;
/// Broken records are told so many at a time.
constexpr std::size_t kMostProblems = 1000;

double seconds_since(Clock::time_point then) { return Seconds(Clock::now() - then).count(); }

/// Messages that share a clock's order: of one kind, and of one laser.
std::size_t kind_of(const SensorMessage& message) {
  const auto* scan = std::get_if<LaserScan>(&message);
  return message.index() + (scan == nullptr
                                ? 0
                                : std::variant_size_v<SensorMessage> *
                                      static_cast<std::size_t>(std::max(scan->lidar, 0)));
}

void set_stamp(SensorMessage& message, Stamp stamp) {
  std::visit([stamp](auto& m) { m.stamp = stamp; }, message);
}

/// Errors begin with the place where they are.
std::string without_name(const std::string& text, const std::string& name) {
  const std::string begin = name + ": ";
  return text.starts_with(begin) ? text.substr(begin.size()) : text;
}

/// What a source tells of its robot once it is open, kept for when it is lost.
struct ToldRobot {
  RobotModel robot{};
  std::optional<WheelModel> wheels{};  ///< by which its counts are to be read, whatever a file says
  std::vector<std::string> choices{};
};

ToldRobot told_by(const LogReader& reader) {
  ToldRobot told{.robot = reader.robot({}), .choices = reader.choices()};
  // A log that tells wheels tells them whatever it is given.
  WheelModel other = told.robot.wheels;
  other.metres_per_count *= 2.0;
  const WheelModel answer = reader.wheels(other);
  if (answer.metres_per_count != other.metres_per_count) told.wheels = answer;
  return told;
}

bool is_scan(const SensorMessage& message) { return std::holds_alternative<LaserScan>(message); }

}  // namespace

class LiveLog::Impl {
 public:
  Impl(std::vector<LiveSource> sources, LiveLogOptions options)
      : options_(std::move(options)), feeds_(sources.size()) {
    for (std::size_t i = 0; i < sources.size(); ++i) feeds_[i].source = std::move(sources[i]);
  }
  ~Impl() { close(); }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  [[nodiscard]] bool wait_for_sources();
  [[nodiscard]] std::optional<SensorMessage> next();
  [[nodiscard]] ReadProgress progress() const;
  [[nodiscard]] RobotModel robot(RobotModel base) const;
  [[nodiscard]] WheelModel wheels(WheelModel base) const;
  [[nodiscard]] const SkippedRecords& skipped() const { return tally_.skipped(); }
  [[nodiscard]] std::vector<std::string> choices() const;
  [[nodiscard]] std::vector<std::string> warnings() const;

 private:
  struct Feed {
    LiveSource source{};
    // Under the mutex:
    ToldRobot told{};  ///< when it was opened last
    bool is_open = false;
    bool is_over = false;
    std::optional<Clock::time_point> opened{};  ///< for the first time
    bool sent_scan = false;
    std::int64_t dropped = 0;  ///< scans, since it was told
    // Of the reader's thread:
    LiveClock clock{};
    bool has_clock = false;
    std::optional<Clock::time_point> last_scan{};
    bool is_silent = false;
    std::optional<Clock::time_point> told_drops{};
    std::jthread thread{};
  };
  struct Waiting {
    std::size_t feed = 0;
    SensorMessage message{};
    Clock::time_point arrived{};
    std::chrono::system_clock::time_point arrived_at{};
  };
  /// A laser of a source.
  using LaserName = std::pair<std::size_t, int>;

  // Of each source's thread:
  void run(std::size_t index, const std::stop_token& stop);
  /// True when the source is over for good.
  [[nodiscard]] bool read(std::size_t index, const std::stop_token& stop);
  void push(std::size_t index, SensorMessage message, const std::stop_token& stop);
  void pause(double seconds, const std::stop_token& stop);
  void tell(std::size_t feed, std::string text, bool is_trouble);

  // Of whoever reads:
  void begin();
  void close();
  [[nodiscard]] bool is_stopped() const { return options_.reading.stop && options_.reading.stop(); }
  void hand_out_news();
  void watch();
  void count(const LiveNews& news);
  [[nodiscard]] bool is_at_end() const;
  [[nodiscard]] bool has_all_sources() const;
  [[nodiscard]] std::optional<SensorMessage> use(Waiting waiting);
  void note_scan(Feed& feed, Clock::time_point arrived, std::size_t index);
  void align(Feed& feed, const Waiting& waiting);
  void say(const Feed& feed, std::string text, bool is_trouble);

  LiveLogOptions options_;
  std::vector<Feed> feeds_;
  bool has_begun_ = false;

  mutable std::mutex mutex_{};
  std::condition_variable_any changed_{};
  std::deque<Waiting> waiting_{};
  std::vector<LiveNews> news_{};
  std::vector<LogProblem> problems_{};
  std::exception_ptr failure_{};
  std::int64_t messages_ = 0;

  SkipTally tally_{};
  std::map<LaserName, int> lasers_{};  ///< their numbers
  std::map<std::string, std::int64_t> troubles_{};
  std::optional<double> reference_s_{};  ///< of the first source's clock: stamp less arrival
  std::string reference_{};
  std::optional<Clock::time_point> last_message_{};
  std::optional<Clock::time_point> watched_{};
};

// Threads of the sources.

void LiveLog::Impl::begin() {
  if (std::exchange(has_begun_, true)) return;
  for (std::size_t i = 0; i < feeds_.size(); ++i) {
    feeds_[i].thread = std::jthread([this, i](const std::stop_token& stop) { run(i, stop); });
  }
}

void LiveLog::Impl::close() {
  for (Feed& feed : feeds_) feed.thread.request_stop();
  changed_.notify_all();
  for (Feed& feed : feeds_) feed.thread = {};
}

void LiveLog::Impl::run(std::size_t index, const std::stop_token& stop) {
  Feed& feed = feeds_[index];
  double wait_s = options_.again_s;
  std::string told;
  bool was_open = false;
  while (!stop.stop_requested()) {
    std::string what;
    std::exception_ptr caught;
    try {
      if (read(index, stop)) break;
      if (stop.stop_requested()) break;
      what = "ended";
    } catch (const ReadingStopped&) {
      break;
    } catch (const UsageError&) {
      const std::scoped_lock lock(mutex_);
      failure_ = std::current_exception();
      break;
    } catch (const std::exception& error) {
      what = without_name(error.what(), feed.source.name);
      caught = std::current_exception();
    }
    {
      const std::scoped_lock lock(mutex_);
      was_open = std::exchange(feed.is_open, false);
    }
    if (!feed.source.is_opened_again) {
      if (!was_open) {
        const std::scoped_lock lock(mutex_);
        failure_ = caught;
      } else {
        tell(index, what, true);
      }
      break;
    }
    if (was_open) wait_s = options_.again_s;
    if (what != std::exchange(told, what) || was_open) tell(index, what + "; trying again", true);
    pause(wait_s, stop);
    wait_s = std::min(2.0 * wait_s, options_.again_most_s);
  }
  const std::scoped_lock lock(mutex_);
  feed.is_open = false;
  feed.is_over = true;
  changed_.notify_all();
}

bool LiveLog::Impl::read(std::size_t index, const std::stop_token& stop) {
  Feed& feed = feeds_[index];
  LogOptions how = options_.reading;
  how.stop = [this, stop] { return stop.stop_requested() || is_stopped(); };
  how.on_problem = [this](const LogProblem& problem) {
    const std::scoped_lock lock(mutex_);
    if (problems_.size() < kMostProblems) problems_.push_back(problem);
  };
  const std::unique_ptr<LogReader> reader = feed.source.open(how);
  ToldRobot told = told_by(*reader);
  {
    const std::scoped_lock lock(mutex_);
    feed.told = std::move(told);
    feed.is_open = true;
    if (feed.opened) news_.push_back({feed.source.name, "is back", false});
    if (!feed.opened) feed.opened = Clock::now();
    changed_.notify_all();
  }
  while (auto message = reader->next()) {
    if (stop.stop_requested()) return true;
    push(index, std::move(*message), stop);
  }
  return is_stopped() || (!feed.source.is_opened_again);
}

/// Of a source that does not wait the oldest scan makes room.
void LiveLog::Impl::push(std::size_t index, SensorMessage message, const std::stop_token& stop) {
  if (std::holds_alternative<RgbdFrame>(message)) return;
  Feed& feed = feeds_[index];
  const auto has_room = [this] { return waiting_.size() < options_.most_waiting; };
  std::unique_lock lock(mutex_);
  if (feed.source.waits) {
    if (!changed_.wait(lock, stop, has_room)) return;
  } else if (!has_room()) {
    auto oldest = std::ranges::find_if(waiting_, [&](const Waiting& waiting) {
      return waiting.feed == index && is_scan(waiting.message);
    });
    if (oldest == waiting_.end()) oldest = waiting_.begin();
    waiting_.erase(oldest);
    ++feed.dropped;
  }
  feed.sent_scan = feed.sent_scan || is_scan(message);
  waiting_.push_back({index, std::move(message), Clock::now(), std::chrono::system_clock::now()});
  changed_.notify_all();
}

void LiveLog::Impl::pause(double seconds, const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  const Clock::time_point begin = Clock::now();
  while (!stop.stop_requested() && !is_stopped() && seconds_since(begin) < seconds)
    changed_.wait_for(lock, stop, kPatience, [] { return false; });
}

void LiveLog::Impl::tell(std::size_t feed, std::string text, bool is_trouble) {
  const std::scoped_lock lock(mutex_);
  news_.push_back({feeds_[feed].source.name, std::move(text), is_trouble});
  changed_.notify_all();
}

// Whoever reads.

bool LiveLog::Impl::has_all_sources() const {
  return std::ranges::all_of(feeds_, [](const Feed& feed) {
    return feed.is_over || feed.sent_scan ||
           (feed.opened && seconds_since(*feed.opened) > kFirstScanS);
  });
}

bool LiveLog::Impl::wait_for_sources() {
  begin();
  while (!is_stopped()) {
    hand_out_news();
    std::unique_lock lock(mutex_);
    if (failure_) std::rethrow_exception(failure_);
    if (has_all_sources()) {
      for (const Waiting& waiting : waiting_) {
        const auto* scan = std::get_if<LaserScan>(&waiting.message);
        if (scan != nullptr) lasers_.try_emplace({waiting.feed, scan->lidar}, 0);
      }
      int number = 0;
      for (auto& laser : lasers_) laser.second = number++;
      return !waiting_.empty() ||
             !std::ranges::all_of(feeds_, [](const Feed& feed) { return feed.is_over; });
    }
    changed_.wait_for(lock, kPatience);
  }
  return false;
}

std::optional<SensorMessage> LiveLog::Impl::next() {
  begin();
  while (!is_stopped()) {
    hand_out_news();
    std::optional<Waiting> first;
    {
      std::unique_lock lock(mutex_);
      changed_.wait_for(lock, kPatience,
                        [this] { return !waiting_.empty() || failure_ || is_at_end(); });
      if (!waiting_.empty()) {
        first = std::move(waiting_.front());
        waiting_.pop_front();
        ++messages_;
        changed_.notify_all();
      } else if (failure_) {
        std::rethrow_exception(failure_);
      } else if (is_at_end()) {
        break;
      }
    }
    if (!first) {
      if (options_.end_after_s && last_message_ &&
          seconds_since(*last_message_) > *options_.end_after_s)
        break;
      if (options_.idle) options_.idle();
    } else if (auto message = use(std::move(*first))) {
      return message;
    }
  }
  hand_out_news();
  return {};
}

/// Nothing waits, and nothing will come.
bool LiveLog::Impl::is_at_end() const {
  return std::ranges::all_of(feeds_, [](const Feed& feed) { return feed.is_over; });
}

void LiveLog::Impl::hand_out_news() {
  std::vector<LiveNews> news;
  std::vector<LogProblem> problems;
  {
    const std::scoped_lock lock(mutex_);
    news.swap(news_);
    problems.swap(problems_);
  }
  for (const LogProblem& problem : problems) {
    tally_.add(problem);
    if (options_.reading.on_problem) options_.reading.on_problem(problem);
  }
  for (const LiveNews& what : news) count(what);
  watch();
}

void LiveLog::Impl::count(const LiveNews& news) {
  if (news.is_trouble) ++troubles_[news.source + ": " + news.text];
  if (options_.on_news) options_.on_news(news);
}

void LiveLog::Impl::say(const Feed& feed, std::string text, bool is_trouble) {
  count({feed.source.name, std::move(text), is_trouble});
}

/// Who has fallen silent, and whose scans are left out.
void LiveLog::Impl::watch() {
  constexpr double kBetweenDropsS = 10.0;
  constexpr double kBetweenLooksS = 0.05;
  if (watched_ && seconds_since(*watched_) < kBetweenLooksS) return;
  watched_ = Clock::now();
  for (Feed& feed : feeds_) {
    const double silent_s = feed.last_scan ? seconds_since(*feed.last_scan) : 0.0;
    bool is_open = false;
    std::int64_t dropped = 0;
    {
      const std::scoped_lock lock(mutex_);
      // Who is behind with what came does not know yet.
      is_open = feed.is_open && waiting_.empty();
      const bool may_tell = !feed.told_drops || seconds_since(*feed.told_drops) > kBetweenDropsS;
      if (may_tell) dropped = std::exchange(feed.dropped, 0);
    }
    if (!feed.is_silent && is_open && silent_s > options_.silence_s) {
      feed.is_silent = true;
      say(feed, fmt::format("no scan for {:.0f} s", options_.silence_s), true);
    }
    if (dropped > 0) {
      feed.told_drops = Clock::now();
      say(feed, "messages were left out: this machine is too slow for what comes", true);
    }
  }
}

void LiveLog::Impl::note_scan(Feed& feed, Clock::time_point arrived, std::size_t index) {
  if (std::exchange(feed.is_silent, false)) {
    const double silent_s = Seconds(arrived - *feed.last_scan).count();
    say(feeds_[index], fmt::format("scans come again, after {:.1f} s", silent_s), false);
  }
  feed.last_scan = arrived;
}

/// A source whose clock is another one than the first source's is put on that.
void LiveLog::Impl::align(Feed& feed, const Waiting& waiting) {
  if (std::exchange(feed.has_clock, true)) return;
  const double ahead_s =
      stamp_of(waiting.message).seconds() -
      std::chrono::duration<double>(waiting.arrived_at.time_since_epoch()).count();
  if (!reference_s_) {
    reference_s_ = ahead_s;
    reference_ = feed.source.name;
    return;
  }
  const double differs_s = ahead_s - *reference_s_;
  if (std::abs(differs_s) < kSameClockS) return;
  feed.clock.shift(Duration::from_seconds(-differs_s));
  say(feed,
      fmt::format("its clock is {:.1f} s {} that of {}: its stamps are put on that, by the time "
                  "at which they come",
                  std::abs(differs_s), differs_s > 0.0 ? "ahead of" : "behind", reference_),
      true);
}

std::optional<SensorMessage> LiveLog::Impl::use(Waiting waiting) {
  Feed& feed = feeds_[waiting.feed];
  last_message_ = waiting.arrived;
  align(feed, waiting);
  const auto stamp =
      feed.clock.take(stamp_of(waiting.message), kind_of(waiting.message), waiting.arrived);
  if (const auto jump = feed.clock.take_jump()) {
    say(feed,
        fmt::format("its clock jumped {} by {:.1f} s; the stamps go on as they were",
                    jump->nanoseconds < 0 ? "back" : "ahead", std::abs(jump->seconds())),
        true);
  }
  auto* scan = std::get_if<LaserScan>(&waiting.message);
  if (scan != nullptr) note_scan(feed, waiting.arrived, waiting.feed);
  if (!stamp) return {};
  set_stamp(waiting.message, *stamp);
  if (scan == nullptr) return std::move(waiting.message);
  const auto laser = lasers_.find({waiting.feed, scan->lidar});
  if (laser == lasers_.end() && !lasers_.empty()) {
    ++troubles_[feed.source.name + ": a laser that was not there at the beginning is left out"];
    return {};
  }
  if (laser != lasers_.end()) scan->lidar = laser->second;
  return std::move(waiting.message);
}

ReadProgress LiveLog::Impl::progress() const {
  const std::scoped_lock lock(mutex_);
  return {messages_, 0};
}

RobotModel LiveLog::Impl::robot(RobotModel base) const {
  const std::scoped_lock lock(mutex_);
  std::vector<LidarMount> mounts;
  for (const auto& [name, number] : lasers_) {
    const std::vector<LidarMount>& lidars = feeds_[name.first].told.robot.lidars;
    const auto lidar = static_cast<std::size_t>(std::max(name.second, 0));
    mounts.push_back(lidar < lidars.size() ? lidars[lidar] : LidarMount{});
  }
  for (const Feed& feed : feeds_) base.wheels = feed.told.wheels.value_or(base.wheels);
  if (!mounts.empty()) base.lidars = std::move(mounts);
  return base;
}

WheelModel LiveLog::Impl::wheels(WheelModel base) const {
  const std::scoped_lock lock(mutex_);
  for (const Feed& feed : feeds_) base = feed.told.wheels.value_or(base);
  return base;
}

std::vector<std::string> LiveLog::Impl::choices() const {
  const std::scoped_lock lock(mutex_);
  std::vector<std::string> all;
  for (const Feed& feed : feeds_) {
    all.insert(all.end(), feed.told.choices.begin(), feed.told.choices.end());
  }
  return all;
}

std::vector<std::string> LiveLog::Impl::warnings() const {
  std::vector<std::string> warnings;
  for (const auto& [text, count] : troubles_)
    warnings.push_back(count == 1 ? text : fmt::format("{} ({} times)", text, count));
  return warnings;
}

LiveLog::LiveLog(std::vector<LiveSource> sources, LiveLogOptions options)
    : impl_(std::make_unique<Impl>(std::move(sources), std::move(options))) {}
LiveLog::~LiveLog() = default;
bool LiveLog::wait_for_sources() { return impl_->wait_for_sources(); }
std::optional<SensorMessage> LiveLog::next() { return impl_->next(); }
ReadProgress LiveLog::progress() const { return impl_->progress(); }
RobotModel LiveLog::robot(RobotModel base) const { return impl_->robot(std::move(base)); }
WheelModel LiveLog::wheels(WheelModel base) const { return impl_->wheels(base); }
const SkippedRecords& LiveLog::skipped() const { return impl_->skipped(); }
std::vector<std::string> LiveLog::choices() const { return impl_->choices(); }
std::vector<std::string> LiveLog::warnings() const { return impl_->warnings(); }

}  // namespace loopstone
