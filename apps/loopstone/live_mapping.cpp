#include <fmt/format.h>

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>

#include "interrupt.hpp"
#include "live_arguments.hpp"
#include "live_drive.hpp"
#include "live_outlets.hpp"
#include "live_view.hpp"
#include "log_run.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/formats/robot_file.hpp"
#include "loopstone/formats/session_file.hpp"
#include "loopstone/live/map_feed.hpp"
#include "loopstone/report/map_outputs.hpp"
#include "loopstone/report/peak_memory.hpp"
#include "loopstone/slam/checkpoint.hpp"
#include "loopstone/slam/mapper.hpp"
#include "loopstone/version.hpp"
#include "map_pipeline.hpp"
#include "map_text.hpp"
#include "output_path.hpp"
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
  if (!arguments.from.empty()) outputs.reads(kept_state_path(arguments.from));
  outputs.add_folder("-o", arguments.out);
  add_live_outputs(arguments, outputs);
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
        drive_(arguments, "mapping live", context) {}

  [[nodiscard]] ExitCode run();

 private:
  void watch_it(const RobotModel& robot);
  void begin(const RobotModel& robot);
  void drive(const RobotModel& robot);
  [[nodiscard]] Checkpoint::How checkpoints();
  [[nodiscard]] MapResult finish();
  [[nodiscard]] RunInfo info_of(const LogSummary& judged) const;

  const LiveArguments& arguments_;
  const AppContext& context_;
  const Clock::time_point started_ = Clock::now();
  MapOptions options_;
  SessionTerms terms_;
  LiveDrive drive_;
  std::optional<MapperState> before_{};  ///< the state of the map that is gone on with
  std::unique_ptr<LiveView> view_{};
  std::unique_ptr<MapFeed> feed_{};  ///< who looks on, if anybody
  std::unique_ptr<Mapper> mapper_{};
  std::string state_failure_{};  ///< of the last time that it was saved
};

void LiveMapping::watch_it(const RobotModel& robot) {
  view_ = drive_.make_view("mapping");
  if (!view_) return;
  feed_ = std::make_unique<MapFeed>(view_->board(), robot, options_.map);
  view_->open(context_);
}

void LiveMapping::begin(const RobotModel& robot) {
  terms_.robot_toml = robot_to_toml(robot);
  mapper_ = std::make_unique<Mapper>(robot, options_, context_.threads());
  if (before_) continue_from(arguments_.from, std::move(*before_), *mapper_, context_);
  LiveListener* const listener = arguments_.listener;
  if (listener != nullptr) listener->mapping_begins(robot, options_.map);
  drive_.set_watch({.warn =
                        [this](const std::string& text) {
                          if (feed_) feed_->add_warning(text);
                        },
                    .idle =
                        [this, listener] {
                          if (feed_) feed_->catch_up(*mapper_);
                          if (listener != nullptr) listener->catch_up(mapper_.get());
                        }});
}

/// Into the folder of the results: what the run has led to, now and then in case it does not come
/// to its end, and in the end for another day.
Checkpoint::How LiveMapping::checkpoints() {
  return {.every_s = arguments_.checkpoint_s,
          .write =
              [this](const Session& session) {
                const std::int64_t bytes = write_session(kept_state_path(arguments_.out), session);
                state_failure_.clear();
                return bytes;
              },
          .failed =
              [this](const std::string& reason) {
                state_failure_ = "the state could not be saved: " + reason;
                context_.warn(state_failure_ + "; the run goes on");
              },
          .cpu_seconds = cpu_seconds};
}

void LiveMapping::drive(const RobotModel& robot) {
  Checkpoint checkpoint(checkpoints(), terms_);
  drive_.run(robot, [&](const SensorMessage& message, PoseLines& poses) {
    add_watched(message, feed_.get(), *mapper_);
    while (const auto update = mapper_->next_update()) {
      if (feed_) feed_->add(*update, *mapper_);
      if (arguments_.listener != nullptr) arguments_.listener->add(*update, *mapper_);
      poses.tell(*update);
    }
    checkpoint.after(message, *mapper_);
  });
  checkpoint.after_last(*mapper_);
}

MapResult LiveMapping::finish() {
  Calibration found;
  if (arguments_.from.empty()) found = mapper_->judge_robot();
  if (feed_) feed_->end(*mapper_);
  if (arguments_.listener != nullptr) arguments_.listener->end(*mapper_);
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
  RunInfo info = run_info(drive_.name(), judged.left_out, kMayOverwrite, context_);
  info.log_warnings = warnings_of(judged);
  info.options_toml = terms_.options_toml;
  info.failure = state_failure_;
  info.wall_time_s = std::chrono::duration<double>(Clock::now() - started_).count();
  return info;
}

ExitCode LiveMapping::run() {
  const Outputs outputs = outputs_of(arguments_, context_);
  outputs.check();
  if (!arguments_.from.empty()) before_ = read_state(arguments_.from, terms_, context_);
  const HeldInterrupt held(kDriveEnds);
  const std::optional<RobotModel> robot = drive_.wait_for_robot();
  if (!robot) return kExitInterrupted;
  outputs.prepare();
  watch_it(*robot);
  begin(*robot);
  drive(*robot);
  answer_interrupt(kFinishEnds);
  if (drive_.scans() == 0)
    throw DataError({drive_.name()}, "no scan of a laser came; nothing was mapped");
  const LogSummary judged = drive_.judge();
  MapResult result = finish();
  for (const std::string& warning : warnings_of(judged)) result.warnings.push_back(warning);
  judge_left_out(result.verdict, judged.left_out.share());
  if (feed_) feed_->finish(result);
  if (arguments_.listener != nullptr) arguments_.listener->finish(result);
  RunInfo info = info_of(judged);
  write_map_outputs(result, info, arguments_.out, {});
  info.peak_memory_bytes = peak_memory_bytes();
  return tell_map(result, {}, info, {.out = arguments_.out}, context_);
}

}  // namespace

ExitCode map_live(const LiveArguments& arguments, const AppContext& context) {
  return LiveMapping(arguments, context).run();
}

}  // namespace loopstone::app
