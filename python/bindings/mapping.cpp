#include "mapping.hpp"

#include <algorithm>
#include <chrono>
#include <ctime>
#include <utility>
#include <variant>

#include "loopstone/base/error.hpp"
#include "loopstone/base/release_memory.hpp"
#include "loopstone/formats/log_files.hpp"
#include "loopstone/formats/machine_memory.hpp"
#include "loopstone/formats/options_file.hpp"
#include "loopstone/formats/rgbd_files.hpp"
#include "loopstone/report/peak_memory.hpp"
#include "loopstone/slam/mapper.hpp"
#include "loopstone/slam/robot_correction.hpp"
#include "loopstone/version.hpp"

namespace loopstone::python {

namespace {

using Clock = std::chrono::steady_clock;

/// Of this process, all threads.
double cpu_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

/// What a run took so far.
class Cost {
 public:
  void note(RunInfo& info) const {
    info.wall_time_s = std::chrono::duration<double>(Clock::now() - start_).count();
    info.cpu_time_s = cpu_seconds() - cpu_s_;
    info.peak_memory_bytes = peak_memory_bytes();
  }

 private:
  Clock::time_point start_ = Clock::now();
  double cpu_s_ = cpu_seconds();
};

/// Everything into the mapper, and out of it again. \param next  gives the messages
/// \param frames  collects those of the camera; or null
template <typename Next>
void feed(Next&& next, Mapper& mapper, std::vector<RgbdFrame>* frames) {
  while (std::optional<SensorMessage> message = next()) {
    if (frames != nullptr) {
      if (const auto* frame = std::get_if<RgbdFrame>(&*message)) frames->push_back(*frame);
    }
    mapper.add(*message);
    while (mapper.next_update()) {
    }
  }
}

MapResult finish(Mapper& mapper, Work& work) {
  MapResult result = mapper.finish(work.callback());
  if (!work.goes_on()) throw CalledOff{};
  return result;
}

/// \param again  called to read the messages from the beginning, where the first map is bent by
///               beams that are not as they were told; returns what gives them
/// \param corrections  what was said of that
template <typename Next, typename Again>
MapResult make_map(Next&& next, Again&& again, Mapped& mapped, const MapOptions& options,
                   Threads threads, std::vector<RgbdFrame>* frames, Work& work,
                   std::vector<std::string>& corrections) {
  Calibration found;
  {
    Mapper mapper(mapped.robot, options, threads);
    feed(next, mapper, frames);
    found = mapper.judge_robot();
    if (!found.map_is_bent()) return finish(mapper, work);
  }
  mapped.robot = corrected_robot(mapped.robot, found);
  Mapper mapper(mapped.robot, options, threads);
  feed(again(), mapper, nullptr);
  MapResult result = finish(mapper, work);
  corrections = tell_of_correction(found, result);
  return result;
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
  if (!has_pairs(frames) || !result.complete) return;
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

/// What the log itself gives reason to say of the map.
void add_judgement(const LogSummary& judged, std::vector<std::string> changes,
                   const std::vector<std::string>& corrections, Mapped& mapped) {
  MapResult& result = mapped.result;
  const std::vector<std::string> of_log = warnings_of(judged);
  result.warnings.insert(result.warnings.begin(), of_log.begin(), of_log.end());
  judge_left_out(result.verdict, judged.left_out.share());
  for (std::string& change : changes) result.warnings.push_back(std::move(change));
  mapped.info.left_out = judged.left_out;
  mapped.info.log_warnings = of_log;
  mapped.info.log_warnings.insert(mapped.info.log_warnings.end(), corrections.begin(),
                                  corrections.end());
}

}  // namespace

CutLog::CutLog(const Log& log, LogReader& reader, const Cut& cut, const char* step, Work& work)
    : log_(log), reader_(reader), analyser_(reader), cut_(cut), step_(step), work_(work) {}

std::optional<SensorMessage> CutLog::next() {
  while (true) {
    if (cut_.max_scans > 0 && scans_ >= cut_.max_scans) return {};
    std::optional<SensorMessage> message = reader_.next();
    if (!work_.goes_on()) throw CalledOff{};
    if (!message) return {};
    analyser_.add(*message);
    if (!first_) first_ = stamp_of(*message);
    const double time_s = (stamp_of(*message) - *first_).seconds();
    if (cut_.duration_s > 0.0 && time_s > cut_.start_s + cut_.duration_s) return {};
    if (auto* scan = std::get_if<LaserScan>(&*message)) {
      if (time_s < cut_.start_s) continue;
      if (log_.robot) scan->robot_T_lidar.reset();
      ++scans_;
      const ReadProgress progress = reader_.progress();
      if (!work_.tell({step_, progress.bytes_done, progress.bytes_total, scans_, time_s}))
        throw CalledOff{};
    }
    return message;
  }
}

LogSummary CutLog::judge() {
  LogSummary summary = analyser_.finish();
  std::string reasons;
  for (const Finding& finding : summary.findings) {
    if (finding.severity == Severity::kError)
      reasons += (reasons.empty() ? "" : "; ") + finding.text;
  }
  if (!reasons.empty()) throw DataError({log_.path}, "nothing can be made of this log: " + reasons);
  if (scans_ == 0) {
    throw DataError(
        {log_.path},
        "there is no laser scan in it after --start; `loopstone info` shows how long it is");
  }
  return summary;
}

std::vector<std::string> warnings_of(const LogSummary& summary) {
  std::vector<std::string> warnings;
  for (const Finding& finding : summary.findings) {
    if (finding.severity == Severity::kWarning) warnings.push_back(finding.text);
  }
  return warnings;
}

std::shared_ptr<Mapped> map_log(const Log& log, MapOptions options, const Cut& cut, Threads threads,
                                bool texture, Work& work) {
  const Cost cost;
  limit_cells(options);
  const LogFiles files(log.path);
  const auto stop = [&work] { return !work.goes_on(); };
  const auto reader = log.open_ahead(stop, texture);
  auto mapped = std::make_shared<Mapped>();
  mapped->info = run_info(options, threads);
  mapped->info.log_path = log.path;
  const RobotModel robot = log.robot_of(*reader);
  mapped->robot = robot;

  std::vector<RgbdFrame> frames;
  std::vector<std::string> corrections;
  CutLog first(log, *reader, cut, "mapping", work);
  std::unique_ptr<LogReader> reader_again;
  std::optional<CutLog> second;
  mapped->result =
      make_map([&] { return first.next(); },
               [&] {
                 reader_again = log.open(stop);
                 second.emplace(log, *reader_again, cut, "mapping anew", work);
                 return [&second] { return second->next(); };
               },
               *mapped, options, threads, texture ? &frames : nullptr, work, corrections);
  add_judgement(first.judge(), files.changes(), corrections, *mapped);
  colour(*mapped, std::move(frames), *reader, robot, log.robot.has_value(), options.texture,
         threads, work);
  cost.note(mapped->info);
  return mapped;
}

std::shared_ptr<Mapped> map_messages(const std::vector<SensorMessage>& messages,
                                     const RobotModel& robot, MapOptions options, Threads threads,
                                     Work& work) {
  const Cost cost;
  limit_cells(options);
  auto mapped = std::make_shared<Mapped>();
  mapped->info = run_info(options, threads);
  mapped->info.log_path = "messages";
  mapped->robot = robot;
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
  std::vector<std::string> corrections;
  mapped->result = make_map(
      from_beginning("mapping"), [&] { return from_beginning("mapping anew"); }, *mapped, options,
      threads, nullptr, work, corrections);
  mapped->info.log_warnings = std::move(corrections);
  cost.note(mapped->info);
  return mapped;
}

RunInfo run_info(MapOptions options, Threads threads) {
  RunInfo info;
  info.version = kVersion;
  info.threads = threads.resolved();
  info.options_toml = options_to_toml(list_options(options));
  return info;
}

void limit_cells(MapOptions& options) {
  // A cell takes five bytes, and as many again in what is made of it for files.
  constexpr std::uint64_t kBytesPerCell = 10;
  options.map.most_cells =
      std::min(options.map.most_cells, machine_memory_budget().ceiling_bytes / kBytesPerCell);
}

}  // namespace loopstone::python
