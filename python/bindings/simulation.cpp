#include <nanobind/nanobind.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "arrays.hpp"
#include "bindings.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/formats/log_reader.hpp"
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
};

World world_of(nb::handle world, std::uint64_t seed, double robot_radius_m) {
  if (nb::isinstance<GridMap>(world))
    return make_world(*nb::cast<const GridMap&>(world).cells, "map", robot_radius_m);
  return make_world(nb::cast<std::string>(world), seed);
}

std::shared_ptr<Simulated> simulate_drive(const World& world, const Robot& robot,
                                          const SimulationOptions& options, std::uint64_t seed,
                                          Work& work) {
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
  simulated->summary = simulate(world, robot.model, options, seed, sink);
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

}  // namespace

void bind_simulation(nb::module_& m) {
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
  simulated.def("save", save_log, nb::arg("path"), nb::arg("format") = "carmen",
                "Writes the log, whole or not at all: ``carmen``, ``ucsd``, ``mcap``, ``bag``...\n"
                "Formats leave out what they have no place for. Raises UsageError, DataError.");
  simulated.def("__repr__", [](const Simulated& self) {
    return "<Simulation of " + std::to_string(self.summary.scans) + " scans>";
  });
  m.def(
      "simulate",
      [](nb::handle world, const Robot* robot, std::uint64_t seed, const OptionValues& values,
         const nb::object& progress) {
        const auto options = options_of<SimulationOptions>(values);
        const Robot model = robot == nullptr ? Robot{} : *robot;
        const World place = world_of(world, seed, model.model.footprint_radius_m);
        return work(progress,
                    [&](Work& own) { return simulate_drive(place, model, options, seed, own); });
      },
      nb::arg("world"), nb::arg("robot").none(), nb::arg("seed"), nb::arg("options"),
      nb::arg("progress").none());
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
