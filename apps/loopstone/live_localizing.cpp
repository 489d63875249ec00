#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "initial_pose.hpp"
#include "interrupt.hpp"
#include "known_map.hpp"
#include "live_arguments.hpp"
#include "live_drive.hpp"
#include "live_outlets.hpp"
#include "live_view.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/live/localization_feed.hpp"
#include "loopstone/localization/localizer.hpp"
#include "loopstone/report/localization_figures.hpp"
#include "loopstone/report/localization_outputs.hpp"
#include "output_path.hpp"
#include "result.hpp"

namespace loopstone::app {

namespace {

constexpr const char* kDriveEnds = "the drive ends";
constexpr std::uint64_t kSeed = 1;

Outputs outputs_of(const LiveArguments& arguments, const AppContext& context) {
  Outputs outputs(context, arguments.force);
  outputs.reads(arguments.map);
  outputs.reads(map_yaml_of(arguments.map));
  if (!arguments.out.empty()) add_trajectory_output(arguments.out, outputs);
  add_live_outputs(arguments, outputs);
  return outputs;
}

/// One drive on a map, from the first message of its sources on.
class LiveLocalizing {
 public:
  LiveLocalizing(const LiveArguments& arguments, const AppContext& context)
      : arguments_(arguments),
        context_(context),
        initial_(initial_pose(arguments.initial, arguments.initial_sigma)),
        options_(context.load_options<LocalizationOptions>()),
        drive_(arguments, "localising live", context) {}

  [[nodiscard]] ExitCode run();

 private:
  void watch_it(const RobotModel& robot, const LocalizationMap& map);
  void drive(const RobotModel& robot);
  void take_initial_pose();
  [[nodiscard]] ExitCode tell_result(const LocalizationResult& result);

  const LiveArguments& arguments_;
  const AppContext& context_;
  std::optional<InitialPose> initial_;
  LocalizationOptions options_;
  LiveDrive drive_;
  std::unique_ptr<LiveView> view_{};
  std::unique_ptr<LocalizationFeed> feed_{};  ///< who looks on, if anybody
  std::unique_ptr<Localizer> localizer_{};
};

void LiveLocalizing::watch_it(const RobotModel& robot, const LocalizationMap& map) {
  LiveListener* const listener = arguments_.listener;
  view_ = drive_.make_view("localizing");
  if (view_) feed_ = std::make_unique<LocalizationFeed>(view_->board(), robot, map);
  if (listener != nullptr) listener->localizing_begins(map);
  drive_.set_watch({.warn =
                        [this](const std::string& text) {
                          if (feed_) feed_->add_warning(text);
                        },
                    .idle =
                        [this, listener] {
                          if (feed_) feed_->catch_up(*localizer_);
                          if (listener != nullptr) listener->catch_up(nullptr);
                        }});
  if (view_) view_->open(context_);
}

void LiveLocalizing::take_initial_pose() {
  if (arguments_.listener == nullptr) return;
  const auto initial = arguments_.listener->take_initial_pose();
  if (initial) localizer_->restart_at(*initial);
}

void LiveLocalizing::drive(const RobotModel& robot) {
  drive_.run(robot, [&](const SensorMessage& message, PoseLines& poses) {
    if (feed_) feed_->add(message);
    take_initial_pose();
    localizer_->add(message);
    while (const auto estimate = localizer_->next_update()) {
      if (feed_) feed_->add(*estimate, *localizer_);
      if (arguments_.listener != nullptr) arguments_.listener->add(*estimate);
      poses.tell(*estimate);
    }
  });
}

ExitCode LiveLocalizing::tell_result(const LocalizationResult& result) {
  for (const std::string& warning : result.warnings) context_.warn(warning);
  const LocalizationFigures figures = figures_of(result);
  Result table;
  table.add("scans", "scans", result.scans);
  table.add("duration_s", "driven", result.duration_s, "s", 1);
  table.add("path_length_m", "path", result.path_length_m, "m", 1);
  table.add("tracking_percent", "TRACKING", 100.0 * figures.tracking_share, "% of the time", 1);
  table.add("doubtful_percent", "DOUBTFUL", 100.0 * figures.doubtful_share, "% of the time", 1);
  table.add("lost_percent", "LOST", 100.0 * figures.lost_share, "% of the time", 1);
  if (!arguments_.out.empty()) table.add_row("trajectory", arguments_.out);
  table.print(context_);
  return kExitDone;
}

ExitCode LiveLocalizing::run() {
  const Outputs outputs = outputs_of(arguments_, context_);
  outputs.check();
  const LocalizationMap map = read_known_map(arguments_.map, context_.memory(), context_.threads());
  const HeldInterrupt held(kDriveEnds);
  const std::optional<RobotModel> robot = drive_.wait_for_robot();
  if (!robot) return kExitInterrupted;
  outputs.prepare();
  localizer_ =
      std::make_unique<Localizer>(map, *robot, options_, initial_, kSeed, context_.threads());
  watch_it(*robot, map);
  drive(*robot);
  if (drive_.scans() == 0) throw DataError({drive_.name()}, "no scan of a laser came");
  LocalizationResult result = localizer_->finish();
  for (const std::string& warning : drive_.log().warnings()) result.warnings.push_back(warning);
  if (!arguments_.out.empty()) (void)write_localization_trajectory(result, arguments_.out);
  return tell_result(result);
}

}  // namespace

ExitCode localize_live(const LiveArguments& arguments, const AppContext& context) {
  return LiveLocalizing(arguments, context).run();
}

}  // namespace loopstone::app
