#include <fmt/format.h>

#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "initial_pose.hpp"
#include "interrupt.hpp"
#include "known_map.hpp"
#include "live_arguments.hpp"
#include "live_outlets.hpp"
#include "live_sources.hpp"
#include "live_view.hpp"
#include "log_run.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/live/live_log.hpp"
#include "loopstone/live/localization_feed.hpp"
#include "loopstone/localization/localizer.hpp"
#include "loopstone/report/localization_figures.hpp"
#include "loopstone/report/localization_outputs.hpp"
#include "output_path.hpp"
#include "progress_display.hpp"
#include "result.hpp"

namespace loopstone::app {

namespace {

namespace fs = std::filesystem;

constexpr const char* kDriveEnds = "the drive ends";
constexpr std::uint64_t kSeed = 1;

Outputs outputs_of(const LiveArguments& arguments, const AppContext& context) {
  Outputs outputs(context, arguments.force);
  outputs.reads(arguments.map);
  outputs.reads(map_yaml_of(arguments.map));
  if (!arguments.out.empty()) {
    const fs::path file(arguments.out);
    if (file.extension() == ".csv")
      throw UsageError("-o " + arguments.out +
                       ": the table beside the trajectory takes that name; name this one .tum");
    outputs.add_file("-o", arguments.out);
    if (!is_stream(arguments.out)) outputs.add_file("", fs::path(file).replace_extension(".csv"));
  }
  if (!arguments.record.empty()) outputs.add_file("--record", arguments.record);
  if (!arguments.poses.empty()) outputs.add_file("--poses", arguments.poses);
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
        print_problem_(context),
        log_(live_sources(arguments), log_options()) {}

  [[nodiscard]] ExitCode run();

 private:
  [[nodiscard]] LiveLogOptions log_options();
  void tell(const LiveNews& news);
  void watch_it(const RobotModel& robot, const LocalizationMap& map);
  void drive(const RobotModel& robot);
  [[nodiscard]] ExitCode tell_result(const LocalizationResult& result);

  const LiveArguments& arguments_;
  const AppContext& context_;
  std::optional<InitialPose> initial_;
  LocalizationOptions options_;
  ProblemPrinter print_problem_;
  LiveLog log_;
  ProgressDisplay display_{context_};
  std::optional<CutLog> drive_{};
  std::unique_ptr<LiveView> view_{};
  std::unique_ptr<LocalizationFeed> feed_{};  ///< who looks on, if anybody
  std::unique_ptr<Localizer> localizer_{};
};

LiveLogOptions LiveLocalizing::log_options() {
  LiveLogOptions options{.reading = app::log_options(arguments_.reading, context_, &print_problem_),
                         .on_news = [this](const LiveNews& news) { tell(news); },
                         .idle =
                             [this] {
                               if (feed_ && localizer_) feed_->catch_up(*localizer_);
                             }};
  if (arguments_.end_after_s > 0.0) options.end_after_s = arguments_.end_after_s;
  return options;
}

void LiveLocalizing::tell(const LiveNews& news) {
  const std::string text = news.source + ": " + news.text;
  if (news.is_trouble) {
    context_.warn(text);
  } else {
    context_.note(text);
  }
  if (feed_) feed_->add_warning(text);
}

void LiveLocalizing::watch_it(const RobotModel& robot, const LocalizationMap& map) {
  if (arguments_.no_view) return;
  view_ = std::make_unique<LiveView>(
      arguments_.view, ViewAbout{.name = names_of_sources(arguments_), .mode = "localizing"});
  feed_ = std::make_unique<LocalizationFeed>(view_->board(), robot, map);
  view_->open(context_);
}

void LiveLocalizing::drive(const RobotModel& robot) {
  PoseLines poses(arguments_.poses, context_);
  LiveRecorder recorder(arguments_.record, robot, context_);
  drive_.emplace(log_, LogCut{}, !context_.robot_given(), "localising live", display_);
  while (const auto message = drive_->next()) {
    recorder.add(*message);
    if (feed_) feed_->add(*message);
    localizer_->add(*message);
    while (const auto estimate = localizer_->next_update()) {
      if (feed_) feed_->add(*estimate, *localizer_);
      poses.tell(*estimate);
    }
  }
  recorder.finish();
  ProgressDisplay::clear_line();
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
  const LocalizationMap map = read_known_map(arguments_.map, context_.memory());
  const HeldInterrupt held(kDriveEnds);
  context_.note("waiting for " + names_of_sources(arguments_));
  if (!log_.wait_for_sources()) {
    context_.warn("nothing came, and nothing was written");
    return kExitInterrupted;
  }
  tell_choices(log_, context_);
  const RobotModel robot = robot_of(log_, context_);
  outputs.prepare();
  watch_it(robot, map);
  localizer_ =
      std::make_unique<Localizer>(map, robot, options_, initial_, kSeed, context_.threads());
  drive(robot);
  if (drive_->scans() == 0)
    throw DataError({names_of_sources(arguments_)}, "no scan of a laser came");
  LocalizationResult result = localizer_->finish();
  for (const std::string& warning : log_.warnings()) result.warnings.push_back(warning);
  if (!arguments_.out.empty()) (void)write_localization_trajectory(result, arguments_.out);
  return tell_result(result);
}

}  // namespace

ExitCode localize_live(const LiveArguments& arguments, const AppContext& context) {
  return LiveLocalizing(arguments, context).run();
}

}  // namespace loopstone::app
