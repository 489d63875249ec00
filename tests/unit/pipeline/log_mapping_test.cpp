#include "loopstone/pipeline/log_mapping.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "loopstone/base/error.hpp"
#include "loopstone/formats/log_reader.hpp"
#include "loopstone/formats/ros_map.hpp"
#include "loopstone/localization/localizer.hpp"
#include "loopstone/pipeline/log_calibration.hpp"
#include "loopstone/pipeline/log_localization.hpp"
#include "support/simulated_log.hpp"
#include "support/temp_dir.hpp"

namespace loopstone {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// A minute in an office, in a file.
class Drive {
 public:
  explicit Drive(bool upside_down) {
    SimulationOptions options{.duration_s = 60.0};
    options.laser.rate_hz = 5.0;
    options.laser.beams = 181;
    options.realism.upside_down.on = upside_down;
    const test::SimulatedLog log = test::simulate_log("office", 1, options);
    source.path = folder_ / "drive.mcap";
    const auto writer = create_log(source.path, "mcap", log.robot);
    for (const SensorMessage& message : log.messages) writer->write(message);
    writer->finish();
  }
  [[nodiscard]] LogMap map(const LogCut& cut = {}, const ReadingWatch& watch = {},
                           MappingWatch* companion = nullptr) const {
    const auto reader = source.open();
    return map_log(source, *reader, cut, {}, {}, watch, companion);
  }

  LogSource source{};

 private:
  test::TempDir folder_{};
};

void expect_same(const MapResult& a, const MapResult& b) {
  ASSERT_EQ(a.trajectory.size(), b.trajectory.size());
  for (std::size_t i = 0; i < a.trajectory.size(); ++i)
    EXPECT_EQ(a.trajectory.poses()[i].pose, b.trajectory.poses()[i].pose) << i;
}

/// What is asked of who accompanies a mapping.
class Journal final : public MappingWatch {
 public:
  void begin(Mapper& /*mapper*/, const RobotModel& robot, bool anew) override {
    events.push_back(std::string(anew ? "anew" : "begin") +
                     (!robot.lidars.empty() && robot.lidars[0].upside_down ? " upside down" : ""));
  }
  void add(const SensorMessage& message, Mapper& mapper) override {
    if (events.back() != "messages") events.emplace_back("messages");
    mapper.add(message);
  }
  void take(const MapUpdate& /*update*/, Mapper& /*mapper*/) override { ++updates; }
  void after(const SensorMessage& /*message*/, Mapper& /*mapper*/) override { ++messages; }
  void end(Mapper& /*mapper*/) override { events.emplace_back("end"); }
  void finishing(Mapper& /*mapper*/) override { events.emplace_back("finishing"); }

  std::vector<std::string> events{};
  int updates = 0;
  int messages = 0;
};

TEST(LogMapping, ALogIsMappedAsTheMapperMapsItsMessages) {
  const Drive drive(false);
  Journal journal;
  const LogMap made = drive.map({}, {}, &journal);
  EXPECT_THAT(journal.events, ElementsAre("begin", "messages", "end", "finishing"));
  EXPECT_TRUE(made.result.complete);
  EXPECT_EQ(journal.updates, static_cast<int>(made.result.trajectory.size()));
  EXPECT_THAT(made.corrections, IsEmpty());

  const auto reader = drive.source.open();
  Mapper mapper(drive.source.robot_of(*reader), {});
  int messages = 0;
  for (; const auto message = reader->next(); ++messages) mapper.add(*message);
  expect_same(made.result, mapper.finish());
  EXPECT_EQ(journal.messages, messages);
}

TEST(LogMapping, BeamsThatGoRoundTheOtherWayAreMappedAnew) {
  const Drive drive(true);
  Journal journal;
  const LogMap made = drive.map({}, {}, &journal);
  EXPECT_THAT(journal.events, ElementsAre("begin", "messages", "end", "finishing",
                                          "anew upside down", "messages", "end", "finishing"));
  EXPECT_TRUE(made.robot.lidars.at(0).upside_down);
  ASSERT_EQ(made.corrections.size(), 1U);
  EXPECT_THAT(made.result.warnings, Contains(made.corrections[0]));

  // A robot that says so is mapped once, to the same map.
  LogSource said = drive.source;
  said.robot = made.robot;
  const auto reader = said.open();
  Journal once;
  const LogMap direct = map_log(said, *reader, {}, {}, {}, {}, &once);
  EXPECT_THAT(once.events, ElementsAre("begin upside down", "messages", "end", "finishing"));
  expect_same(made.result, direct.result);
}

TEST(LogMapping, WhoCallsItOffGetsWhatThereIs) {
  const Drive drive(true);
  const LogMap made =
      drive.map({}, {.progress = [](const Progress& progress) { return progress.scans < 50; }});
  EXPECT_FALSE(made.result.complete);
  EXPECT_LE(made.result.trajectory.size(), 50U);
}

TEST(LogMapping, CalibrationTellsWhatTheMapWouldBeMadeWith) {
  const Drive drive(true);
  const auto reader = drive.source.open();
  const RobotModel told = drive.source.robot_of(*reader);
  const DrivenRobot robot = robot_as_driven(drive.source, told, {});
  EXPECT_TRUE(robot.model.lidars.at(0).upside_down);
  EXPECT_THAT(robot.warnings, Contains(HasSubstr("the laser hangs upside down")));
}

TEST(LogMapping, ALogIsLocalisedOnItsOwnMap) {
  const Drive drive(false);
  const LogMap made = drive.map();
  const LocalizationMap map(cell_states(made.result.map));
  const auto reader = drive.source.open();
  const DrivenRobot robot{.model = drive.source.robot_of(*reader)};
  const InitialPose start{made.result.trajectory.front().pose, 0.3, 0.2};
  const LogLocalization found =
      localize_log(drive.source, *reader, robot, map, {}, start, 1, {.max_scans = 100});
  EXPECT_TRUE(found.result.complete);
  EXPECT_EQ(found.result.scans, 100);
  const StampedPose2 last = found.result.trajectory().back();
  const Pose2 off = made.result.trajectory.at(last.stamp)->inverse() * last.pose;
  EXPECT_LT(off.translation().norm(), 0.1);
}

TEST(LogMapping, NothingCanBeMadeOfALogWithoutScans) {
  const Drive drive(false);
  EXPECT_THROW((void)drive.map({.start_s = 1000.0}), DataError);
}

}  // namespace
}  // namespace loopstone
