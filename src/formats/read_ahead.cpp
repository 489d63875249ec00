#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <exception>
#include <mutex>
#include <stop_token>
#include <thread>
#include <utility>
#include <vector>

#include "loopstone/formats/left_out.hpp"
#include "loopstone/formats/log_reader.hpp"

namespace loopstone {
namespace {

/// Messages are handed over so many at a time: waking a thread costs more than reading a message.
constexpr std::size_t kBatch = 64;
constexpr std::size_t kMostWaiting = 256;
/// Of the broken records between two messages so many are told one by one; the others are counted.
constexpr std::size_t kMostTold = 1000;

/// One call of next(), with what was known after it.
struct Step {
  std::optional<SensorMessage> message{};
  std::exception_ptr failure{};
  std::vector<LogProblem> problems{};
  std::optional<SkippedRecords> skipped{};  ///< when it changed
  ReadProgress progress{};

  [[nodiscard]] bool is_last() const { return !message.has_value(); }
};

class ReadAhead final : public LogReader {
 public:
  ReadAhead(const std::string& path, const LogOptions& options) : on_problem_(options.on_problem) {
    LogOptions own = options;
    own.on_problem = [this](const LogProblem& problem) {
      if (found_.size() < kMostTold) found_.push_back(problem);
    };
    own.stop = [this, asked = options.stop] { return closing_ || (asked && asked()); };
    try {
      reader_ = open_log(path, own);
    } catch (...) {
      tell(found_);
      throw;
    }
    tell(std::exchange(found_, {}));
    skipped_ = reader_->skipped();
    now_ = {.progress = reader_->progress()};
  }

  ~ReadAhead() override { closing_ = true; }  // the thread need not come to the next message
  ReadAhead(const ReadAhead&) = delete;
  ReadAhead& operator=(const ReadAhead&) = delete;

  [[nodiscard]] std::optional<SensorMessage> next() override {
    if (over_) return {};
    if (!thread_.joinable()) {
      thread_ = std::jthread([this](const std::stop_token& stop) { work(stop); });
    }
    if (next_taken_ == taken_.size()) take();
    now_ = std::move(taken_[next_taken_++]);
    over_ = now_.is_last();
    tell(now_.problems);
    if (now_.skipped) skipped_ = std::move(*now_.skipped);
    if (now_.failure) std::rethrow_exception(now_.failure);
    return std::move(now_.message);
  }

  [[nodiscard]] ReadProgress progress() const override { return now_.progress; }
  [[nodiscard]] const SkippedRecords& skipped() const override { return skipped_; }
  [[nodiscard]] std::string format() const override { return reader_->format(); }
  [[nodiscard]] RobotModel robot(RobotModel base) const override {
    const std::scoped_lock lock(reading_);
    return reader_->robot(std::move(base));
  }
  [[nodiscard]] WheelModel wheels(WheelModel base) const override {
    const std::scoped_lock lock(reading_);
    return reader_->wheels(base);
  }
  [[nodiscard]] std::vector<std::string> notes() const override {
    const std::scoped_lock lock(reading_);
    return reader_->notes();
  }
  [[nodiscard]] std::vector<std::string> warnings() const override {
    const std::scoped_lock lock(reading_);
    return reader_->warnings();
  }
  [[nodiscard]] std::vector<std::string> choices() const override {
    const std::scoped_lock lock(reading_);
    return reader_->choices();
  }
  [[nodiscard]] std::shared_ptr<const PictureStore> pictures() const override {
    return reader_->pictures();
  }
  [[nodiscard]] std::string camera_fault() const override { return reader_->camera_fault(); }
  [[nodiscard]] std::vector<TopicSummary> topics() const override {
    const std::scoped_lock lock(reading_);
    return reader_->topics();
  }

 private:
  void tell(const std::vector<LogProblem>& problems) const {
    if (!on_problem_) return;
    for (const LogProblem& problem : problems) on_problem_(problem);
  }

  /// Waits for what was read.
  void take() {
    taken_.clear();
    next_taken_ = 0;
    std::unique_lock lock(mutex_);
    hungry_ = true;
    changed_.wait(lock, [this] { return !waiting_.empty(); });
    hungry_ = false;
    taken_.swap(waiting_);
    changed_.notify_all();
  }

  void work(const std::stop_token& stop) {
    std::vector<Step> batch;
    for (bool last = false; !last && !stop.stop_requested();) {
      batch.push_back(read());
      last = batch.back().is_last();
      if (batch.size() < kBatch && !last && !hungry_) continue;
      std::unique_lock lock(mutex_);
      if (!changed_.wait(lock, stop, [this] { return waiting_.size() < kMostWaiting; })) return;
      for (Step& step : batch) waiting_.push_back(std::move(step));
      batch.clear();
      changed_.notify_all();
    }
  }

  [[nodiscard]] Step read() {
    const std::scoped_lock lock(reading_);
    Step step;
    try {
      step.message = reader_->next();
    } catch (...) {
      step.failure = std::current_exception();
    }
    if (!found_.empty()) step.skipped = reader_->skipped();
    step.problems = std::exchange(found_, {});
    step.progress = reader_->progress();
    return step;
  }

  std::function<void(const LogProblem&)> on_problem_;
  SkippedRecords skipped_{};  ///< until the message that was last handed out
  std::unique_ptr<LogReader> reader_{};
  std::vector<LogProblem> found_{};  // since the last step
  mutable std::mutex reading_{};

  Step now_{};
  std::vector<Step> taken_{};
  std::size_t next_taken_ = 0;
  bool over_ = false;

  std::mutex mutex_{};
  std::condition_variable_any changed_{};
  std::vector<Step> waiting_{};
  std::atomic<bool> hungry_{false};
  std::atomic<bool> closing_{false};
  std::jthread thread_{};  // last: it stops before what it uses goes
};

}  // namespace

std::unique_ptr<LogReader> open_log_ahead(const std::string& path, const LogOptions& options) {
  return std::make_unique<ReadAhead>(path, options);
}

}  // namespace loopstone
