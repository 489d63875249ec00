#include <fmt/format.h>
#include <nanobind/nanobind.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <chrono>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "arrays.hpp"
#include "bindings.hpp"
#include "json.hpp"
#include "known_map.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/formats/machine_memory.hpp"
#include "loopstone/formats/mrclam.hpp"
#include "loopstone/formats/options_file.hpp"
#include "loopstone/localization/localizer.hpp"
#include "loopstone/pipeline/log_landmarks.hpp"
#include "loopstone/pipeline/log_localization.hpp"
#include "loopstone/report/landmark_drawing.hpp"
#include "loopstone/report/localization_outputs.hpp"
#include "loopstone/report/peak_memory.hpp"
#include "loopstone/version.hpp"
#include "mapping.hpp"
#include "maps.hpp"
#include "messages.hpp"
#include "methods.hpp"
#include "options.hpp"
#include "path_like.hpp"
#include "stamps.hpp"
#include "work.hpp"

namespace loopstone::python {

namespace {

using Estimate = LocalizationEstimate;

/// Where a robot was on a map, and what a folder of results tells beside.
struct Localized {
  LocalizationResult result{};
  LocalizationRunInfo info{};
  std::shared_ptr<const Grid<std::int8_t>> drawn{};  ///< the map, to look at
};

std::shared_ptr<const Grid<std::int8_t>> drawing_of(const KnownMap& map) {
  return {map.map, &map.map->occupancy()};
}

std::optional<InitialPose> initial_of(const std::optional<ArrayLike>& pose, double sigma_m,
                                      double sigma_rad) {
  if (!pose) return {};
  if (!(sigma_m > 0.0 && sigma_rad > 0.0))
    throw UsageError("initial_sigma: both standard deviations must be greater than 0");
  return InitialPose{pose_of(*pose, "initial"), sigma_m, sigma_rad};
}

LocalizationRunInfo info_of(LocalizationOptions options, const std::optional<InitialPose>& initial,
                            std::uint64_t seed, Threads threads, const KnownMap& map) {
  LocalizationRunInfo info;
  info.run.version = kVersion;
  info.run.threads = threads.resolved();
  info.run.options_toml = options_to_toml(list_options(options));
  info.initial = initial;
  info.seed = seed;
  info.map_free_area_m2 = map.map->free_area_m2();
  info.map_memory_bytes = static_cast<std::int64_t>(map.map->memory_bytes());
  return info;
}

std::shared_ptr<Localized> localize_log(const Log& log, const KnownMap& map,
                                        const LocalizationOptions& options,
                                        const std::optional<InitialPose>& initial,
                                        std::uint64_t seed, bool calibration, Threads threads,
                                        const LogCut& cut, Work& work) {
  const auto start = std::chrono::steady_clock::now();
  const ReadingWatch watch = watch_by(work);
  const LogSource source = log.source(watch.stop);
  const auto reader = source.open();
  DrivenRobot robot{.model = source.robot_of(*reader), .mounts_from_log = source.mounts_from_log()};
  if (calibration) robot = robot_as_driven(source, robot.model, cut, threads, watch);
  if (!work.goes_on()) throw CalledOff{};
  LogLocalization found = loopstone::localize_log(source, *reader, robot, *map.map, options,
                                                  initial, seed, cut, threads, watch);
  if (!work.goes_on()) throw CalledOff{};

  auto done = std::make_shared<Localized>();
  done->drawn = drawing_of(map);
  done->result = std::move(found.result);
  done->info = info_of(options, initial, seed, threads, map);
  done->info.run.log_path = log.path;
  done->info.run.left_out = found.log.left_out;
  done->info.run.wall_time_s =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  done->info.run.peak_memory_bytes = peak_memory_bytes();
  return done;
}

struct ByLandmarks {
  LocalizationResult result{};
  LeftOut left_out{};
};

ByLandmarks follow_mrclam(const Log& log, const LandmarkMap& landmarks,
                          const LandmarkTrackingOptions& options,
                          const std::optional<InitialPose>& initial, bool nameless,
                          const LogCut& cut, Work& work) {
  const MrclamLog drive = read_mrclam_drive(log.path, {.strict = log.how.strict}, options.sightings,
                                            machine_memory_budget());
  const RobotModel robot = log.robot ? log.robot->model : RobotModel{};
  return {localize_mrclam(drive, readings_within(drive, cut, nameless), robot, landmarks, options,
                          initial, [&work] { return !work.goes_on(); }),
          left_out_of(drive)};
}

ByLandmarks follow_reflectors(const Log& log, const LandmarkMap& landmarks,
                              const LandmarkTrackingOptions& options,
                              const std::optional<InitialPose>& initial, const LogCut& cut,
                              Work& work) {
  const ReadingWatch watch = watch_by(work);
  LogSource source = log.source(watch.stop);
  source.how.intensities = true;
  const auto reader = source.open();
  LogLocalization found =
      localize_by_reflectors(source, *reader, landmarks, options, initial, cut, watch);
  return {std::move(found.result), found.log.left_out};
}

std::shared_ptr<Localized> localize_by_landmarks(const Log& log,
                                                 const std::vector<MappedLandmark>& known,
                                                 LandmarkTrackingOptions options,
                                                 const std::optional<InitialPose>& initial,
                                                 bool nameless, const LogCut& cut, Work& work) {
  const auto start = std::chrono::steady_clock::now();
  const LandmarkMap landmarks(known);
  ByLandmarks found = is_mrclam_log(log.path)
                          ? follow_mrclam(log, landmarks, options, initial, nameless, cut, work)
                          : follow_reflectors(log, landmarks, options, initial, cut, work);
  if (!work.goes_on()) throw CalledOff{};
  auto done = std::make_shared<Localized>();
  done->drawn = std::make_shared<const Grid<std::int8_t>>(drawn_landmarks(known));
  done->result = std::move(found.result);
  RunInfo& run = done->info.run;
  run.version = kVersion;
  run.threads = 1;
  run.options_toml = options_to_toml(list_options(options));
  run.log_path = log.path;
  run.left_out = found.left_out;
  done->info.initial = initial;
  run.wall_time_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  run.peak_memory_bytes = peak_memory_bytes();
  return done;
}

/// Follows a robot that drives now; any thread may call it.
class OnlineLocalizer {
 public:
  OnlineLocalizer(const KnownMap& map, const Robot* robot, const OptionValues& values,
                  const std::optional<InitialPose>& initial, std::uint64_t seed, int threads)
      : map_(map) {
    const auto options = options_of<LocalizationOptions>(values);
    info_ = info_of(options, initial, seed, Threads{threads}, map);
    info_.run.log_path = "messages";
    localizer_.emplace(*map.map, robot == nullptr ? RobotModel{} : robot->model, options, initial,
                       seed, Threads{threads});
  }

  std::vector<Estimate> add(nb::handle object) {
    const SensorMessage message = message_of(object);
    return alone([&](Localizer& localizer) {
      localizer.add(message);
      std::vector<Estimate> estimates;
      while (auto estimate = localizer.next_update()) estimates.push_back(std::move(*estimate));
      return estimates;
    });
  }
  void restart_at(const ArrayLike& pose, double sigma_m, double sigma_rad) {
    const auto initial = initial_of(pose, sigma_m, sigma_rad);
    alone([&](Localizer& localizer) { localizer.restart_at(*initial); });
  }
  Matrix particles() {
    const auto poses = alone([](Localizer& localizer) { return localizer.particles(); });
    return to_array(std::span<const Pose2>(poses));
  }
  std::shared_ptr<Localized> finish() {
    return alone([this](Localizer& localizer) {
      auto done = std::make_shared<Localized>();
      done->result = localizer.finish();
      done->info = info_;
      done->drawn = drawing_of(map_);
      localizer_.reset();
      return done;
    });
  }

 private:
  template <typename Use>
  std::invoke_result_t<Use, Localizer&> alone(Use&& use) {
    const nb::gil_scoped_release unlocked;
    const std::lock_guard lock(mutex_);
    if (!localizer_) throw UsageError("this localizer is finished; a new one begins anew");
    return use(*localizer_);
  }

  KnownMap map_;
  LocalizationRunInfo info_{};
  std::mutex mutex_{};
  std::optional<Localizer> localizer_{};
};

void bind_estimate(nb::module_& m) {
  nb::class_<Estimate> estimate(m, "LocalizationEstimate",
                                "Where the robot is at a scan, and how far to trust that.");
  def_stamp(estimate);
  def_array(
      estimate, "map_T_robot", [](const Estimate& e) { return to_array(e.map_T_robot); },
      "(3,) x, y [m], yaw [rad].");
  def_array(
      estimate, "map_T_odom", [](const Estimate& e) { return to_array(e.map_T_odom()); },
      "(3,) moves when the pose is corrected (REP-105).");
  def_array(
      estimate, "odom_T_robot", [](const Estimate& e) { return to_array(e.odom_T_robot); },
      "(3,) by odometry since the first scan: smooth, drifts.");
  def_array(
      estimate, "covariance",
      [](const Estimate& e) { return to_array(Eigen::MatrixXd(e.covariance)); },
      "(3, 3) of map_T_robot, axes of the map [m^2, m rad, rad^2].");
  estimate.def_prop_ro(
      "state", [](const Estimate& e) { return std::string(loopstone::to_string(e.state)); },
      "``TRACKING``, ``DOUBTFUL`` or ``LOST``.");
  estimate.def_ro("probability", &Estimate::probability,
                  "That the pose is within 0.2 m and 5 deg of the truth.");
  estimate.def_ro("refined", &Estimate::refined,
                  "By registration to the map; else the particles' mean.");
  estimate.def_ro("hypotheses", &Estimate::hypotheses, "How many places the robot may be at.");
  def_array(
      estimate, "places",
      [](const Estimate& e) {
        std::vector<Pose2> poses;
        for (const LocalizationHypothesis& place : e.places) poses.push_back(place.map_T_robot);
        return to_array(std::span<const Pose2>(poses));
      },
      "(H, 3) these places, the most probable first, as the particles have them;\n"
      "map_T_robot is the first one's, refined.");
  def_array(
      estimate, "place_probabilities",
      [](const Estimate& e) {
        std::vector<double> values;
        for (const LocalizationHypothesis& place : e.places) values.push_back(place.probability);
        const std::size_t count = values.size();
        return array_of<double, nb::ndim<1>>(std::move(values), {count});
      },
      "(H,) share of the belief that each place has; they sum to 1.");
  estimate.def_ro("particles", &Estimate::particles, "How many there are at the scan.");
  estimate.def_ro("travelled_m", &Estimate::travelled_m, "By odometry since the first scan [m].");
  estimate.def("__repr__", [](const Estimate& e) {
    return fmt::format("<LocalizationEstimate ({:.2f}, {:.2f}) m, {:.0f} %: {}>", e.map_T_robot.x,
                       e.map_T_robot.y, 100.0 * e.probability, loopstone::to_string(e.state));
  });
}

void bind_result(nb::module_& m) {
  nb::class_<Localized> result(m, "LocalizationResult", "Where a robot was on a known map.");
  result.def_prop_ro(
      "trajectory",
      [](const Localized& self) { return std::make_shared<Trajectory>(self.result.trajectory()); },
      "map_T_robot at every scan from the first pose on.");
  result.def_prop_ro(
      "estimates", [](const Localized& self) { return self.result.estimates; },
      "One a scan, with all that is known of it.");
  def_array(
      result, "probability",
      [](const Localized& self) {
        std::vector<double> values;
        for (const Estimate& e : self.result.estimates) values.push_back(e.probability);
        const std::size_t count = values.size();
        return array_of<double, nb::ndim<1>>(std::move(values), {count});
      },
      "(N,) that each pose is within 0.2 m and 5 deg of the truth.");
  def_array(
      result, "covariances",
      [](const Localized& self) {
        std::vector<double> values;
        for (const Estimate& e : self.result.estimates)
          values.insert(values.end(), e.covariance.data(), e.covariance.data() + 9);
        return array_of<double, nb::ndim<3>>(std::move(values),
                                             {self.result.estimates.size(), 3, 3});
      },
      "(N, 3, 3) [m^2, m rad, rad^2].");
  result.def_prop_ro(
      "warnings", [](const Localized& self) { return self.result.warnings; }, "In plain words.");
  result.def_prop_ro(
      "summary",
      [](const Localized& self) {
        return parse_json(format_summary(self.result, *self.drawn, self.info));
      },
      nb::sig("def summary(self) -> dict[str, typing.Any]"), "What summary.json has.");
  result.def(
      "save",
      [](const Localized& self, const PathLike& folder, bool force) {
        const nb::gil_scoped_release unlocked;
        LocalizationRunInfo info = self.info;
        info.run.force = force;
        write_localization_outputs(self.result, *self.drawn, info, folder.value);
      },
      nb::arg("folder"), nb::kw_only(), nb::arg("force") = false,
      "Writes the files of ``loopstone localize --report``, all of them or none.");
  result.def("__repr__", [](const Localized& self) {
    return "<LocalizationResult of " + std::to_string(self.result.scans) + " scans>";
  });
}

void bind_known_map(nb::module_& m) {
  nb::class_<KnownMap> known(m, "LocalizationMap",
                             "A map made ready for localisation, once; many may share it.");
  known.def(
      "__init__",
      [](KnownMap* self, const GridMap& map) {
        const nb::gil_scoped_release unlocked;
        new (self) KnownMap{std::make_shared<const LocalizationMap>(*map.cells)};
      },
      nb::arg("map"), "Raises UsageError when the map shows no wall or nothing free.");
  known.def_prop_ro(
      "free_area_m2", [](const KnownMap& k) { return k.map->free_area_m2(); },
      "Where the robot may be [m^2].");
}

void bind_localizer(nb::module_& m) {
  nb::class_<OnlineLocalizer> localizer(
      m, "Localizer",
      "Follows a robot on a known map while it drives. Any thread may call it, one at a time "
      "works.");
  localizer.def(
      "__init__",
      [](OnlineLocalizer* self, const nb::object& map, const Robot* robot,
         const std::optional<ArrayLike>& initial, double sigma_m, double sigma_rad,
         std::uint64_t seed, const nb::object& options, int threads, const nb::kwargs& overrides) {
        const nb::module_ values = nb::module_::import_("loopstone._values");
        const nb::object known_map = values.attr("localization_map")(map);
        const nb::object given = values.attr("localization_values")(options, **overrides);
        new (self) OnlineLocalizer(nb::cast<const KnownMap&>(known_map), robot,
                                   nb::cast<const OptionValues&>(given),
                                   initial_of(initial, sigma_m, sigma_rad), seed, threads);
      },
      nb::arg("map"), nb::arg("robot") = nb::none(), nb::kw_only(), nb::arg("initial") = nb::none(),
      nb::arg("initial_sigma_m") = 0.5, nb::arg("initial_sigma_rad") = 0.26, nb::arg("seed") = 1,
      nb::arg("options") = nb::none(), nb::arg("threads") = 0, nb::arg("overrides"),
      nb::sig("def __init__(self, map: LocalizationMap | GridMap | OccupancyMap | MapResult | str "
              "| os.PathLike[str], robot: Robot | None = None, *, initial: "
              "numpy.typing.ArrayLike | None = None, initial_sigma_m: float = 0.5, "
              "initial_sigma_rad: float = 0.26, seed: int = 1, options: "
              "loopstone.options.LocalizationOptions | collections.abc.Mapping[str, typing.Any] | "
              "str | None = None, threads: int = 0, **overrides: typing.Any) -> None"),
      "As :func:`loopstone.localize` takes them. Raises OptionsError, UsageError.");
  localizer.def("add", &OnlineLocalizer::add, nb::arg("message").none(),
                nb::sig("def add(self, message: LaserScan | OdometryPose | WheelTicks | ImuSample "
                        "| RgbdFrame) -> list[LocalizationEstimate]"),
                "A message as it was measured. Returns the estimates that it led to.");
  localizer.def("restart_at", &OnlineLocalizer::restart_at, nb::arg("pose"),
                nb::arg("sigma_m") = 0.5, nb::arg("sigma_rad") = 0.26,
                "Somebody says where the robot is at the next scan.");
  def_array(localizer, "particles", &OnlineLocalizer::particles,
            "(P, 3) what it believes at the newest scan.");
  localizer.def("finish", &OnlineLocalizer::finish, "Ends the recording. Nothing may follow.");
}

}  // namespace

void bind_localization(nb::module_& m) {
  bind_estimate(m);
  bind_result(m);
  bind_known_map(m);
  bind_localizer(m);
  m.def(
      "localize_log",
      [](const Log& log, const KnownMap& map, const OptionValues& values,
         const std::optional<ArrayLike>& initial, double sigma_m, double sigma_rad,
         std::uint64_t seed, bool calibration, double start_s, double duration_s,
         std::int64_t max_scans, int threads, const nb::object& progress) {
        const auto options = options_of<LocalizationOptions>(values);
        const auto place = initial_of(initial, sigma_m, sigma_rad);
        const LogCut cut{start_s, duration_s, max_scans};
        return work(progress, [&](Work& own) {
          return localize_log(log, map, options, place, seed, calibration, Threads{threads}, cut,
                              own);
        });
      },
      nb::arg("log"), nb::arg("map"), nb::arg("options"), nb::arg("initial").none(),
      nb::arg("initial_sigma_m"), nb::arg("initial_sigma_rad"), nb::arg("seed"),
      nb::arg("calibration"), nb::arg("start_s"), nb::arg("duration_s"), nb::arg("max_scans"),
      nb::arg("threads"), nb::arg("progress").none());
  m.def(
      "localize_by_landmarks",
      [](const Log& log, const std::vector<MappedLandmark>& landmarks, const OptionValues& values,
         const std::optional<ArrayLike>& initial, double sigma_m, double sigma_rad, bool nameless,
         double start_s, double duration_s, std::int64_t max_scans, const nb::object& progress) {
        const auto options = options_of<LandmarkTrackingOptions>(values);
        const auto place = initial_of(initial, sigma_m, sigma_rad);
        const LogCut cut{start_s, duration_s, max_scans};
        return work(progress, [&](Work& own) {
          return localize_by_landmarks(log, landmarks, options, place, nameless, cut, own);
        });
      },
      nb::arg("log"), nb::arg("landmarks"), nb::arg("options"), nb::arg("initial").none(),
      nb::arg("initial_sigma_m"), nb::arg("initial_sigma_rad"), nb::arg("nameless"),
      nb::arg("start_s"), nb::arg("duration_s"), nb::arg("max_scans"), nb::arg("progress").none());
}

}  // namespace loopstone::python
