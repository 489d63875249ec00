#include "signals.hpp"

#include <Python.h>
#include <nanobind/nanobind.h>

namespace loopstone::python {

namespace {

constexpr std::chrono::milliseconds kBetweenLooks{30};

}  // namespace

bool SignalCheck::raised() {
  if (raised_ || std::this_thread::get_id() != caller_) return raised_;
  const auto now = std::chrono::steady_clock::now();
  if (now < next_) return false;
  next_ = now + kBetweenLooks;
  const nanobind::gil_scoped_acquire lock;
  raised_ = PyErr_CheckSignals() != 0;
  return raised_;
}

void SignalCheck::throw_if_raised() const {
  if (raised_) throw nanobind::python_error();
}

}  // namespace loopstone::python
