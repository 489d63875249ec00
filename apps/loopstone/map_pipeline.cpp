#include "map_pipeline.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <utility>

#include "loopstone/base/error.hpp"
#include "loopstone/formats/options_file.hpp"
#include "loopstone/sensor/messages.hpp"
#include "loopstone/slam/mapper.hpp"

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

/// Everything that `map` does beside mapping, where it belongs.
class Companions final : public MappingWatch {
 public:
  Companions(MapPipeline::Source source, const std::optional<LandmarkMappingOptions>& landmarks,
             std::optional<ReflectorMapper>& reflectors, std::optional<HeldInterrupt>& held,
             std::optional<MapperState>& kept, const AppContext& context)
      : source_(std::move(source)),
        landmarks_(landmarks),
        reflectors_(reflectors),
        held_(held),
        kept_(kept),
        context_(context) {}

  void begin(Mapper& mapper, const RobotModel& robot, bool anew) override {
    if (landmarks_) mapper.set_graph_addition(reflectors_.emplace(*landmarks_).addition());
    is_first_ = !anew;
    if (anew) {
      source_.recording.begin_anew(robot);
      if (source_.feed != nullptr) source_.feed->begin_anew(robot);
      return;
    }
    if (source_.resumes) {
      resume_from(source_.out, source_.checkpoint, mapper, source_.log, source_.camera, context_);
    }
    if (source_.begins_with)
      continue_from(source_.continues, std::move(*source_.begins_with), mapper, context_);
    held_.emplace();
  }

  void add(const SensorMessage& message, Mapper& mapper) override {
    std::optional<Pace>& pace = source_.pace;
    if (is_first_) {
      if (pace) pace->wait_for(stamp_of(message), [] { return !interrupted(); });
      source_.camera.take(message);
      if (pace && std::holds_alternative<LaserScan>(message)) pace->note_scan();
    }
    source_.recording.add(message);
    add_watched(message, source_.feed, mapper);
  }

  void take(const MapUpdate& update, Mapper& mapper) override {
    if (is_first_ && source_.pace) source_.pace->note_pose();
    source_.recording.add(update, mapper);
    if (source_.feed != nullptr) source_.feed->add(update, mapper);
  }

  void after(const SensorMessage& message, Mapper& mapper) override {
    if (is_first_) source_.checkpoint.after(message, mapper);
  }

  void end(Mapper& mapper) override {
    if (std::exchange(is_first_, false)) source_.checkpoint.after_last(mapper);
    if (source_.keeps_state) kept_ = mapper.save_state().get();
  }
  void finishing(Mapper& mapper) override {
    if (source_.feed != nullptr) source_.feed->end(mapper);
  }
  bool goes_on(const Progress& /*progress*/) override { return !interrupted(); }
  [[nodiscard]] bool is_stopped() const override { return interrupted(); }

 private:
  MapPipeline::Source source_;
  const std::optional<LandmarkMappingOptions>& landmarks_;
  std::optional<ReflectorMapper>& reflectors_;
  std::optional<HeldInterrupt>& held_;
  std::optional<MapperState>& kept_;
  const AppContext& context_;
  bool is_first_ = true;  ///< reading of the log: paced, saved, and looked through for pictures
};

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
  // Beams of another drive can't be made anew.
  const bool continues = source.begins_with.has_value();
  CutLog& log = source.log;
  watch_ = std::make_unique<Companions>(std::move(source), landmarks_, reflectors_, held, kept,
                                        context_);
  mapping_.emplace(robot, std::get<MapOptions>(options_), threads, *watch_);
  return mapping_->map([&log] { return log.next(); }, !continues);
}

MapResult MapPipeline::map_anew(CutLog& log) {
  return mapping_->map_anew([&log] { return log.next(); });
}

std::optional<LandmarkMapping> MapPipeline::landmarks_of(MapResult& result,
                                                         std::string& failure) const {
  if (!reflectors_) return {};
  MapLandmarks found = loopstone::landmarks_of(*reflectors_, result);
  if (!found.failure.empty()) failure += (failure.empty() ? "" : "; ") + found.failure;
  if (!found.warning.empty()) result.warnings.push_back(found.warning);
  return std::move(found.mapping);
}

}  // namespace loopstone::app
