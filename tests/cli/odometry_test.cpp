#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "loopstone/formats/tum.hpp"
#include "run_program.hpp"
#include "support/temp_dir.hpp"

namespace loopstone::test {
namespace {

using testing::HasSubstr;

/// A small CARMEN log: a robot that drives straight at 0.5 m/s and scans ten times a second.
std::string small_log(int scans = 20) {
  std::string text = "# a small log\n";
  for (int i = 0; i < scans; ++i) {
    const double t = 1000.0 + 0.1 * i;
    const double x = 0.05 * i;
    text += fmt::format("ODOM {:.6f} 0 0 0.5 0 0 {:.6f} host {:.6f}\n", x, t, t);
    text += "FLASER 5 1 2 3 2 1 ";
    text += fmt::format("{0:.6f} 0 0 {0:.6f} 0 0 {1:.6f} host {1:.6f}\n", x, t + 0.01);
  }
  return text;
}

TEST(OdometryCommand, WritesAPoseForEveryScan) {
  const TempDir folder;
  const std::string log = folder.write("small.clf", small_log());
  const std::string out = folder / "odometry.tum";
  const ProgramResult result = run_program({"odometry", log, "-o", out, "--json", "--quiet"});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  EXPECT_EQ(result.error, "");
  const auto json = nlohmann::json::parse(result.out);
  EXPECT_EQ(json.at("poses"), 20);
  EXPECT_EQ(json.at("scans"), 20);
  EXPECT_NEAR(json.at("path_length_m").get<double>(), 0.95, 0.06);
  EXPECT_EQ(json.at("complete"), true);
  const Trajectory trajectory = read_tum(out);
  ASSERT_EQ(trajectory.size(), 20u);
  EXPECT_EQ(trajectory.front().stamp.nanoseconds, 1000'010'000'000);
}

TEST(OdometryCommand, TableHasUnits) {
  const TempDir folder;
  const std::string log = folder.write("small.clf", small_log());
  const ProgramResult result = run_program({"odometry", log, "-o", folder / "o.tum"});
  EXPECT_THAT(result.out, HasSubstr(" m\n"));
  EXPECT_THAT(result.out, HasSubstr("path"));
}

TEST(OdometryCommand, BadLogsLeaveNothingBehind) {
  const TempDir folder;
  const std::string out = folder / "odometry.tum";
  const std::string empty = folder.write("empty.clf", "");
  const std::string rubbish = folder.write("rubbish.clf", std::string(1000, '\x9c'));
  for (const std::string& log : {folder / "missing.clf", empty, rubbish}) {
    const ProgramResult result = run_program({"odometry", log, "-o", out});
    EXPECT_EQ(result.exit_code, 1) << log;
    EXPECT_THAT(result.error, HasSubstr(log));
    EXPECT_EQ(count_lines(result.error), 1u) << result.error;
  }
  EXPECT_THAT(folder.names(), testing::ElementsAre("empty.clf", "rubbish.clf"));
}

TEST(OdometryCommand, UnwritableOutputIsAnErrorThatNamesIt) {
  const TempDir folder;
  const std::string log = folder.write("small.clf", small_log());
  const std::string out = folder / "no/such/folder/odometry.tum";
  const ProgramResult result = run_program({"odometry", log, "-o", out});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.error, HasSubstr(out));
  EXPECT_EQ(run_program({"odometry", log, "-o", folder.path().string()}).exit_code, 2);
  EXPECT_THAT(folder.names(), testing::ElementsAre("small.clf"));
}

TEST(OdometryCommand, BadRobotFileIsRefusedBeforeAnythingIsDone) {
  const TempDir folder;
  const std::string log = folder.write("small.clf", small_log());
  const std::string robot =
      folder.write("robot.toml", "[wheels]\ntrack = 3\nmetres_per_count = 0\n");
  const ProgramResult result =
      run_program({"odometry", log, "-o", folder / "o.tum", "--robot", robot});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.error, HasSubstr(robot + ":2: wheels.track"));
  EXPECT_THAT(result.error, HasSubstr(robot + ":3: wheels.metres_per_count"));
  EXPECT_THAT(folder.names(), testing::ElementsAre("robot.toml", "small.clf"));
}

}  // namespace
}  // namespace loopstone::test
