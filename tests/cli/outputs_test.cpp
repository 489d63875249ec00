// What commands write: nothing that is read, nothing that is there already, nothing half done that
// looks whole.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "run_program.hpp"
#include "support/temp_dir.hpp"

namespace loopstone::test {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;
using testing::HasSubstr;
using Words = std::vector<std::string>;

Words operator+(Words words, const Words& more) {
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

class OutputFiles : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TempDir;
    ASSERT_EQ(run_program({"simulate", "office", "-o", *folder_ / "sim", "--duration", "4",
                           "--beams", "121", "--fov", "180", "--seed", "5", "--quiet"})
                  .exit_code,
              0);
    ASSERT_EQ(run_program({"convert", *folder_ / "sim", *folder_ / "log.clf", "--quiet"}).exit_code,
              0);
    (void)folder_->write("a.g2o",
                         "VERTEX_SE2 0 0 0 0\nVERTEX_SE2 1 1 0 0\n"
                         "EDGE_SE2 0 1 1 0 0 1 0 0 1 0 1\n");
    fs::create_hard_link(*folder_ / "log.clf", *folder_ / "hard.clf");
    fs::create_symlink(*folder_ / "log.clf", *folder_ / "soft.clf");
  }
  static void TearDownTestSuite() { delete folder_; }

  static std::string sim() { return *folder_ / "sim"; }
  static std::string log() { return *folder_ / "log.clf"; }
  static std::string graph() { return *folder_ / "a.g2o"; }
  static std::string map() { return sim() + "/map.yaml"; }

  static void expect_refused(const Words& arguments, const char* why) {
    const ProgramResult result = run_program(arguments);
    EXPECT_EQ(result.exit_code, 2) << result.error;
    EXPECT_THAT(result.error, HasSubstr(why));
    EXPECT_EQ(count_lines(result.error), 1u) << result.error;
  }

  static TempDir* folder_;
};

TempDir* OutputFiles::folder_ = nullptr;

TEST_F(OutputFiles, WhatIsReadIsNeverWrittenNotEvenByForce) {
  const std::string log_bytes = folder_->read("log.clf");
  const std::string scans = folder_->read("sim/Hokuyo20.npz");
  const std::string true_map = folder_->read("sim/map.pgm");
  const std::string scan = log() + "#5";
  const std::vector<Words> commands{
      {"odometry", log(), "-o", log()},
      {"odometry", log(), "-o", *folder_ / "hard.clf"},
      {"odometry", log(), "-o", *folder_ / "soft.clf"},
      {"odometry", *folder_ / "soft.clf", "-o", log()},
      {"odometry", log(), "-o", *folder_ / "sim/../log.clf"},
      {"odometry", sim(), "-o", sim() + "/Hokuyo20.npz"},
      {"odometry", sim() + "#20", "-o", sim() + "/Encoders20.npz"},
      {"localize", log(), "--map", map(), "--global", "-o", log()},
      {"localize", log(), "--map", map(), "--global", "-o", sim() + "/map.pgm"},
      {"localize", log(), "--map", sim(), "--global", "-o", *folder_ / "w.tum", "--report", sim()},
      {"match", scan, map(), "--global", "--png", log()},
      {"match", scan, map(), "--global", "--png", sim() + "/map.pgm"},
      {"match", sim() + "#3", sim() + "#4", "--png", sim() + "/Hokuyo20.npz"},
      {"optimize", graph(), "-o", graph()},
      {"optimize", graph(), "--tum", graph()},
      {"convert", log(), *folder_ / "hard.clf"},
      {"convert", sim(), sim() + "#20"},
      {"map", sim(), "-o", sim()},
      {"map", log(), "-o", folder_->path().string()},
      {"simulate", map(), "-o", sim()},
      {"texture", sim(), "--trajectory", sim() + "/truth.tum", "-o", sim()},
  };
  for (const Words& words : commands) {
    SCOPED_TRACE(words[0] + " " + words.back());
    expect_refused(words + Words{"--force"}, "what this command reads");
  }
  EXPECT_TRUE(folder_->read("log.clf") == log_bytes);
  EXPECT_TRUE(folder_->read("sim/Hokuyo20.npz") == scans);
  EXPECT_TRUE(folder_->read("sim/map.pgm") == true_map);
}

TEST_F(OutputFiles, WhatExistsIsReplacedOnlyByForce) {
  const TempDir dir;
  const std::vector<Words> commands{
      {"odometry", log(), "-o", dir / "out.tum"},
      {"localize", log(), "--map", map(), "--initial", "0,0,0", "--max-scans", "3", "-o",
       dir / "where.tum"},
      {"match", log() + "#5", log() + "#4", "--png", dir / "match.png"},
      {"match", log() + "#5", log() + "#4", "--aligned", dir / "aligned.ply"},
      {"optimize", graph(), "-o", dir / "solved.g2o"},
      {"optimize", graph(), "--edges", dir / "edges.csv"},
      {"convert", sim(), dir / "copy.clf"},
  };
  for (const Words& words : commands) {
    const std::string name = fs::path(words.back()).filename().string();
    SCOPED_TRACE(words[0] + " " + name);
    dir.write(name, "precious");
    expect_refused(words, "--force");
    EXPECT_EQ(dir.read(name), "precious");
    const ProgramResult forced = run_program(words + Words{"--force", "--quiet"});
    EXPECT_EQ(forced.exit_code, 0) << forced.error;
    EXPECT_NE(dir.read(name), "precious");
  }
  // The table beside a trajectory is an output as well.
  fs::remove(dir / "where.tum");
  dir.write("where.csv", "precious");
  expect_refused({"localize", log(), "--map", map(), "--global", "-o", dir / "where.tum"},
                 "where.csv: exists");
}

TEST_F(OutputFiles, APipeIsWrittenTo) {
  const ProgramResult result = run_program({"odometry", log(), "-o", "/dev/null", "--quiet"});
  EXPECT_EQ(result.exit_code, 0) << result.error;
}

TEST_F(OutputFiles, AnotherSetMayComeIntoTheFolderThatIsRead) {
  EXPECT_EQ(run_program({"convert", sim() + "#20", sim() + "#21", "--quiet"}).exit_code, 0);
  expect_refused({"convert", sim() + "#20", sim() + "#21"}, "Encoders21.npz: exists");
  for (const char* const sensor : {"Encoders21.npz", "Imu21.npz", "Hokuyo21.npz"})
    fs::remove(sim() + "/" + sensor);
}

TEST_F(OutputFiles, EachOutputNeedsAPlaceOfItsOwn) {
  const TempDir dir;
  const Words localize{"localize", log(), "--map", map(), "--global"};
  expect_refused(
      localize + Words{"-o", dir / "w.tum", "--report", dir / "r", "--animation", dir / "r/"},
      "is named for two outputs");
  fs::create_directory(dir / "r");
  expect_refused(localize + Words{"-o", dir / "r/w.tum", "--report", dir / "r"},
                 "lies in the folder of --report");
  expect_refused({"odometry", log(), "-o", dir / "r"}, "is a folder");
  expect_refused({"odometry", log(), "-o", ""}, "is empty");
}

TEST_F(OutputFiles, AFolderThatTakesNoFilesIsFoundOutBeforeTheWork) {
  // The log is broken, which would be said first if the work had begun.
  const std::string broken = folder_->write("broken.clf", "FLASER 3 1 2\n");
  const ProgramResult file = run_program({"odometry", broken, "--strict", "-o", "/proc/out.tum"});
  EXPECT_EQ(file.exit_code, 1);
  EXPECT_THAT(file.error, HasSubstr("/proc/out.tum: cannot create this file"));
  const ProgramResult whole = run_program({"map", broken, "--strict", "-o", "/proc/out"});
  EXPECT_EQ(whole.exit_code, 1);
  EXPECT_THAT(whole.error, HasSubstr("/proc/out: cannot create this file"));
}

TEST_F(OutputFiles, WhatAKilledRunLeftIsNothingAndGoes) {
  const TempDir dir;
  const pid_t child = ::fork();
  if (child == 0) ::_exit(0);
  ::waitpid(child, nullptr, 0);
  const std::string dead = std::to_string(child);
  fs::create_directory(dir / "out");
  dir.write("out/.map.png." + dead + "-0.partial", "half");
  dir.write(".out.tum." + dead + "-3.partial", "half");
  ASSERT_EQ(run_program({"map", log(), "-o", dir / "out", "--quiet"}).exit_code, 0);
  ASSERT_EQ(run_program({"odometry", log(), "-o", dir / "out.tum", "--quiet"}).exit_code, 0);
  EXPECT_FALSE(fs::exists(dir / ("out/.map.png." + dead + "-0.partial")));
  EXPECT_EQ(dir.names(), (Words{"out", "out.tum"}));
}

TEST_F(OutputFiles, AnOlderSimulationLeavesNoMixture) {
  const TempDir dir;
  const Words simulate{"simulate", "rooms",   "-o", dir / "sim", "--duration",
                       "1",        "--beams", "3",  "--quiet"};
  ASSERT_EQ(run_program(simulate).exit_code, 0);
  ASSERT_EQ(run_program(simulate + Words{"--format", "carmen", "--force"}).exit_code, 0);
  EXPECT_TRUE(fs::exists(dir / "sim/log.clf"));
  EXPECT_FALSE(fs::exists(dir / "sim/Hokuyo20.npz"));
}

/// Ten scans in half a hall of 70 m. Odometry goes on by so much along both axes from scan to scan.
std::string hall_log(double step_m) {
  std::string text;
  for (int scan = 0; scan < 10; ++scan) {
    text += "FLASER 180";
    for (int i = 0; i < 180; ++i) text += " " + std::to_string(70.0 + 0.01 * ((i + scan) % 50));
    const std::string stamp = std::to_string(100.0 + 0.2 * scan);
    const std::string place = std::to_string(scan * step_m);
    text += " " + place + " " + place + " 0 " + place + " " + place + " 0 ";
    text += stamp + " host " + stamp + "\n";
  }
  return text;
}

TEST_F(OutputFiles, AMapThatIsTooLargeIsDrawnWithWiderCells) {
  const TempDir dir;
  const std::string hall = dir.write("hall.clf", hall_log(0.0));
  const ProgramResult result =
      run_program({"map", hall, "-o", dir / "out", "--set", "map.resolution_m=0.005", "--set",
                   "map.max_range_m=80", "--set", "front_end.range_max_m=80", "--quiet"});
  EXPECT_EQ(result.exit_code, 0) << result.error;
  EXPECT_THAT(result.error, HasSubstr("0.01 m wide, not 0.005 m as asked"));
  EXPECT_THAT(dir.read("out/map.yaml"), HasSubstr("resolution: 0.01\n"));
}

TEST_F(OutputFiles, AMapThatIsTooLargeHoweverWideItsCellsLeavesTrajectoryAndGraph) {
  const TempDir dir;
  const std::string hall = dir.write("hall.clf", hall_log(3000.0));
  const ProgramResult result =
      run_program({"map", hall, "-o", dir / "out", "--odometry", "trust", "--set",
                   "map.max_range_m=80", "--set", "front_end.range_max_m=80", "--quiet"});
  EXPECT_EQ(result.exit_code, 1) << result.out;
  EXPECT_THAT(result.error, HasSubstr("the map would be"));
  EXPECT_EQ(count_lines(dir.read("out/trajectory.tum")), 10u);
  EXPECT_TRUE(fs::exists(dir / "out/graph.g2o"));
  EXPECT_EQ(Json::parse(dir.read("out/summary.json")).at("complete"), false);
}

TEST_F(OutputFiles, ALogThatShrinksWhileItIsReadIsSaid) {
  const TempDir dir;
  fs::copy_file(log(), dir / "log.clf");
  const auto size = fs::file_size(dir / "log.clf");
  const ProgramResult result =
      disturb_program(dir / "out", [&] { fs::resize_file(dir / "log.clf", size / 2); },
                      {"map", dir / "log.clf", "-o", dir / "out", "--realtime", "8", "--quiet"});
  EXPECT_EQ(result.exit_code, 0) << result.error;
  const std::string sizes =
      "shrank while it was read, from " + std::to_string(size) + " to " + std::to_string(size / 2);
  EXPECT_THAT(result.error, HasSubstr(sizes));
  EXPECT_THAT(dir.read("out/summary.json"), HasSubstr(sizes));
}

}  // namespace
}  // namespace loopstone::test
