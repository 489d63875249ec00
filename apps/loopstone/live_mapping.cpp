#include <fmt/format.h>

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>

#include "interrupt.hpp"
#include "live_arguments.hpp"
#include "live_outlets.hpp"
#include "live_sources.hpp"
#include "live_view.hpp"
#include "log_run.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/formats/robot_file.hpp"
#include "loopstone/formats/session_file.hpp"
#include "loopstone/live/live_log.hpp"
#include "loopstone/live/map_feed.hpp"
#include "loopstone/report/map_outputs.hpp"
#include "loopstone/report/peak_memory.hpp"
#include "loopstone/slam/checkpoint.hpp"
#include "loopstone/slam/mapper.hpp"
#include "loopstone/version.hpp"
#include "map_pipeline.hpp"
#include "map_text.hpp"
#include "output_path.hpp"
#include "progress_display.hpp"
#include "session_folder.hpp"

namespace loopstone::app {

namespace {

using Clock = std::chrono::steady_clock;

constexpr const char* kDriveEnds =
    "the drive ends: finishing the map; once more writes what there is";
constexpr const char* kFinishEnds =
    "writing what there is; once more ends it at once, without results";

MapOptions options_of(const LiveArguments& arguments, const AppContext& context) {
  auto options = context.load_options<MapOptions>();
  options.map.most_cells = most_cells(context);
  if (arguments.odometry) options.front_end.odometry = *arguments.odometry;
  return options;
}

Outputs outputs_of(const LiveArguments& arguments, const AppContext& context) {
  Outputs outputs(context, arguments.force);
  if (!arguments.from.empty()) outputs.reads(state_path(arguments.from));
  outputs.add_folder("-o", arguments.out);
  if (!arguments.record.empty()) outputs.add_file("--record", arguments.record);
  if (!arguments.poses.empty()) outputs.add_file("--poses", arguments.poses);
  return outputs;
}

/// One drive, from the first message of its sources to the finished map.
class LiveMapping {
 public:
  LiveMapping(const LiveArguments& arguments, const AppContext& context)
      : arguments_(arguments),
        context_(context),
        options_(options_of(arguments, context)),
        terms_{.version = std::string(kVersion),
               .options_toml = options_to_toml(list_options(options_))},
        print_problem_(context),
        log_(live_sources(arguments), log_options()) {}

  [[nodiscard]] ExitCode run();

 private:
  [[nodiscard]] LiveLogOptions log_options();
  void tell(const LiveNews& news);
  void watch_it(const RobotModel& robot);
  void begin(const RobotModel& robot);
  void drive(const RobotModel& robot);
  void take_updates(PoseLines& poses);
  [[nodiscard]] Checkpoint::How checkpoints() const;
  [[nodiscard]] MapResult finish();
  [[nodiscard]] RunInfo info_of(const LogSummary& judged) const;
  void write(const MapResult& result, RunInfo& info);

  const LiveArguments& arguments_;
  const AppContext& context_;
  const Clock::time_point started_ = Clock::now();
  MapOptions options_;
  SessionTerms terms_;
  ProblemPrinter print_problem_;
  LiveLog log_;
  ProgressDisplay display_{context_};
  std::optional<CutLog> drive_{};
  std::optional<MapperState> before_{};  ///< the state of the map that is gone on with
  std::unique_ptr<LiveView> view_{};
  std::unique_ptr<MapFeed> feed_{};  ///< who looks on, if anybody
  std::unique_ptr<Mapper> mapper_{};
  std::optional<MapperState> kept_{};
};

LiveLogOptions LiveMapping::log_options() {
  LiveLogOptions options{.reading = app::log_options(arguments_.reading, context_, &print_problem_),
                         .on_news = [this](const LiveNews& news) { tell(news); },
                         .idle =
                             [this] {
                               if (feed_ && mapper_) feed_->catch_up(*mapper_);
                             }};
  if (arguments_.end_after_s > 0.0) options.end_after_s = arguments_.end_after_s;
  return options;
}

void LiveMapping::tell(const LiveNews& news) {
  const std::string text = news.source + ": " + news.text;
  if (news.is_trouble) {
    context_.warn(text);
  } else {
    context_.note(text);
  }
  if (feed_) feed_->add_warning(text);
}

void LiveMapping::watch_it(const RobotModel& robot) {
  if (arguments_.no_view) return;
  view_ = std::make_unique<LiveView>(
      arguments_.view, ViewAbout{.name = names_of_sources(arguments_), .mode = "mapping"});
  feed_ = std::make_unique<MapFeed>(view_->board(), robot, options_.map);
  view_->open(context_);
}

void LiveMapping::begin(const RobotModel& robot) {
  terms_.robot_toml = robot_to_toml(robot);
  terms_.robot_toml = robot_to_toml(robot);
  mapper_ = std::make_unique<Mapper>(robot, options_, context_.threads());
  if (before_) continue_from(arguments_.from, std::move(*before_), *mapper_, context_);
}

/// Into the folder of the results: what the run has led to, in case it does not come to its end.
Checkpoint::How LiveMapping::checkpoints() const {
  if (!(arguments_.checkpoint_s > 0.0)) return {};
  return {.every_s = arguments_.checkpoint_s,
          .write = [path = state_path(arguments_.out)](
                       const Session& session) { return write_session(path, session); },
          .failed =
              [this](const std::string& reason) {
                context_.warn("the state could not be saved, the run goes on: " + reason);
              },
          .cpu_seconds = cpu_seconds};
}

void LiveMapping::take_updates(PoseLines& poses) {
  while (const auto update = mapper_->next_update()) {
    if (feed_) feed_->add(*update, *mapper_);
    poses.tell(*update);
  }
}

void LiveMapping::drive(const RobotModel& robot) {
  PoseLines poses(arguments_.poses, context_);
  LiveRecorder recorder(arguments_.record, robot, context_);
  Checkpoint checkpoint(checkpoints(), terms_);
  drive_.emplace(log_, LogCut{}, !context_.robot_given(), "mapping live", display_);
  while (const auto message = drive_->next()) {
    recorder.add(*message);
    if (feed_) feed_->add(*message);
    const auto start = Clock::now();
    mapper_->add(*message);
    if (feed_) feed_->note_front_end(std::chrono::duration<double>(Clock::now() - start).count());
    take_updates(poses);
    checkpoint.after(*message, *mapper_);
  }
  checkpoint.after_last(*mapper_);
  recorder.finish();
  ProgressDisplay::clear_line();
}

MapResult LiveMapping::finish() {
  kept_ = mapper_->save_state().get();
  Calibration found;
  if (arguments_.from.empty()) found = mapper_->judge_robot();
  if (feed_) feed_->end(*mapper_);
  MapResult result = mapper_->finish([](const Progress&) { return !interrupted(); });
  if (found.map_is_bent()) {
    result.warnings.emplace_back(
        arguments_.record.empty()
            ? "the map is bent by what the laser's beams are not told of; made from a log "
              "(--record) it would be right"
            : "the map is bent by what the laser's beams are not told of: `loopstone map " +
                  arguments_.record + "` makes it anew");
  }
  return result;
}

RunInfo LiveMapping::info_of(const LogSummary& judged) const {
  // The folder holds the checkpoints of this run, if nothing else.
  constexpr bool kMayOverwrite = true;
  RunInfo info = run_info(names_of_sources(arguments_), judged.left_out, kMayOverwrite, context_);
  info.log_warnings = warnings_of(judged);
  info.options_toml = terms_.options_toml;
  info.wall_time_s = std::chrono::duration<double>(Clock::now() - started_).count();
  return info;
}

void LiveMapping::write(const MapResult& result, RunInfo& info) {
  write_map_outputs(result, info, arguments_.out, {});
  if (result.complete)
    write_session(state_path(arguments_.out), {.terms = terms_, .mapper = std::move(*kept_)});
  info.peak_memory_bytes = peak_memory_bytes();
}

ExitCode LiveMapping::run() {
  const Outputs outputs = outputs_of(arguments_, context_);
  outputs.check();
  if (!arguments_.from.empty()) before_ = read_state(arguments_.from, terms_, context_);
  const HeldInterrupt held(kDriveEnds);
  context_.note("waiting for " + names_of_sources(arguments_));
  if (!log_.wait_for_sources()) {
    context_.warn("nothing came, and nothing was written");
    return kExitInterrupted;
  }
  tell_choices(log_, context_);
  const RobotModel robot = robot_of(log_, context_);
  outputs.prepare();
  watch_it(robot);
  begin(robot);
  drive(robot);
  answer_interrupt(kFinishEnds);
  if (drive_->scans() == 0)
    throw DataError({names_of_sources(arguments_)}, "no scan of a laser came; nothing was mapped");
  const LogSummary judged = drive_->judge(names_of_sources(arguments_));
  MapResult result = finish();
  for (const std::string& warning : warnings_of(judged)) result.warnings.push_back(warning);
  judge_left_out(result.verdict, judged.left_out.share());
  if (feed_) feed_->finish(result);
  RunInfo info = info_of(judged);
  write(result, info);
  return tell_map(result, {}, info, {.out = arguments_.out}, context_);
}

}  // namespace

ExitCode map_live(const LiveArguments& arguments, const AppContext& context) {
  return LiveMapping(arguments, context).run();
}

}  // namespace loopstone::app
