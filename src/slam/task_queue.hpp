#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>
#include <utility>

namespace loopstone {

/// Runs tasks one after the other, in the order given, on a thread of its own.
/// After an exception nothing more is run until wait() has thrown it.
class TaskQueue {
 public:
  /// Whoever gives more tasks than are run waits: what tasks hold is memory.
  static constexpr std::size_t kMostWaiting = 8;

  TaskQueue() : thread_([this](const std::stop_token& stop) { work(stop); }) {}

  void run(std::function<void()> task) {
    {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [this] { return tasks_.size() < kMostWaiting || failure_; });
      if (failure_) return;
      tasks_.push_back(std::move(task));
    }
    changed_.notify_all();
  }

  /// Returns when every task given so far has ended.
  void wait() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return tasks_.empty() && !busy_; });
    if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
  }

 private:
  void work(const std::stop_token& stop) {
    std::unique_lock lock(mutex_);
    while (changed_.wait(lock, stop, [this] { return !tasks_.empty(); })) {
      const auto task = std::move(tasks_.front());
      tasks_.pop_front();
      busy_ = true;
      lock.unlock();
      std::exception_ptr failure;
      try {
        task();
      } catch (...) {
        failure = std::current_exception();
      }
      lock.lock();
      busy_ = false;
      if (failure) {
        failure_ = failure;
        tasks_.clear();
      }
      changed_.notify_all();
    }
  }

  std::mutex mutex_{};
  std::condition_variable_any changed_{};
  std::deque<std::function<void()>> tasks_{};
  bool busy_ = false;
  std::exception_ptr failure_{};
  std::jthread thread_;  // last: it stops before what it uses goes
};

}  // namespace loopstone
