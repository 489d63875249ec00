#include <nanobind/nanobind.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "arrays.hpp"
#include "bindings.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/formats/landmark_file.hpp"
#include "loopstone/formats/log_reader.hpp"
#include "loopstone/simulation/place_reflectors.hpp"
#include "loopstone/simulation/realism.hpp"
#include "loopstone/simulation/simulate.hpp"
#include "mapping.hpp"
#include "maps.hpp"
#include "messages.hpp"
#include "options.hpp"
#include "path_like.hpp"
#include "robot.hpp"
#include "work.hpp"

namespace loopstone::python {

namespace {

/// What a robot measured, and the truth.
struct Simulated {
  std::vector<SensorMessage> messages{};
  std::shared_ptr<Trajectory> truth = std::make_shared<Trajectory>();
  GridMap map{};
  Robot robot{};
  SimulationSummary summary{};
  std::vector<MappedLandmark> reflectors{};
};

/// What is simulated beside the options.
struct SimulationPlan {
  std::uint64_t seed = 1;
  std::optional<std::uint64_t> drive_seed{};  ///< of what robot and sensors draw, else `seed`
  int reflectors = 0;
};

World world_of(nb::handle world, std::uint64_t seed, double robot_radius_m) {
  if (nb::isinstance<GridMap>(world))
    return make_world(*nb::cast<const GridMap&>(world).cells, "map", robot_radius_m);
  return make_world(nb::cast<std::string>(world), seed);
}

/// The world as the effects and the reflectors make it.
World furnished(World world, const RobotModel& robot, const SimulationOptions& options,
                const SimulationPlan& plan, RealismRecord& record) {
  world = real_world(std::move(world), options.realism, plan.seed, record);
  if (plan.reflectors == 0) return world;
  world = with_reflectors(std::move(world), robot.footprint_radius_m, options.drive,
                          plan.reflectors, plan.seed);
  if (world.reflectors.empty()) {
    throw UsageError("reflectors: no wall or column is seen from the robot's way in this world");
  }
  return world;
}

std::shared_ptr<Simulated> simulate_drive(World plain, const Robot& robot,
                                          const SimulationOptions& options,
                                          const SimulationPlan& plan, Work& work) {
  RealismRecord record;
  const World world = furnished(std::move(plain), robot.model, options, plan, record);
  auto simulated = std::make_shared<Simulated>();
  simulated->robot = robot;
  SimulationSink sink;
  sink.message = [&](SensorMessage message) { simulated->messages.push_back(std::move(message)); };
  sink.truth = [&](const StampedPose2& pose) {
    (void)simulated->truth->append(pose.stamp, pose.pose);
  };
  sink.progress = [&](double done_s, double total_s) {
    const auto in_ms = [](double s) { return static_cast<std::int64_t>(1000.0 * s); };
    return work.tell({"simulating", in_ms(done_s), in_ms(total_s), 0, done_s});
  };
  simulated->summary =
      simulate(world, robot.model, options, plan.drive_seed.value_or(plan.seed), sink);
  RealismRecord& drawn = simulated->summary.realism;
  drawn.facts.insert(drawn.facts.begin(), record.facts.begin(), record.facts.end());
  simulated->reflectors = landmarks_of(world);
  if (!work.goes_on()) throw CalledOff{};
  simulated->map.cells = std::make_shared<const CellStates>(true_map(world));
  return simulated;
}

void save_log(const Simulated& self, const PathLike& path, const std::string& format) {
  const nb::gil_scoped_release unlocked;
  const auto writer = create_log(path.value, format, self.robot.model);
  for (const SensorMessage& message : self.messages) writer->write(message);
  writer->finish();
}

nb::list facts_of(const Simulated& self) {
  nb::list facts;
  for (const RealismFact& fact : self.summary.realism.facts)
    facts.append(nb::make_tuple(fact.effect, fact.name, fact.value));
  return facts;
}

nb::list spoils_of(const Simulated& self) {
  nb::list spoils;
  for (const RealismSpoil& spoil : self.summary.realism.spoils)
    spoils.append(nb::make_tuple(spoil.effect, spoil.from_s, spoil.to_s));
  return spoils;
}

/// What was truly simulated, beyond the options.
void def_reality(nb::class_<Simulated>& simulated) {
  simulated.def_prop_ro(
      "realism_facts", facts_of, nb::sig("def realism_facts(self) -> list[tuple[str, str, float]]"),
      "(effect, name with its unit, value) of what was drawn, such as the laser's true mount.");
  simulated.def_prop_ro("realism_spoils", spoils_of,
                        nb::sig("def realism_spoils(self) -> list[tuple[str, float, float]]"),
                        "(effect, from, to) of what was spoilt when, since the log's start [s].");
  def_array(
      simulated, "reflectors",
      [](const Simulated& self) {
        std::vector<double> values;
        for (const MappedLandmark& at : self.reflectors)
          values.insert(values.end(), {at.position.x(), at.position.y(), at.radius_m});
        return array_of<double, nb::ndim<2>>(std::move(values), {self.reflectors.size(), 3});
      },
      "(R, 3) x, y, radius [m] of the reflectors that found a place, on the map.");
  simulated.def_prop_ro(
      "landmarks", [](const Simulated& self) { return self.reflectors; },
      "The same as :func:`loopstone.localize` takes them.");
  simulated.def(
      "save_reflectors",
      [](const Simulated& self, const PathLike& path) {
        const nb::gil_scoped_release unlocked;
        write_landmarks(path.value, self.reflectors);
      },
      nb::arg("path"), "Writes them as ``loopstone localize --landmarks`` takes them.");
}

void bind_simulated(nb::module_& m) {
  nb::class_<Simulated> simulated(
      m, "Simulation",
      "What a simulated robot measured, and the truth; an iterable of its messages.");
  simulated.def_prop_ro(
      "messages",
      [](const Simulated& self) {
        nb::list messages;
        for (const SensorMessage& message : self.messages) messages.append(to_object(message));
        return messages;
      },
      nb::sig("def messages(self) -> list[LaserScan | OdometryPose | WheelTicks | ImuSample | "
              "RgbdFrame]"),
      "In the order of time, copied.");
  simulated.def(
      "__iter__", [](nb::handle self) { return nb::iter(self.attr("messages")); },
      nb::sig("def __iter__(self) -> collections.abc.Iterator[LaserScan | OdometryPose | "
              "WheelTicks | ImuSample | RgbdFrame]"));
  simulated.def("__len__", [](const Simulated& self) { return self.messages.size(); });
  simulated.def_prop_ro(
      "truth", [](const Simulated& self) { return self.truth; }, "map_T_robot at every scan.");
  simulated.def_ro("map", &Simulated::map, "The map that a perfect robot would draw.");
  simulated.def_ro("robot", &Simulated::robot, "That drove: its mounts and wheels.");
  simulated.def_prop_ro(
      "scans", [](const Simulated& self) { return self.summary.scans; }, "How many there are.");
  simulated.def_prop_ro(
      "duration_s", [](const Simulated& self) { return self.summary.duration_s; },
      "Of the drive [s].");
  simulated.def_prop_ro(
      "route_length_m", [](const Simulated& self) { return self.summary.route_length_m; },
      "The way that the robot drove [m].");
  def_reality(simulated);
  simulated.def("save", save_log, nb::arg("path"), nb::arg("format") = "carmen",
                "Writes the log, whole or not at all: ``carmen``, ``ucsd``, ``mcap``, ``bag``...\n"
                "Formats leave out what they have no place for. Raises UsageError, DataError.");
  simulated.def("__repr__", [](const Simulated& self) {
    return "<Simulation of " + std::to_string(self.summary.scans) + " scans>";
  });
}

}  // namespace

void bind_simulation(nb::module_& m) {
  bind_simulated(m);
  m.def(
      "simulate",
      [](nb::handle world, const Robot* robot, std::uint64_t seed, const std::string& realism,
         const std::optional<std::uint64_t>& drive_seed, int reflectors, const OptionValues& values,
         const nb::object& progress) {
        SimulationOptions options;
        if (!realism.empty()) choose_realism(options.realism, realism);
        set_options(list_options(options), values);
        if (reflectors < 0) throw UsageError("reflectors: must be 0 or more");
        const SimulationPlan plan{seed, drive_seed, reflectors};
        const Robot model = robot == nullptr ? Robot{} : *robot;
        const World place = world_of(world, seed, model.model.footprint_radius_m);
        return work(progress,
                    [&](Work& own) { return simulate_drive(place, model, options, plan, own); });
      },
      nb::arg("world"), nb::arg("robot").none(), nb::arg("seed"), nb::arg("realism"),
      nb::arg("drive_seed").none(), nb::arg("reflectors"), nb::arg("options"),
      nb::arg("progress").none());
  m.def(
      "realism_names", [] { return realism_names(); },
      "Effects in which the real world is less kind than a simulation, for ``realism``.");
  m.def(
      "world_names",
      [] {
        std::vector<std::string> names;
        for (const std::string_view name : world_names()) names.emplace_back(name);
        return names;
      },
      "The worlds that there are.");
}

}  // namespace loopstone::python
