#pragma once

#include <nanobind/nanobind.h>

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "loopstone/base/progress.hpp"

// Long calls: the work is done by a thread of its own, which never sees Python; the caller waits
// for it, and serves Python meanwhile: Ctrl-C, and whoever wants to know how far it is.

namespace loopstone::python {

namespace nb = nanobind;

/// Between a piece of work and who waits for it.
class Work {
 public:
  /// Called by the work, now and then. False: it is to end, its result will not be used.
  [[nodiscard]] bool tell(const Progress& progress);
  /// The same without news.
  [[nodiscard]] bool goes_on() const { return !stopped_; }
  [[nodiscard]] ProgressCallback callback() {
    return [this](const Progress& progress) { return tell(progress); };
  }

 private:
  friend void work_until_done(const nb::object& progress, const std::function<void(Work&)>& body);

  struct News {
    std::string step{};
    std::int64_t done = 0;
    std::int64_t total = 0;
    std::int64_t scans = 0;
    double recorded_s = 0.0;
  };
  void end(std::exception_ptr error);
  /// False once the work is done.
  [[nodiscard]] bool wait();
  /// The newest of each step since the last look.
  [[nodiscard]] std::vector<News> take_news();

  std::atomic<bool> stopped_{false};
  std::mutex mutex_{};
  std::condition_variable changed_{};
  bool done_ = false;
  std::exception_ptr error_{};
  std::vector<News> news_{};
};

/// What the work throws; what `progress` raises, and KeyboardInterrupt, once the work has ended.
/// \param progress  called with step, done, total, scans, recorded_s; or None
void work_until_done(const nb::object& progress, const std::function<void(Work&)>& body);

/// The same with a result.
template <typename Body>
[[nodiscard]] auto work(const nb::object& progress, Body&& body) {
  using Result = decltype(body(std::declval<Work&>()));
  std::optional<Result> result;
  work_until_done(progress, [&](Work& own) { result.emplace(body(own)); });
  return std::move(*result);
}

}  // namespace loopstone::python
