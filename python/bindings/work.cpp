#include "work.hpp"

#include <Python.h>
#include <nanobind/stl/string.h>

#include <chrono>
#include <thread>

namespace loopstone::python {

namespace {

constexpr std::chrono::milliseconds kBetweenLooks{40};

}  // namespace

bool Work::tell(const Progress& progress) {
  const std::lock_guard lock(mutex_);
  // A step may come and go between two looks.
  if (news_.empty() || news_.back().step != progress.step) news_.emplace_back();
  news_.back() = {std::string(progress.step), progress.done, progress.total, progress.scans,
                  progress.recorded_s};
  return !stopped_;
}

void Work::end(std::exception_ptr error) {
  const std::lock_guard lock(mutex_);
  done_ = true;
  error_ = std::move(error);
  changed_.notify_all();
}

bool Work::wait() {
  const nb::gil_scoped_release unlocked;
  std::unique_lock lock(mutex_);
  return !changed_.wait_for(lock, kBetweenLooks, [this] { return done_; });
}

std::vector<Work::News> Work::take_news() {
  const std::lock_guard lock(mutex_);
  return std::exchange(news_, {});
}

void work_until_done(const nb::object& progress, const std::function<void(Work&)>& body) {
  Work work;
  std::thread thread([&] {
    try {
      body(work);
      work.end(nullptr);
    } catch (...) {
      work.end(std::current_exception());
    }
  });
  std::exception_ptr reason;
  const auto look = [&] {
    try {
      if (PyErr_CheckSignals() != 0) throw nb::python_error();
      for (const Work::News& news : work.take_news()) {
        if (!progress.is_none())
          progress(news.step, news.done, news.total, news.scans, news.recorded_s);
      }
    } catch (...) {
      reason = std::current_exception();
      work.stopped_ = true;
    }
  };
  while (work.wait()) {
    if (!reason) look();
  }
  {
    const nb::gil_scoped_release unlocked;
    thread.join();
  }
  if (!reason) look();
  if (reason) std::rethrow_exception(reason);
  if (work.error_) std::rethrow_exception(work.error_);
}

}  // namespace loopstone::python
