#include "map_pipeline.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdint>

#include "loopstone/base/error.hpp"
#include "loopstone/formats/options_file.hpp"
#include "loopstone/sensor/messages.hpp"
#include "loopstone/slam/mapper.hpp"
#include "loopstone/slam/robot_correction.hpp"

namespace loopstone::app {

namespace {

void refuse_flags_of_submaps(const MapArguments& arguments) {
  if (arguments.realtime > 0.0) {
    throw UsageError(
        "--realtime: the textbook pipeline works when the log is over; leave out --pipeline");
  }
  if (arguments.checkpoint.any()) {
    throw UsageError("--checkpoint, --resume: the textbook pipeline can't go on from a session");
  }
  if (arguments.drives.any()) {
    throw UsageError("--keep-state, --continue: the textbook pipeline can't go on with a map");
  }
  if (arguments.odometry) {
    throw UsageError("--odometry says how submaps use it; --pipeline scan_to_scan always does");
  }
  if (arguments.no_calibration) {
    throw UsageError("--no-calibration: the textbook pipeline does none; leave out --pipeline");
  }
  if (arguments.landmarks.on) {
    throw UsageError(
        "--landmarks: the textbook pipeline has no place for them; leave out --pipeline");
  }
  if (!arguments.mcap.empty()) {
    throw UsageError(
        "--mcap shows a map that grows with its submaps; the textbook pipeline has none: leave out "
        "--pipeline");
  }
  if (arguments.view) {
    throw UsageError(
        "--view shows a map that grows with its submaps; the textbook pipeline has none: leave out "
        "--pipeline");
  }
}

void feed(const MapPipeline::Source& source, ScanToScanMapper& mapper) {
  while (const auto message = source.log.next()) {
    source.camera.take(*message);
    mapper.add(*message);
  }
}

void feed(const MapPipeline::Source& source, Mapper& mapper) {
  std::optional<Pace>& pace = source.pace;
  while (const auto message = source.log.next()) {
    if (pace) pace->wait_for(stamp_of(*message), [] { return !interrupted(); });
    source.camera.take(*message);
    if (pace && std::holds_alternative<LaserScan>(*message)) pace->note_scan();
    source.recording.add(*message);
    add_watched(*message, source.feed, mapper);
    while (const auto update = mapper.next_update()) {
      if (pace) pace->note_pose();
      source.recording.add(*update, mapper);
      if (source.feed != nullptr) source.feed->add(*update, mapper);
    }
    source.checkpoint.after(*message, mapper);
  }
  source.checkpoint.after_last(mapper);
}

}  // namespace

void add_watched(const SensorMessage& message, MapFeed* feed, Mapper& mapper) {
  if (feed == nullptr) return mapper.add(message);
  feed->add(message);
  const auto start = std::chrono::steady_clock::now();
  mapper.add(message);
  feed->note_front_end(
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
}

std::uint64_t most_cells(const AppContext& context) {
  // A cell takes five bytes, and as many again in what is made of it for the files.
  constexpr std::uint64_t kBytesPerCell = 10;
  return std::min(OccupancyOptions{}.most_cells, context.memory().ceiling_bytes / kBytesPerCell);
}

MapPipeline::MapPipeline(const MapArguments& arguments, const AppContext& context)
    : context_(context) {
  if (!arguments.view && arguments.view_flags != ViewFlags{})
    throw UsageError("--port, --listen, --token, --origin and --no-open are of --view");
  if (arguments.pipeline == Pipeline::kScanToScan) {
    refuse_flags_of_submaps(arguments);
    auto options = context.load_options<ScanToScanOptions>();
    options.map.most_cells = most_cells(context);
    options_ = options;
    return;
  }
  if (!arguments.mcap.empty() && arguments.checkpoint.resume) {
    throw UsageError(
        "--mcap records a run from its beginning, and --resume goes on in its midst: leave out one "
        "of them");
  }
  if (!arguments.drives.from.empty() && (arguments.checkpoint.any() || !arguments.mcap.empty())) {
    throw UsageError(
        "--continue: --checkpoint, --resume and --mcap are of runs with one drive; leave them out");
  }
  if (!arguments.landmarks.on && (arguments.landmarks.nameless || arguments.landmarks.brightness))
    throw UsageError("--nameless and --reflector-threshold need --landmarks");
  if (arguments.landmarks.nameless) {
    throw UsageError("--nameless: reflectors have no names to leave out; it is for MRCLAM's logs");
  }
  if (arguments.landmarks.on && arguments.checkpoint.any()) {
    throw UsageError(
        "--landmarks: a session does not keep how bright beams were, by which reflectors are told; "
        "leave out --checkpoint and --resume");
  }
  if (arguments.landmarks.on && arguments.drives.any()) {
    throw UsageError(
        "--landmarks: a state does not keep how bright beams were, by which reflectors are told; "
        "leave out --keep-state and --continue");
  }
  MapOptions options;
  if (arguments.landmarks.on) {
    auto both = landmark_map_options(arguments.landmarks, context);
    options = both.map;
    landmarks_ = both.landmarks;
  } else {
    options = context.load_options<MapOptions>();
  }
  options.map.most_cells = most_cells(context);
  if (arguments.no_loop_closure) options.loop_closure = false;
  if (arguments.no_calibration) options.calibration = false;
  if (arguments.odometry) options.front_end.odometry = *arguments.odometry;
  options_ = options;
}

LandmarkMapOptions landmark_map_options(const LandmarkMapFlags& flags, const AppContext& context) {
  auto options = context.load_options<LandmarkMapOptions>();
  std::vector<OptionProblem> problems;
  if (flags.brightness) {
    override_option(list_options(options), "--reflector-threshold",
                    fmt::format("landmarks.reflectors.brightness={}", *flags.brightness), problems);
  }
  if (!problems.empty()) throw OptionsError(problems);
  return options;
}

std::string MapPipeline::options_toml() {
  if (landmarks_) {
    LandmarkMapOptions both{std::get<MapOptions>(options_), *landmarks_};
    return options_to_toml(list_options(both));
  }
  return std::visit([](auto& options) { return options_to_toml(list_options(options)); }, options_);
}

TextureOptions MapPipeline::texture() const {
  const auto* options = std::get_if<MapOptions>(&options_);
  return options == nullptr ? TextureOptions{} : options->texture;
}

const OccupancyOptions& MapPipeline::map_options() const {
  return std::visit([](const auto& options) -> const OccupancyOptions& { return options.map; },
                    options_);
}

MapResult MapPipeline::map(Source source, const RobotModel& robot, Threads threads,
                           std::optional<HeldInterrupt>& held, std::optional<MapperState>& kept) {
  if (const auto* options = std::get_if<ScanToScanOptions>(&options_)) {
    held.emplace();
    ScanToScanMapper mapper(robot, *options, threads);
    feed(source, mapper);
    return mapper.finish(source.display.callback());
  }
  Mapper mapper(robot, std::get<MapOptions>(options_), threads);
  if (landmarks_) mapper.set_graph_addition(reflectors_.emplace(*landmarks_).addition());
  if (source.resumes)
    resume_from(source.out, source.checkpoint, mapper, source.log, source.camera, context_);
  const bool continues = source.begins_with.has_value();
  if (continues) continue_from(source.continues, std::move(*source.begins_with), mapper, context_);
  held.emplace();
  feed(source, mapper);
  if (source.keeps_state) kept = mapper.save_state().get();
  Calibration found;
  // Beams of another drive are not made anew.
  if (!continues && !source.log.interrupted() && !interrupted()) found = mapper.judge_robot();
  if (source.feed != nullptr) source.feed->end(mapper);
  MapResult result;
  // Who interrupts a run wants what there is.
  if (found.map_is_bent() && !interrupted()) {
    result.calibration = found;
  } else {
    result = mapper.finish([](const Progress&) { return !interrupted(); });
  }
  while (const auto update = mapper.next_update()) {
    source.recording.add(*update, mapper);
    if (source.feed != nullptr) source.feed->add(*update, mapper);
  }
  return result;
}

MapResult MapPipeline::map_anew(CutLog& log, RunRecording& recording, MapFeed* feed,
                                const RobotModel& robot, const Calibration& found, Threads threads,
                                std::optional<MapperState>& kept) {
  const RobotModel& corrected = corrected_.emplace(corrected_robot(robot, found));
  recording.begin_anew(corrected);
  if (feed != nullptr) feed->begin_anew(corrected);
  Mapper mapper(corrected, std::get<MapOptions>(options_), threads);
  if (landmarks_) mapper.set_graph_addition(reflectors_.emplace(*landmarks_).addition());
  const auto record_updates = [&] {
    while (const auto update = mapper.next_update()) {
      recording.add(*update, mapper);
      if (feed != nullptr) feed->add(*update, mapper);
    }
  };
  while (const auto message = log.next()) {
    recording.add(*message);
    add_watched(*message, feed, mapper);
    record_updates();
  }
  if (kept) kept = mapper.save_state().get();
  if (feed != nullptr) feed->end(mapper);
  MapResult result = mapper.finish([](const Progress&) { return !interrupted(); });
  record_updates();
  result.complete = result.complete && !log.interrupted();
  corrections_ = tell_of_correction(found, result);
  return result;
}

std::optional<LandmarkMapping> MapPipeline::landmarks_of(MapResult& result,
                                                         std::string& failure) const {
  if (!reflectors_) return {};
  LandmarkMapping mapping = reflectors_->settle(result);
  if (!result.complete) return mapping;
  const auto fail = [&](const char* why) {
    failure += (failure.empty() ? "" : "; ") + std::string(why);
  };
  if (reflectors_->scans_with_intensities() == 0) {
    fail(
        "no landmarks: the scans have no intensities, by which reflectors are told; MCAP, ROS 1 "
        "bags and rosbag2 hold them where the driver tells them");
  } else if (mapping.figures.observations == 0) {
    fail(
        "no landmarks: no beam is bright enough to be one on a reflector; a lower "
        "--reflector-threshold takes fainter ones");
  } else if (mapping.landmarks.empty()) {
    result.warnings.emplace_back(
        "no landmarks: nothing bright was seen often enough, from places far enough apart; see "
        "landmarks.sightings_min and landmarks.baseline_min_m");
  }
  return mapping;
}

}  // namespace loopstone::app
