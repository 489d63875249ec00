#include <nanobind/nanobind.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bindings.hpp"
#include "loopstone/formats/convert_log.hpp"
#include "mapping.hpp"
#include "path_like.hpp"
#include "reading.hpp"
#include "work.hpp"

namespace loopstone::python {

namespace {

/// What was written, and what is to be said of it.
struct Converted {
  std::string path{};
  std::string format{};
  ConvertResult counts{};
  std::vector<std::string> notes{};
  Robot robot{};  ///< by which the new log's wheel counts are to be read
};

Converted convert(const Log& log, const std::string& path, const std::optional<std::string>& format,
                  bool force, Work& work) {
  const LogTarget target = log_target(path, format);
  require_free_place(target, log.path, force);
  const ReadingWatch watch = watch_by(work);
  LogSource source = log.source(watch.stop);
  source.how.topics.pictures = true;
  source.how.intensities = target.format->holds.intensities;
  const auto reader = source.open();
  Converted done{.path = path, .format = std::string(target.format->name)};
  done.robot.model = source.robot_of(*reader);
  const auto writer = create_log(target, done.robot.model);
  writer->use_pictures(reader->pictures());
  done.counts =
      convert_log(*reader, *writer, target.format->holds, done.robot.model, work.callback());
  if (!done.counts.complete || !work.goes_on()) throw CalledOff{};
  (void)loopstone::judge(done.counts.left_out, log.path);
  writer->finish();
  done.notes = writer->notes();
  done.robot.model.wheels = reader->wheels(done.robot.model.wheels);
  return done;
}

}  // namespace

void bind_conversion(nb::module_& m) {
  nb::class_<Converted> converted(m, "Conversion", "A log that was written in another format.");
  converted.def_ro("path", &Converted::path, "Where it is.");
  converted.def_ro("format", &Converted::format, "Its name, such as ``carmen``.");
  const auto count = [&converted](const char* name, std::int64_t ConvertResult::*field,
                                  const char* doc) {
    converted.def_prop_ro(
        name, [field](const Converted& self) { return self.counts.*field; }, doc);
  };
  count("scans", &ConvertResult::scans, "That were read.");
  count("odometry_poses", &ConvertResult::odometry_poses, "Likewise.");
  count("wheel_readings", &ConvertResult::wheel_readings, "Likewise.");
  count("inertial_readings", &ConvertResult::inertial_readings, "Likewise.");
  count("camera_frames", &ConvertResult::camera_frames, "Likewise.");
  count("poses_by_dead_reckoning", &ConvertResult::poses_by_dead_reckoning,
        "Made of wheel counts and gyro, for a format with poses and no counts.");
  converted.def_prop_ro(
      "records_skipped", [](const Converted& self) { return self.counts.left_out.skipped.records; },
      "Of the old log: broken, repeated or out of order.");
  converted.def_ro("notes", &Converted::notes,
                   "What the new format could not carry, or carries in its own way, in words.");
  converted.def_ro("robot", &Converted::robot,
                   "By which the new log's wheel counts are to be read: no log says it itself.");
  converted.def("__repr__", [](const Converted& self) {
    return "<Conversion of " + std::to_string(self.counts.scans) + " scans to " + self.format + ">";
  });
  m.def(
      "convert",
      [](const Log& log, const PathLike& path, const std::optional<std::string>& format, bool force,
         const nb::object& progress) {
        return work(progress,
                    [&](Work& own) { return convert(log, path.value, format, force, own); });
      },
      nb::arg("log"), nb::arg("path"), nb::arg("format").none(), nb::arg("force"),
      nb::arg("progress").none());
}

}  // namespace loopstone::python
