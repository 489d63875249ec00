#include "progress_display.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdio>

#include "interrupt.hpp"

namespace loopstone::app {

namespace {

constexpr auto kBarInterval = std::chrono::milliseconds(100);
constexpr auto kLineInterval = std::chrono::seconds(5);
constexpr int kBarWidth = 24;

std::atomic<bool> bar_on_screen{false};  // also read by who ends the process

std::string clock_text(double seconds) {
  const auto whole = static_cast<long>(std::llround(std::min(seconds, 359999.0)));
  if (whole >= 3600) {
    return fmt::format("{}:{:02}:{:02}", whole / 3600, whole / 60 % 60, whole % 60);
  }
  return fmt::format("{}:{:02}", whole / 60, whole % 60);
}

}  // namespace

std::string progress_text(const Progress& progress, double elapsed_s, int bar_width) {
  std::string text{progress.step};
  if (progress.total > 0) {
    const double ratio = std::clamp(
        static_cast<double>(progress.done) / static_cast<double>(progress.total), 0.0, 1.0);
    if (bar_width > 0) {
      const int filled = static_cast<int>(ratio * bar_width);
      text += fmt::format(" [{:#>{}}{:->{}}]", "", filled, "", bar_width - filled);
    }
    text += fmt::format(" {:3.0f} %", std::floor(100.0 * ratio));
    if (elapsed_s > 0.2) {
      if (progress.scans > 0) {
        text += fmt::format("  {:.0f} scans/s", static_cast<double>(progress.scans) / elapsed_s);
      }
      if (progress.recorded_s > 0.0) {
        text += fmt::format("  {:.0f} x real time", progress.recorded_s / elapsed_s);
      }
      if (ratio > 0.01) {
        text += fmt::format("  {} left", clock_text(elapsed_s * (1.0 - ratio) / ratio));
      }
    }
  } else {
    text += fmt::format(" {}", progress.done);
  }
  return text;
}

ProgressDisplay::ProgressDisplay(const AppContext& context, bool is_shown)
    : enabled_(is_shown && !context.quiet()), terminal_(isatty(STDERR_FILENO) != 0) {
  // A run that is over at once needs no lines at all.
  next_ = start_ + (terminal_ ? Clock::duration(kBarInterval) : Clock::duration(kLineInterval));
}

ProgressDisplay::~ProgressDisplay() { clear_line(); }

void ProgressDisplay::clear_line() {
  if (!bar_on_screen) return;
  std::fputs("\r\033[K", stderr);
  bar_on_screen = false;
}

ProgressCallback ProgressDisplay::callback() {
  return [this](const Progress& progress) { return show(progress); };
}

bool ProgressDisplay::show(const Progress& progress) {
  if (interrupted()) return false;
  if (!enabled_) return true;
  const auto now = Clock::now();
  if (now < next_) return true;
  const double elapsed_s = std::chrono::duration<double>(now - start_).count();
  if (terminal_) {
    next_ = now + kBarInterval;
    fmt::print(stderr, "\r\033[K{}", progress_text(progress, elapsed_s, kBarWidth));
    std::fflush(stderr);
    bar_on_screen = true;
  } else {
    next_ = now + kLineInterval;
    fmt::print(stderr, "{}\n", progress_text(progress, elapsed_s, 0));
  }
  return true;
}

}  // namespace loopstone::app
