#include <nanobind/nanobind.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/unique_ptr.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <memory>
#include <mutex>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "bindings.hpp"
#include "json.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/formats/log_reader.hpp"
#include "loopstone/formats/log_summary.hpp"
#include "loopstone/formats/machine_memory.hpp"
#include "messages.hpp"
#include "methods.hpp"
#include "path_like.hpp"
#include "reading.hpp"
#include "robot.hpp"
#include "signals.hpp"

namespace loopstone::python {

namespace {

using Topics = std::map<std::string, std::vector<std::string>>;

/// Roles that a user may name topics for.
constexpr std::array kNamedRoles{TopicRole::kLaser,  TopicRole::kOdometry, TopicRole::kImu,
                                 TopicRole::kWheels, TopicRole::kDepth,    TopicRole::kColour};

std::vector<std::pair<TopicRole, std::string>> named_topics(const Topics& topics) {
  std::vector<std::pair<TopicRole, std::string>> named;
  for (const auto& [role, names] : topics) {
    const auto known = find_word<TopicRole>(role);
    if (!known || std::ranges::find(kNamedRoles, *known) == kNamedRoles.end()) {
      throw UsageError("topics: '" + role +
                       "' is no role; a role is laser, odometry, imu, wheels, depth or colour");
    }
    if (names.empty()) named.emplace_back(*known, "");
    for (const std::string& name : names) named.emplace_back(*known, name);
  }
  return named;
}

template <typename Enum>
Enum word_of(const std::string& word, const char* name) {
  if (const auto found = find_word<Enum>(word)) return *found;
  std::string known;
  for (const std::string_view w : kWords<Enum>)
    known += (known.empty() ? "" : ", ") + std::string(w);
  throw UsageError(std::string(name) + " = " + word + ": must be one of " + known);
}

Log make_log(const PathLike& path, const Robot* robot, bool strict, const std::string& stamps,
             bool intensities, const Topics& topics, const std::string& base_frame,
             const std::string& echo, const std::optional<std::pair<double, double>>& slice_m) {
  Log log{.path = path.value};
  log.how.strict = strict;
  log.how.stamps = word_of<StampUse>(stamps, "stamps");
  log.how.memory = machine_memory_budget();
  log.how.intensities = intensities;
  log.how.topics.named = named_topics(topics);
  log.how.topics.base_frame = base_frame;
  log.how.topics.echo = word_of<EchoUse>(echo, "echo");
  if (slice_m) {
    if (!(slice_m->first < slice_m->second))
      throw UsageError("slice_m: two heights in metres were expected, the lower first");
    log.how.topics.slice = HeightRange{slice_m->first, slice_m->second};
  }
  if (robot != nullptr) {
    log.robot = *robot;
    log.how.topics.wheels = robot->stated;
  }
  return log;
}

/// Reads a log once, message by message.
class Messages {
 public:
  explicit Messages(const Log& log) : mounts_from_log_(!log.robot) {
    const LogSource source = log.source([this] { return asked_to_stop(); });
    reader_ = guarded([&] { return source.open(); });
    robot_.model = source.robot_of(*reader_);
    if (log.robot) robot_.stated = log.robot->stated;
  }
  Messages(const Messages&) = delete;
  Messages& operator=(const Messages&) = delete;
  ~Messages() {
    // A thread of the reader may wait for the lock that this one holds.
    const nb::gil_scoped_release unlocked;
    reader_.reset();
  }

  nb::object next() {
    auto message = guarded([&] { return reader_->next(); });
    if (!message) throw nb::stop_iteration();
    if (auto* scan = std::get_if<LaserScan>(&*message); scan != nullptr && !mounts_from_log_)
      scan->robot_T_lidar.reset();
    return to_object(std::move(*message));
  }

  template <typename Ask>
  std::invoke_result_t<Ask, const LogReader&> ask(Ask&& ask) const {
    const nb::gil_scoped_release unlocked;
    const std::lock_guard lock(mutex_);
    return ask(*reader_);
  }
  [[nodiscard]] const Robot& robot() const { return robot_; }

 private:
  [[nodiscard]] bool asked_to_stop() {
    SignalCheck* const check = check_;
    return check != nullptr && check->raised();
  }

  /// Without the lock of the interpreter, one thread at a time, until Ctrl-C.
  template <typename Work>
  std::invoke_result_t<Work> guarded(Work&& work) {
    SignalCheck check;
    const auto result = [&] {
      const nb::gil_scoped_release unlocked;
      const std::lock_guard lock(mutex_);
      check_ = &check;
      struct Reset {
        std::atomic<SignalCheck*>& at;
        ~Reset() { at = nullptr; }
      } const reset{check_};
      return std::make_unique<std::invoke_result_t<Work>>(work());
    }();
    check.throw_if_raised();
    return std::move(*result);
  }

  std::unique_ptr<LogReader> reader_{};
  Robot robot_{};
  bool mounts_from_log_;
  std::atomic<SignalCheck*> check_{nullptr};
  mutable std::mutex mutex_{};
};

LogSummary summary_of(const Log& log) {
  SignalCheck check;
  LogSummary summary = [&] {
    const nb::gil_scoped_release unlocked;
    const auto reader = log.source([&check] { return check.raised(); }).open();
    return analyse_log(*reader, [&check](const Progress&) { return !check.raised(); });
  }();
  check.throw_if_raised();
  return summary;
}

nb::dict counts_of(const LogSummary& summary) {
  nb::dict counts;
  for (const LidarSummary& lidar : summary.lidars)
    counts[nb::cast(summary.name_of(lidar))] = lidar.timing.records;
  if (summary.odometry) counts["odometry"] = summary.odometry->timing.records;
  if (summary.wheels) counts["wheels"] = summary.wheels->timing.records;
  if (summary.imu) counts["imu"] = summary.imu->timing.records;
  if (summary.camera) counts["camera"] = summary.camera->frames.records;
  return counts;
}

nb::object nanoseconds(const std::optional<Stamp>& stamp) {
  return stamp ? nb::object(nb::int_(stamp->nanoseconds)) : nb::none();
}

void bind_summary(nb::module_& m) {
  nb::class_<LogSummary> summary(m, "LogSummary", "What is in a log, as ``loopstone info`` tells.");
  summary.def_ro("format", &LogSummary::format, "The name of its format, such as ``carmen``.");
  summary.def_prop_ro("scans", &LogSummary::scans, "Of all lasers.");
  summary.def_prop_ro("duration_s", &LogSummary::duration_s,
                      "From the first message to the last [s].");
  summary.def_prop_ro(
      "first_stamp_ns", [](const LogSummary& self) { return nanoseconds(self.first); },
      nb::sig("def first_stamp_ns(self) -> int | None"), "None of a log without messages.");
  summary.def_prop_ro(
      "last_stamp_ns", [](const LogSummary& self) { return nanoseconds(self.last); },
      nb::sig("def last_stamp_ns(self) -> int | None"), "Likewise.");
  summary.def_prop_ro("counts", counts_of, nb::sig("def counts(self) -> dict[str, int]"),
                      "Records of each sensor: laser, odometry, wheels, imu, camera.");
  summary.def_prop_ro(
      "records_skipped", [](const LogSummary& self) { return self.left_out.skipped.records; },
      "Broken, repeated or out of order.");
  summary.def_prop_ro("verdict", &LogSummary::verdict,
                      "In one line: whether a map can be made of it.");
  summary.def_prop_ro(
      "findings",
      [](const LogSummary& self) {
        nb::list findings;
        for (const Finding& finding : self.findings) {
          const std::string_view word = loopstone::to_string(finding.severity);
          findings.append(
              nb::make_tuple(nb::str(word.data(), word.size()), nb::cast(finding.text)));
        }
        return findings;
      },
      nb::sig("def findings(self) -> list[tuple[str, str]]"),
      "(``note``, ``warning`` or ``error``; in words), worst first. An error means that no map\n"
      "can be made.");
  summary.def(
      "to_dict",
      [](const LogSummary& self, const std::string& log) {
        return parse_json(log_summary_json(self, log));
      },
      nb::arg("log") = "", nb::sig("def to_dict(self, log: str = '') -> dict[str, typing.Any]"),
      "All of it, as ``loopstone info --json`` prints it.");
  summary.def("__str__", &LogSummary::verdict);
  summary.def("__repr__", [](const LogSummary& self) {
    return "<LogSummary of a " + self.format + " log: " + self.verdict() + ">";
  });
}

void bind_message_stream(nb::module_& m) {
  nb::class_<Messages> messages(m, "LogMessages",
                                "An iterator over the messages of a log, in the order of time.");
  messages.def(
      "__iter__", [](nb::handle_t<Messages> self) { return nb::borrow(self); },
      nb::sig("def __iter__(self) -> LogMessages"));
  messages.def("__next__", &Messages::next,
               nb::sig("def __next__(self) -> LaserScan | OdometryPose | WheelTicks | ImuSample | "
                       "RgbdFrame"));
  messages.def_prop_ro("robot", &Messages::robot, "Mounts and wheels, as the log states them.",
                       nb::rv_policy::copy);
  messages.def_prop_ro(
      "bytes_read",
      [](const Messages& self) {
        const ReadProgress p = self.ask([](const LogReader& r) { return r.progress(); });
        return std::pair(p.bytes_done, p.bytes_total);
      },
      "(done, total) bytes of the file as stored.");
  messages.def_prop_ro(
      "records_skipped",
      [](const Messages& self) {
        return self.ask([](const LogReader& r) { return r.records_skipped(); });
      },
      "So far: broken, repeated or out of order.");
  messages.def_prop_ro(
      "notes",
      [](const Messages& self) { return self.ask([](const LogReader& r) { return r.notes(); }); },
      "What a user should know, in words; complete after the last message.");
  messages.def_prop_ro(
      "warnings",
      [](const Messages& self) {
        return self.ask([](const LogReader& r) { return r.warnings(); });
      },
      "What makes a result worse than the log could give; complete after the last message.");
  messages.def_prop_ro(
      "choices",
      [](const Messages& self) { return self.ask([](const LogReader& r) { return r.choices(); }); },
      "What was chosen where the log left a choice, in words.");
}

}  // namespace

void bind_log(nb::module_& m) {
  bind_summary(m);
  bind_message_stream(m);
  nb::class_<Log> log(
      m, "Log",
      "A log by its name, and how it is read; see :func:`loopstone.open_log`. Each iteration\n"
      "reads it from its beginning, in bounded memory.");
  log.def(
      "__init__",
      [](Log* self, const PathLike& path, const Robot* robot, bool strict,
         const std::string& stamps, bool intensities, const Topics& topics,
         const std::string& base_frame, const std::string& echo,
         const std::optional<std::pair<double, double>>& slice_m) {
        new (self) Log(
            make_log(path, robot, strict, stamps, intensities, topics, base_frame, echo, slice_m));
      },
      nb::arg("path"), nb::arg("robot") = nb::none(), nb::arg("strict") = false,
      nb::arg("stamps") = "auto", nb::arg("intensities") = false, nb::arg("topics") = Topics{},
      nb::arg("base_frame") = "", nb::arg("echo") = "first", nb::arg("slice_m") = nb::none(),
      "As :func:`loopstone.open_log` takes them. Nothing is opened yet.");
  log.def(
      "__iter__", [](const Log& self) { return std::make_unique<Messages>(self); },
      "Opens it. Raises DataError when there is nothing readable.");
  log.def_ro("path", &Log::path, "As it was given.");
  log.def_prop_ro(
      "has_robot", [](const Log& self) { return self.robot.has_value(); },
      "A robot was given, which beats what the log says of it.");
  log.def("summary", summary_of,
          "Reads it to its end and tells what is in it. Raises DataError, KeyboardInterrupt.");
  def_python(log, "save", "loopstone._api", "convert",
             "def save(self, path: str | os.PathLike[str], *, format: str | None = None, "
             "force: bool = False, progress: loopstone._progress.ProgressLike = False) -> "
             "Conversion",
             "Writes it in another format; see :func:`loopstone.convert`.");
  log.def("__repr__", [](const Log& self) { return "<Log '" + self.path + "'>"; });
}

}  // namespace loopstone::python
