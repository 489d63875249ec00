#include "loopstone/slam/mapper.hpp"

#include <nanobind/nanobind.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "arrays.hpp"
#include "bindings.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/report/peak_memory.hpp"
#include "loopstone/slam/live_map.hpp"
#include "mapping.hpp"
#include "messages.hpp"
#include "options.hpp"
#include "stamps.hpp"

namespace loopstone::python {

namespace {

/// A mapper for one robot that drives now; any thread may call it.
class OnlineMapper {
 public:
  OnlineMapper(const Robot* robot, const OptionValues& values, int threads)
      : options_(options_of<MapOptions>(values)),
        threads_{threads},
        robot_(robot == nullptr ? RobotModel{} : robot->model) {
    limit_cells(options_);
    mapper_.emplace(robot_, options_, threads_);
    live_.emplace(options_.map, robot_.footprint_radius_m);
  }
  ~OnlineMapper() {
    const nb::gil_scoped_release unlocked;
    mapper_.reset();
  }
  OnlineMapper(const OnlineMapper&) = delete;
  OnlineMapper& operator=(const OnlineMapper&) = delete;

  std::vector<MapUpdate> add(nb::handle object) {
    const SensorMessage message = message_of(object);
    return alone([&](Mapper& mapper) {
      mapper.add(message);
      std::vector<MapUpdate> updates;
      while (auto update = mapper.next_update()) updates.push_back(std::move(*update));
      return updates;
    });
  }

  std::shared_ptr<OccupancyMap> live_map() {
    return alone([&](Mapper& mapper) {
      const MapSnapshot snapshot = mapper.snapshot();
      live_->refresh(snapshot, LiveMap::kNoLimit);
      return std::make_shared<OccupancyMap>(live_->map());
    });
  }

  std::shared_ptr<Trajectory> key_poses() {
    return alone([](Mapper& mapper) {
      auto path = std::make_shared<Trajectory>();
      for (const KeyScanSnapshot& key : mapper.snapshot().key_scans())
        (void)path->append(key.stamp, key.map_T_robot);
      return path;
    });
  }

  std::vector<LoopClosure> closures() {
    return alone([](Mapper& mapper) { return mapper.snapshot().closures; });
  }
  std::int64_t scans() {
    return alone([](Mapper& mapper) { return mapper.scans(); });
  }
  void begin_drive() {
    alone([](Mapper& mapper) { mapper.begin_drive(); });
  }

  std::shared_ptr<Mapped> finish(const nb::object& progress) {
    return work(progress, [this](Work& own) {
      const std::lock_guard lock(mutex_);
      require_open();
      auto mapped = std::make_shared<Mapped>();
      mapped->result = mapper_->finish(own.callback());
      mapped->info = run_info(options_, threads_);
      mapped->info.log_path = "messages";
      mapped->info.peak_memory_bytes = peak_memory_bytes();
      mapped->robot = robot_;
      mapper_.reset();
      return mapped;
    });
  }

 private:
  /// Without the lock of the interpreter, one thread at a time.
  template <typename Use>
  std::invoke_result_t<Use, Mapper&> alone(Use&& use) {
    const nb::gil_scoped_release unlocked;
    const std::lock_guard lock(mutex_);
    require_open();
    return use(*mapper_);
  }
  void require_open() const {
    if (!mapper_) throw UsageError("this mapper is finished; a new one begins a new map");
  }

  MapOptions options_;
  Threads threads_;
  RobotModel robot_;
  std::mutex mutex_{};
  std::optional<Mapper> mapper_{};
  std::optional<LiveMap> live_{};
};

std::string word_of(const MapEvent& event) {
  constexpr std::array kWords{"submap_opened", "submap_frozen",  "submap_dropped", "closure",
                              "graph_solved",  "odometry_fault", "laser_fault",    "path_broken"};
  static_assert(kWords.size() == std::variant_size_v<MapEvent>);
  return kWords[event.index()];
}

std::optional<std::size_t> submap_of(const MapEvent& event) {
  if (const auto* e = std::get_if<SubmapOpened>(&event)) return e->id.index;
  if (const auto* e = std::get_if<SubmapFrozen>(&event)) return e->id.index;
  if (const auto* e = std::get_if<SubmapDropped>(&event)) return e->id.index;
  return {};
}

std::optional<LoopClosure> closure_of(const MapEvent& event) {
  if (const auto* e = std::get_if<ClosureChanged>(&event)) return e->closure;
  return {};
}

std::optional<double> shift_of(const MapEvent& event) {
  if (const auto* e = std::get_if<GraphSolved>(&event)) return e->largest_shift_m;
  return {};
}

void bind_update(nb::module_& m) {
  nb::class_<MapEvent> event(m, "MapEvent", "What happened since the scan before.");
  event.def_prop_ro("kind", word_of,
                    "``submap_opened``, ``submap_frozen``, ``submap_dropped``, ``closure``,\n"
                    "``graph_solved``, ``odometry_fault``, ``laser_fault`` or ``path_broken``.");
  event.def_prop_ro("submap", submap_of, "The submap's number, of events of submaps.");
  event.def_prop_ro("closure", closure_of, "What was found, came to stand, or was revoked.");
  event.def_prop_ro("largest_shift_m", shift_of, "Of a solved graph: how far a submap moved.");
  event.def("__repr__", [](const MapEvent& e) { return "<MapEvent " + word_of(e) + ">"; });

  nb::class_<MapUpdate> update(
      m, "MapUpdate",
      "Where the robot is at a scan. Frames as REP-105 has them: odom goes on smoothly and\n"
      "drifts; map is where closed loops put the robot, so map_T_odom moves when they close.");
  def_stamp(update);
  update.def_ro("scan", &MapUpdate::scan, "Its number among all scans, from 0.");
  def_array(
      update, "odom_T_robot", [](const MapUpdate& u) { return to_array(u.odom_T_robot); },
      "(3,) x, y [m], yaw [rad].");
  def_array(
      update, "map_T_odom", [](const MapUpdate& u) { return to_array(u.map_T_odom); },
      "(3,) x, y [m], yaw [rad]: what corrects odometry.");
  def_array(
      update, "map_T_robot", [](const MapUpdate& u) { return to_array(u.map_T_robot()); },
      "(3,) x, y [m], yaw [rad]: where the robot is on the map.");
  def_array(
      update, "covariance",
      [](const MapUpdate& u) { return to_array(Eigen::MatrixXd(u.covariance)); },
      "(3, 3) of map_T_robot against what is around it, axes of the map.");
  update.def_prop_ro(
      "status", [](const MapUpdate& u) { return std::string(loopstone::to_string(u.status)); },
      "``tracked``, ``degenerate``, ``bridged`` or ``lost``.");
  update.def_ro("open_direction_rad", &MapUpdate::open_direction_rad,
                "The direction that the laser leaves open, when degenerate.");
  update.def_ro("key_scan", &MapUpdate::key_scan, "Its number among the key scans, if it is one.");
  update.def_ro("events", &MapUpdate::events, "What happened since the update before.");
  update.def_ro("missed", &MapUpdate::missed, "Updates given up before this one.");
  update.def("__repr__", [](const MapUpdate& u) {
    return "<MapUpdate of scan " + std::to_string(u.scan) + ", " +
           std::string(loopstone::to_string(u.status)) + ">";
  });
}

}  // namespace

void bind_mapper(nb::module_& m) {
  bind_update(m);
  nb::class_<OnlineMapper> mapper(
      m, "Mapper",
      "Maps while the robot drives. Messages come as they are measured; the result is the same,\n"
      "to the byte, as that of :func:`loopstone.map` without a second pass for beams that are not\n"
      "as the log tells. Any thread may call it, one at a time works.");
  mapper.def(
      "__init__",
      [](OnlineMapper* self, const Robot* robot, const nb::object& options, int threads,
         const nb::kwargs& overrides) {
        const nb::object values =
            nb::module_::import_("loopstone._values").attr("map_values")(options, **overrides);
        new (self) OnlineMapper(robot, nb::cast<const OptionValues&>(values), threads);
      },
      nb::arg("robot") = nb::none(), nb::kw_only(), nb::arg("options") = nb::none(),
      nb::arg("threads") = 0, nb::arg("overrides"),
      nb::sig("def __init__(self, robot: Robot | None = None, *, options: "
              "loopstone.options.MapOptions | collections.abc.Mapping[str, typing.Any] | str | "
              "None = None, threads: int = 0, **overrides: typing.Any) -> None"),
      "As :func:`loopstone.map` takes its options. Raises OptionsError.");
  mapper.def("add", &OnlineMapper::add, nb::arg("message").none(),
             nb::sig("def add(self, message: LaserScan | OdometryPose | WheelTicks | ImuSample | "
                     "RgbdFrame) -> list[MapUpdate]"),
             "A message as it was measured. Returns the updates that it led to, one a scan: none\n"
             "while a scan waits for odometry of its time, at most 0.25 s; rarely several.");
  mapper.def("begin_drive", &OnlineMapper::begin_drive,
             "What comes next is of another drive in the same building, which may begin anywhere.");
  mapper.def("live_map", &OnlineMapper::live_map, "The occupancy map so far, all of one moment.");
  mapper.def_prop_ro("key_poses", &OnlineMapper::key_poses,
                     "map_T_robot of the key scans so far, where the graph has them now.");
  mapper.def_prop_ro("loop_closures", &OnlineMapper::closures, "So far.");
  mapper.def_prop_ro("scans", &OnlineMapper::scans, "So far.");
  mapper.def(
      "finish",
      [](OnlineMapper& self, const nb::object& progress) { return self.finish(progress); },
      nb::arg("progress") = nb::none(),
      nb::sig("def finish(self, progress: collections.abc.Callable[[str, int, int, int, float], "
              "object] | None = None) -> MapResult"),
      "Last closures, last solution, the final map of all scans. Nothing may follow.");
}

}  // namespace loopstone::python
