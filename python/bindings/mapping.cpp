#include "mapping.hpp"

#include <algorithm>
#include <string>
#include <utility>
#include <variant>

#include "cost.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/base/release_memory.hpp"
#include "loopstone/formats/machine_memory.hpp"
#include "loopstone/formats/options_file.hpp"
#include "loopstone/formats/rgbd_files.hpp"
#include "loopstone/formats/robot_file.hpp"
#include "loopstone/pipeline/log_mapping.hpp"
#include "loopstone/slam/mapper.hpp"
#include "loopstone/version.hpp"

namespace loopstone::python {

namespace {

/// Tells how far a mapping is, and collects what the camera took; goes on with a map, and keeps
/// what it can be gone on from.
class Companion final : public MappingWatch {
 public:
  Companion(Work& work, const MappingPlan& plan)
      : work_(work), plan_(plan), takes_frames_(plan.texture) {}

  void begin(Mapper& mapper, const RobotModel& /*robot*/, bool anew) override {
    if (plan_.landmarks)
      mapper.set_graph_addition(reflectors_.emplace(*plan_.landmarks).addition());
    takes_frames_ = takes_frames_ && !anew;
    if (!plan_.goes_on_with) return;
    try {
      mapper.restore_state(plan_.goes_on_with->mapper);
    } catch (const UsageError& error) {
      throw DataError({plan_.goes_on_from}, std::string("is damaged: ") + error.what());
    }
    mapper.begin_drive();
  }
  void end(Mapper& mapper) override {
    if (plan_.keep_state) kept_ = mapper.save_state().get();
  }
  [[nodiscard]] bool may_begin_anew() const override { return !plan_.goes_on_with; }
  void add(const SensorMessage& message, Mapper& mapper) override {
    if (takes_frames_) {
      if (const auto* frame = std::get_if<RgbdFrame>(&message)) frames_.push_back(*frame);
    }
    mapper.add(message);
  }
  bool goes_on(const Progress& progress) override { return work_.tell(progress); }
  [[nodiscard]] bool is_stopped() const override { return !work_.goes_on(); }
  std::vector<RgbdFrame>& frames() { return frames_; }
  std::optional<MapperState>& kept() { return kept_; }
  /// Of the last mapping; nothing where landmarks are not asked for.
  [[nodiscard]] const std::optional<ReflectorMapper>& reflectors() const { return reflectors_; }

 private:
  Work& work_;
  const MappingPlan& plan_;
  bool takes_frames_;
  std::vector<RgbdFrame> frames_{};
  std::optional<MapperState> kept_{};
  std::optional<ReflectorMapper> reflectors_{};
};

/// What states have in common of which one goes on with the other.
SessionTerms state_terms(const RunInfo& info) {
  return {.version = std::string(kVersion), .options_toml = info.options_toml};
}

void require_same_kind(const MappingPlan& plan, const RunInfo& info) {
  if (!plan.goes_on_with) return;
  SessionTerms then = state_terms(info);
  then.version = plan.goes_on_with->terms.version;
  then.options_toml = plan.goes_on_with->terms.options_toml;
  const std::string differs = difference(then, state_terms(info));
  if (!differs.empty())
    throw DataError({plan.goes_on_from}, "is of another kind of run: " + differs);
}

bool has_pairs(const std::vector<RgbdFrame>& frames) {
  return std::ranges::any_of(frames, [](const RgbdFrame& frame) {
    return !frame.colour_path.empty() && !frame.depth_path.empty();
  });
}

/// The floor in colour, if the log has pictures. A failure leaves all else and is told.
void colour(Mapped& mapped, std::vector<RgbdFrame> frames, const LogReader& reader,
            const RobotModel& robot, bool robot_given, const TextureOptions& options,
            Threads threads, Work& work) {
  MapResult& result = mapped.result;
  // Pictures have the clock of the newest drive, the trajectory the map's.
  if (!has_pairs(frames) || !result.complete || !result.drives.empty()) return;
  if (!robot_given && !reader.camera_fault().empty()) {
    result.warnings.push_back("the floor is not coloured: " + reader.camera_fault() +
                              "; --robot FILE can tell it");
    return;
  }
  try {
    const RgbdLoader loader(robot.camera, reader.pictures());
    const RgbdSource source{std::move(frames),
                            [&](const RgbdFrame& frame) { return loader.load(frame); }};
    mapped.texture = map_floor_texture(source, result.trajectory, robot.camera, options, threads,
                                       work.callback());
    result.complete = mapped.texture->complete;
  } catch (const std::exception& error) {
    mapped.info.failure = std::string("the floor could not be coloured: ") + error.what();
  }
  if (!work.goes_on()) throw CalledOff{};
}

/// What the map has of landmarks, where they were asked for. That the log can't show any leaves all
/// else and is told.
void take_landmarks(const Companion& companion, Mapped& mapped) {
  if (!companion.reflectors()) return;
  MapLandmarks found = landmarks_of(*companion.reflectors(), mapped.result);
  std::string& failure = mapped.info.failure;
  if (!found.failure.empty()) failure += (failure.empty() ? "" : "; ") + found.failure;
  if (!found.warning.empty()) mapped.result.warnings.push_back(found.warning);
  mapped.landmarks = std::move(found.mapping);
}

}  // namespace

ReadingWatch watch_by(Work& work) {
  return {.stop = [&work] { return !work.goes_on(); }, .progress = work.callback()};
}

std::shared_ptr<Mapped> map_log(const Log& log, MapOptions options, const MappingPlan& plan,
                                Work& work) {
  const Cost cost;
  const Threads threads = plan.threads;
  limit_cells(options);
  const ReadingWatch watch = watch_by(work);
  LogSource source = log.source(watch.stop);
  source.how.topics.pictures = plan.texture;
  source.how.intensities = source.how.intensities || plan.landmarks.has_value();
  auto mapped = std::make_shared<Mapped>();
  mapped->info = run_info(options, threads, plan.landmarks);
  require_same_kind(plan, mapped->info);
  const auto reader = source.open_ahead(threads);
  Companion companion(work, plan);
  LogMap made = loopstone::map_log(source, *reader, plan.cut, options, threads, watch, &companion);
  if (!work.goes_on()) throw CalledOff{};

  mapped->info.log_path = log.path;
  mapped->info.left_out = made.log.left_out;
  mapped->info.log_warnings = warnings_of(made.log);
  mapped->info.log_warnings.insert(mapped->info.log_warnings.end(), made.corrections.begin(),
                                   made.corrections.end());
  mapped->result = std::move(made.result);
  mapped->robot = std::move(made.robot);
  if (companion.kept() && mapped->result.complete) {
    SessionTerms terms = state_terms(mapped->info);
    terms.robot_toml = robot_to_toml(mapped->robot);
    mapped->state = std::make_shared<const Session>(
        Session{.terms = std::move(terms), .mapper = std::move(*companion.kept())});
  }
  colour(*mapped, std::move(companion.frames()), *reader, source.robot_of(*reader),
         log.robot.has_value(), options.texture, threads, work);
  take_landmarks(companion, *mapped);
  cost.note(mapped->info);
  return mapped;
}

std::shared_ptr<Mapped> map_messages(const std::vector<SensorMessage>& messages,
                                     const RobotModel& robot, MapOptions options,
                                     const MappingPlan& plan, Work& work) {
  const Cost cost;
  limit_cells(options);
  auto mapped = std::make_shared<Mapped>();
  mapped->info = run_info(options, plan.threads, plan.landmarks);
  mapped->info.log_path = "messages";
  const auto from_beginning = [&messages, &work](const char* step) {
    return [&, step, at = std::size_t{0}, scans = std::int64_t{0}]() mutable {
      std::optional<SensorMessage> message;
      if (!work.goes_on()) throw CalledOff{};
      if (at == messages.size()) return message;
      message = messages[at++];
      if (std::holds_alternative<LaserScan>(*message)) {
        const double time_s = (stamp_of(*message) - stamp_of(messages.front())).seconds();
        const auto done = static_cast<std::int64_t>(at);
        const auto total = static_cast<std::int64_t>(messages.size());
        if (!work.tell({step, done, total, ++scans, time_s})) throw CalledOff{};
      }
      return message;
    };
  };
  Companion companion(work, plan);
  DriveMapping mapping(robot, options, plan.threads, companion);
  mapped->result = mapping.map(from_beginning("mapping"));
  while (mapping.is_bent()) mapped->result = mapping.map_anew(from_beginning("mapping anew"));
  if (!work.goes_on()) throw CalledOff{};
  mapped->robot = mapping.robot();
  mapped->info.log_warnings = mapping.corrections();
  take_landmarks(companion, *mapped);
  cost.note(mapped->info);
  return mapped;
}

RunInfo run_info(MapOptions options, Threads threads,
                 const std::optional<LandmarkMappingOptions>& landmarks) {
  RunInfo info;
  info.version = kVersion;
  info.threads = threads.resolved();
  LandmarkMapOptions both{options, landmarks.value_or(LandmarkMappingOptions{})};
  info.options_toml = options_to_toml(landmarks ? list_options(both) : list_options(options));
  return info;
}

void limit_cells(MapOptions& options) {
  // A cell takes five bytes, and as many again in what is made of it for files.
  constexpr std::uint64_t kBytesPerCell = 10;
  options.map.most_cells =
      std::min(options.map.most_cells, machine_memory_budget().ceiling_bytes / kBytesPerCell);
}

}  // namespace loopstone::python
