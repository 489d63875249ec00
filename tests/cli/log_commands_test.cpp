// simulate, info, convert and odometry, one after the other on the same small log, and each with
// bad input.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "loopstone/formats/tum.hpp"
#include "run_program.hpp"
#include "support/temp_dir.hpp"

namespace loopstone::test {
namespace {

using testing::HasSubstr;

nlohmann::json run_json(std::vector<std::string> arguments) {
  arguments.insert(arguments.end(), {"--json", "--quiet"});
  const ProgramResult result = run_program(arguments);
  EXPECT_EQ(result.exit_code, 0) << result.error;
  return nlohmann::json::parse(result.out, nullptr, false);
}

class LogCommands : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TempDir;
    const auto result = run_json({"simulate", "office", "-o", log(), "--duration", "5", "--beams",
                                  "181", "--fov", "180", "--seed", "3"});
    ASSERT_FALSE(result.is_discarded());
  }
  static void TearDownTestSuite() { delete folder_; }
  static std::string log() { return *folder_ / "sim"; }

  static std::size_t scans() { return read_tum(log() + "/truth.tum").size(); }

  static TempDir* folder_;
};

TempDir* LogCommands::folder_ = nullptr;

TEST_F(LogCommands, SimulateLeavesLogTruthAndMap) {
  for (const char* name : {"Encoders20.npz", "Hokuyo20.npz", "Imu20.npz", "truth.tum", "map.yaml",
                           "map.pgm", "world.json"}) {
    EXPECT_TRUE(std::filesystem::exists(log() + "/" + name)) << name;
  }
  EXPECT_NEAR(static_cast<double>(scans()), 50.0, 2.0) << "ten a second for five seconds";
}

TEST_F(LogCommands, SimulateGivesTheSameBytesForTheSameSeed) {
  const TempDir folder;
  const std::vector<std::string> same{"simulate",   "office", "-o",      folder / "again",
                                      "--duration", "5",      "--beams", "181",
                                      "--fov",      "180",    "--seed",  "3"};
  (void)run_json(same);
  EXPECT_EQ(folder.read("again/truth.tum"), folder_->read("sim/truth.tum"));
  EXPECT_EQ(folder.read("again/Hokuyo20.npz"), folder_->read("sim/Hokuyo20.npz"));
}

TEST_F(LogCommands, SimulateRefusesAFolderInUseAndUnknownWorlds) {
  EXPECT_EQ(run_program({"simulate", "office", "-o", log()}).exit_code, 2);
  const TempDir folder;
  const ProgramResult result = run_program({"simulate", "offise", "-o", folder / "out"});
  EXPECT_NE(result.exit_code, 0);
  EXPECT_THAT(result.error, HasSubstr("offise"));
  EXPECT_TRUE(folder.names().empty());
}

TEST_F(LogCommands, InfoShowsWhatIsInTheLog) {
  const auto json = run_json({"info", log()});
  EXPECT_EQ(json.at("format"), "ucsd");
  const ProgramResult text = run_program({"info", log()});
  EXPECT_EQ(text.exit_code, 0);
  EXPECT_THAT(text.out, HasSubstr("181"));
}

TEST_F(LogCommands, InfoKnowsTheFormatsWithoutALog) {
  const auto formats = run_json({"info", "--formats"}).at("formats");
  ASSERT_GE(formats.size(), 2u);
  const ProgramResult text = run_program({"info", "--formats"});
  EXPECT_EQ(text.exit_code, 0) << text.error;
  const ProgramResult help = run_program({"convert", "--help"});
  for (const auto& format : formats) {
    EXPECT_THAT(text.out, HasSubstr(format.at("noun").get<std::string>()));
    if (format.at("written")) {
      EXPECT_THAT(help.out, HasSubstr(format.at("noun").get<std::string>()));
    }
  }
  EXPECT_EQ(run_program({"info"}).exit_code, 2) << "else a log is needed";
}

/// Each format, as `--format` calls it, from simulation to conversion.
TEST_F(LogCommands, EveryWrittenFormatIsSimulatedToldAndConverted) {
  const TempDir folder;
  const auto formats = run_json({"info", "--formats"});
  for (const auto& format : formats.at("formats")) {
    if (!format.at("written")) continue;
    const auto name = format.at("name").get<std::string>();
    const auto made = run_json({"simulate", "office", "-o", folder / name, "--format", name,
                                "--duration", "3", "--beams", "181", "--fov", "180"});
    EXPECT_EQ(made.at("format"), name);
    const auto log = made.at("log").get<std::string>();
    const auto told = run_json({"info", log});
    EXPECT_EQ(told.at("format"), name);
    EXPECT_EQ(told.at("scans"), made.at("scans"));
    for (const auto& other : formats.at("formats")) {
      if (!other.at("written")) continue;
      const auto to = other.at("name").get<std::string>();
      const std::string out = folder / (name + "_as_" + to);
      EXPECT_EQ(run_json({"convert", log, out, "--format", to}).at("format"), to);
      EXPECT_EQ(run_json({"info", out}).at("format"), to);
      EXPECT_EQ(run_json({"info", out}).at("scans"), made.at("scans"));
    }
  }
}

TEST_F(LogCommands, ConvertedLogsHaveTheSameOdometry) {
  const std::string carmen = *folder_ / "sim.clf";
  const auto converted = run_json({"convert", log(), carmen});
  EXPECT_EQ(converted.at("scans"), scans());
  const auto before = run_json({"odometry", log(), "-o", *folder_ / "before.tum"});
  const auto after = run_json({"odometry", carmen, "-o", *folder_ / "after.tum"});
  EXPECT_EQ(before.at("poses"), after.at("poses"));
  const auto error = run_json(
      {"evaluate", "--estimate", *folder_ / "after.tum", "--reference", *folder_ / "before.tum"});
  EXPECT_LT(error.at("ate_rmse_m").get<double>(), 0.01);
  EXPECT_EQ(run_program({"convert", log(), carmen}).exit_code, 2) << "there is one already";
}

TEST_F(LogCommands, QuietLeavesOutWhatIsToldOfAFewBrokenRecords) {
  const TempDir folder;
  (void)run_json({"convert", log(), folder / "whole.clf"});
  const std::string path =
      folder.write("broken.clf", "ODOM 1 2 broken\n" + folder.read("whole.clf"));
  const ProgramResult told = run_program({"convert", path, folder / "told.clf"});
  EXPECT_EQ(told.exit_code, 0) << told.error;
  EXPECT_THAT(told.error, HasSubstr("1 of"));
  const ProgramResult quiet = run_program({"convert", path, folder / "quiet.clf", "--quiet"});
  EXPECT_EQ(quiet.exit_code, 0);
  EXPECT_EQ(quiet.error, "");
  // The result is what was asked for, as of every command.
  EXPECT_THAT(quiet.out, HasSubstr("records skipped"));
}

TEST_F(LogCommands, OdometryStaysNearTheTruthForAWhile) {
  (void)run_json({"odometry", log(), "-o", *folder_ / "odometry.tum"});
  const auto error = run_json(
      {"evaluate", "--estimate", *folder_ / "odometry.tum", "--reference", log() + "/truth.tum"});
  EXPECT_LT(error.at("ate_rmse_m").get<double>(), 0.1);
  EXPECT_EQ(error.at("poses"), scans());
}

TEST_F(LogCommands, AMapAtTheLogsOwnPaceIsTheSameAndTellsHowLongPosesTook) {
  const TempDir folder;
  const auto at_once = run_json({"map", log(), "-o", folder / "fast"});
  const auto paced = run_json({"map", log(), "-o", folder / "paced", "--realtime", "10"});
  EXPECT_EQ(folder.read("paced/trajectory.tum"), folder.read("fast/trajectory.tum"));
  EXPECT_FALSE(at_once.contains("realtime"));
  ASSERT_TRUE(paced.contains("realtime"));
  const auto& figures = paced["realtime"];
  EXPECT_EQ(figures["speed"], 10.0);
  EXPECT_GE(figures["median_latency_s"], 0.0);
  EXPECT_GE(figures["p99_latency_s"], figures["median_latency_s"]);
  EXPECT_GE(figures["worst_latency_s"], figures["p99_latency_s"]);
  EXPECT_GE(figures["worst_computing_s"], figures["p99_computing_s"]);
  EXPECT_GE(figures["median_latency_s"], figures["median_computing_s"])
      << "waiting for odometry is part of it";
  // Five seconds at ten times their pace.
  EXPECT_GE(paced["wall_time_s"], 0.45);
}

TEST_F(LogCommands, TheTextbookPipelineHasNoPace) {
  const TempDir folder;
  const ProgramResult result = run_program(
      {"map", log(), "-o", folder / "out", "--pipeline", "scan_to_scan", "--realtime", "1"});
  EXPECT_EQ(result.exit_code, 2) << result.error;
  EXPECT_THAT(result.error, HasSubstr("--realtime"));
  EXPECT_FALSE(std::filesystem::exists(folder / "out"));
}

TEST_F(LogCommands, MissingLogsAreNamedAndLeaveNothing) {
  const TempDir folder;
  for (const std::vector<std::string>& arguments : std::vector<std::vector<std::string>>{
           {"info", "/no/such/log"},
           {"convert", "/no/such/log", folder / "out.clf"},
           {"odometry", "/no/such/log", "-o", folder / "out.tum"}}) {
    const ProgramResult result = run_program(arguments);
    EXPECT_EQ(result.exit_code, 1);
    EXPECT_THAT(result.error, HasSubstr("/no/such/log"));
    EXPECT_EQ(count_lines(result.error), 1u) << result.error;
  }
  EXPECT_TRUE(folder.names().empty());
}

}  // namespace
}  // namespace loopstone::test
