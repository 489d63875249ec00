#pragma once

#include <chrono>
#include <string>

#include "app.hpp"
#include "loopstone/base/progress.hpp"

namespace loopstone::app {

/// Shows how far a run is: a bar with rate and time left on a terminal, a plain line every few
/// seconds when stderr is something else, nothing with --quiet. It also carries Ctrl-C into the
/// run: the callback returns false after it.
class ProgressDisplay {
 public:
  /// \param is_shown  false: it only carries Ctrl-C
  explicit ProgressDisplay(const AppContext& context, bool is_shown = true);
  ~ProgressDisplay();
  ProgressDisplay(const ProgressDisplay&) = delete;
  ProgressDisplay& operator=(const ProgressDisplay&) = delete;

  /// Valid as long as the display.
  [[nodiscard]] ProgressCallback callback();

  /// Shows the progress when it is time to; false after Ctrl-C.
  bool show(const Progress& progress);

  /// Removes the bar from the terminal, so that a line of the log can stand there.
  static void clear_line();

 private:
  using Clock = std::chrono::steady_clock;

  bool enabled_;
  bool terminal_;
  Clock::time_point start_ = Clock::now();
  Clock::time_point next_ = start_;
};

/// The words of a progress line: "mapping  42 %  2650 scans/s  310 x real time  0:12 left".
/// The bar, drawn when `bar_width` > 0, comes after the step.
[[nodiscard]] std::string progress_text(const Progress& progress, double elapsed_s, int bar_width);

}  // namespace loopstone::app
