#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "app.hpp"
#include "live_arguments.hpp"
#include "live_outlets.hpp"
#include "live_view.hpp"
#include "log_run.hpp"
#include "loopstone/live/live_log.hpp"
#include "output_path.hpp"
#include "progress_display.hpp"

namespace loopstone::app {

/// What mapping and localising live have in common: sources that are read until the user has
/// enough, with what the user is told and given of them.
class LiveDrive {
 public:
  /// Who looks on. Each may be empty.
  struct Watch {
    std::function<void(const std::string&)> warn{};  ///< told what befalls a source
    std::function<void()> idle{};                    ///< called while nothing comes
  };

  /// \param step  what the progress line calls the work
  /// Throws UsageError for sources that make no sense.
  LiveDrive(const LiveArguments& arguments, std::string_view step, const AppContext& context);

  /// The robot, when all sources are there; nothing when none ever came.
  [[nodiscard]] std::optional<RobotModel> wait_for_robot();
  /// A view in the browser, which does not listen yet; null where the user wants none.
  [[nodiscard]] std::unique_ptr<LiveView> make_view(const char* mode) const;
  void set_watch(Watch watch) { watch_ = std::move(watch); }

  /// Gives each message to `use`, which tells poses, until there are no more.
  void run(const RobotModel& robot,
           const std::function<void(const SensorMessage& message, PoseLines& poses)>& use);

  /// The sources in a row.
  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] const LiveLog& log() const { return log_; }
  // After run():
  [[nodiscard]] std::int64_t scans() const { return messages_->scans(); }
  /// CutLog::judge().
  [[nodiscard]] LogSummary judge() { return messages_->judge(name_); }

 private:
  [[nodiscard]] LiveLogOptions log_options();
  void tell(const LiveNews& news);

  const LiveArguments& arguments_;
  std::string_view step_;
  const AppContext& context_;
  std::string name_;
  Watch watch_{};
  ProblemPrinter print_problem_;
  LiveLog log_;
  ProgressDisplay display_;
  std::optional<CutLog> messages_{};
};

/// --record and --poses.
void add_live_outputs(const LiveArguments& arguments, Outputs& outputs);

}  // namespace loopstone::app
