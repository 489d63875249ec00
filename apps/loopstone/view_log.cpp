#include "view_log.hpp"

#include <memory>
#include <optional>
#include <utility>
#include <variant>

#include "interrupt.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/live/map_feed.hpp"
#include "loopstone/live/replay_clock.hpp"
#include "loopstone/pipeline/log_mapping.hpp"
#include "loopstone/slam/mapper.hpp"
#include "loopstone/slam/robot_correction.hpp"
#include "map_pipeline.hpp"
#include "output_path.hpp"
#include "progress_display.hpp"

namespace loopstone::app {

namespace {

using Turn = ReplayClock::Turn;

bool go_on() { return !interrupted(); }

/// A log that can be read again and again.
class Recording {
 public:
  Recording(const ViewRequest& request, const AppContext& context)
      : request_(request), context_(context), print_problem_(context) {}

  /// From its beginning.
  /// \param is_shown  how far it is, on the terminal: not of what goes at a client's pace
  void rewind(std::string_view step, bool is_shown, ProblemPrinter* printer = nullptr) {
    log_.reset();
    display_.emplace(context_, is_shown);
    const LogSource source =
        source_of(request_.what, log_options(request_.reading, context_, printer), context_);
    reader_ = source.open_ahead(context_.threads());
    log_.emplace(*reader_, request_.cut, source.mounts_from_log(), step, watch_by(*display_));
  }
  [[nodiscard]] CutLog& log() { return *log_; }
  [[nodiscard]] RobotModel robot() const { return robot_of(*reader_, context_); }

  /// Reads it all: when its scans begin and end, and what is wrong with it. Nothing when the user
  /// interrupted.
  [[nodiscard]] std::optional<PlaybackRange> survey() {
    rewind("reading", true, &print_problem_);
    tell_choices(*reader_, context_);
    std::optional<PlaybackRange> range;
    while (const auto message = log_->next()) {
      const auto* scan = std::get_if<LaserScan>(&*message);
      if (scan == nullptr) continue;
      if (!range) range = PlaybackRange{scan->stamp, scan->stamp};
      range->start = std::min(range->start, scan->stamp);
      range->end = std::max(range->end, scan->stamp);
    }
    ProgressDisplay::clear_line();
    summary_ = log_->judge(request_.what);
    if (log_->interrupted()) return {};
    return range;
  }
  [[nodiscard]] const LogSummary& summary() const { return summary_; }

 private:
  const ViewRequest& request_;
  const AppContext& context_;
  std::optional<ProgressDisplay> display_{};
  ProblemPrinter print_problem_;
  std::unique_ptr<LogReader> reader_{};
  std::optional<CutLog> log_{};
  LogSummary summary_{};
};

MapOptions options_for(const AppContext& context) {
  auto options = context.load_options<MapOptions>();
  options.map.most_cells = most_cells(context);
  return options;
}

/// One log, mapped as often as clients want to go back in it.
class LogReplay {
 public:
  LogReplay(Recording& recording, const MapOptions& options, ReplayClock& clock, MapFeed& feed,
            const RobotModel& robot, const AppContext& context)
      : recording_(recording),
        options_(options),
        clock_(clock),
        feed_(feed),
        given_(robot),
        robot_(robot),
        threads_(context.threads()) {}

  /// Until the user has seen enough.
  void run() {
    for (Turn turn = Turn::kSeekBack; turn == Turn::kSeekBack;) {
      turn = map_once();
      if (turn == Turn::kGoOn) turn = clock_.wait_at_end(go_on);
    }
  }

 private:
  /// kGoOn when the map is finished.
  Turn map_once() {
    recording_.rewind("mapping", false);
    // What the drive has told of the laser it need not tell again.
    feed_.begin_anew(robot_);
    auto mapper = std::make_unique<Mapper>(robot_, options_, threads_);
    const Turn turn = feed(*mapper, true);
    if (turn != Turn::kGoOn) return turn;
    const int most = is_corrected_ ? 0 : kMostMadeAnew;
    Calibration found;
    for (int anew = 0; anew < most; ++anew) {
      const Calibration newest = mapper->judge_robot();
      if (!newest.map_is_bent()) break;
      is_corrected_ = true;
      found = beside(found, newest);
      robot_ = corrected_robot(given_, found);
      recording_.rewind("mapping anew", true);
      feed_.begin_anew(robot_);
      mapper = std::make_unique<Mapper>(robot_, options_, threads_);
      if (feed(*mapper, false) == Turn::kStopped) return Turn::kStopped;
    }
    finish(*mapper);
    return interrupted() ? Turn::kStopped : Turn::kGoOn;
  }

  void finish(Mapper& mapper) {
    feed_.end(mapper);
    MapResult result = mapper.finish([](const Progress&) { return !interrupted(); });
    if (interrupted()) return;
    while (const auto update = mapper.next_update()) feed_.add(*update, mapper);
    judge_by_log(recording_.summary(), {}, result);
    feed_.finish(result);
  }

  /// \param paced  as the clock says, else as fast as it goes
  Turn feed(Mapper& mapper, bool paced) {
    const auto goes_on = [&] {
      feed_.catch_up(mapper);
      return go_on();
    };
    while (const auto message = recording_.log().next()) {
      if (const auto* scan = std::get_if<LaserScan>(&*message); scan != nullptr && paced) {
        const Turn turn = clock_.wait_for(scan->stamp, goes_on);
        if (turn != Turn::kGoOn) return turn;
      }
      add_watched(*message, &feed_, mapper);
      while (const auto update = mapper.next_update()) feed_.add(*update, mapper);
    }
    return interrupted() ? Turn::kStopped : Turn::kGoOn;
  }

  Recording& recording_;
  const MapOptions& options_;
  ReplayClock& clock_;
  MapFeed& feed_;
  RobotModel given_;
  RobotModel robot_;
  Threads threads_;
  bool is_corrected_ = false;
};

}  // namespace

ExitCode view_log(const ViewRequest& request, const AppContext& context) {
  if (!request.log.empty())
    throw UsageError("--log names the scans of a finished map; " + request.what + " is none");
  if (request.edit || !request.edits.empty())
    throw UsageError("--edit: a finished map can be edited, a log can't; `loopstone map " +
                     request.what + " -o out --keep-state` makes one");
  if (is_stream(request.what))
    throw UsageError(request.what +
                     ": a pipe can be read once only, and a view goes back in it; write it into a "
                     "file first");
  const MapOptions options = options_for(context);
  const HeldInterrupt held(kViewEnds);
  Recording recording(request, context);
  const auto range = recording.survey();
  if (!range) return kExitDone;
  const RobotModel robot = recording.robot();

  LiveView view(request.view, {short_name(request.what), "replay", range});
  ReplayClock clock(*range, request.speed,
                    [&](const PlaybackState& state) { view.server().set_playback(state); });
  view.server().on_playback([&](const PlaybackControl& control) { clock.control(control); });
  MapFeed feed(view.board(), robot, options.map);
  const ClosesFirst closes_first(view);
  view.open(context);
  tell_address(view, context);
  try {
    LogReplay(recording, options, clock, feed, robot, context).run();
  } catch (const ReadingStopped&) {
    // By Ctrl-C, while the log was opened again.
  }
  return kExitDone;
}

}  // namespace loopstone::app
