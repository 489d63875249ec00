#pragma once

#include <atomic>
#include <chrono>
#include <thread>

namespace loopstone::python {

/// Asks Python now and then whether Ctrl-C was pressed, while a call works without the lock of the
/// interpreter. For the thread that makes the call; others are told what it found.
class SignalCheck {
 public:
  /// True once it was. The error is then set in this thread, and throw_if_raised() raises it.
  [[nodiscard]] bool raised();
  /// With the lock held. Throws nb::python_error.
  void throw_if_raised() const;

 private:
  std::thread::id caller_ = std::this_thread::get_id();
  std::chrono::steady_clock::time_point next_{};
  std::atomic<bool> raised_{false};
};

}  // namespace loopstone::python
