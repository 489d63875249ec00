#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "loopstone/formats/image.hpp"
#include "loopstone/formats/localization_csv.hpp"
#include "loopstone/formats/ros_map.hpp"
#include "loopstone/formats/tum.hpp"
#include "office_command.hpp"
#include "run_program.hpp"
#include "support/temp_dir.hpp"

namespace loopstone::test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using Json = nlohmann::json;

class LocalizeCommand : public OfficeCommand {
 protected:
  static std::string initial(double off_m = 0.1) {
    const Pose2& pose = truth_.front().pose;
    return fmt::format("{},{},{}", pose.x + off_m, pose.y - off_m, pose.yaw + 0.02);
  }
  /// localize LOG --map MAP and the rest.
  static ProgramResult localize(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"localize", log_, "--map", map_});
    return run_program(arguments);
  }
  static void expect_near_truth(const Trajectory& estimate, double most_m) {
    for (const StampedPose2& stamped : estimate.poses()) {
      const Pose2 truth = truth_.at_clamped(stamped.stamp).value();
      EXPECT_LT(std::hypot(stamped.pose.x - truth.x, stamped.pose.y - truth.y), most_m);
      EXPECT_LT(std::abs(wrap_angle(stamped.pose.yaw - truth.yaw)), 0.05);
    }
  }
};

TEST_F(LocalizeCommand, FollowsTheRobotFromAGuess) {
  const TempDir out;
  const ProgramResult result =
      localize({"-o", out / "where.tum", "--initial", initial(), "--json", "--quiet"});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  EXPECT_EQ(result.error, "");
  const Json json = Json::parse(result.out);
  EXPECT_EQ(json.at("start"), "initial");
  EXPECT_EQ(json.at("poses"), truth_.size());
  EXPECT_EQ(json.at("complete"), true);
  EXPECT_GT(json.at("tracking_share").get<double>(), 0.5);
  for (const char* key :
       {"path_length_m", "duration_s", "doubtful_share", "lost_share", "searches",
        "probability_mean", "wall_time_s", "cpu_time_s", "peak_memory_bytes", "map_free_area_m2"}) {
    EXPECT_TRUE(json.at(key).is_number()) << key;
  }
  const Trajectory trajectory = read_tum(out / "where.tum");
  ASSERT_EQ(trajectory.size(), truth_.size());
  expect_near_truth(trajectory, 0.2);
  const auto estimates = read_localization_csv(out / "where.csv");
  ASSERT_EQ(estimates.size(), truth_.size());
  EXPECT_EQ(estimates.back().stamp, trajectory.back().stamp);
  EXPECT_NEAR(estimates.back().travelled_m, json.at("path_length_m").get<double>(), 1e-6);
  EXPECT_EQ(out.names(), (std::vector<std::string>{"where.csv", "where.tum"}));
}

TEST_F(LocalizeCommand, FindsTheRobotFromNowhere) {
  const TempDir out;
  const ProgramResult result = localize({"-o", out / "where.tum", "--global", "--json", "--quiet"});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  const Json json = Json::parse(result.out);
  EXPECT_EQ(json.at("start"), "global");
  EXPECT_GE(json.at("searches_of_whole_map").get<int>(), 1);
  const StampedPose2 last = read_tum(out / "where.tum").back();
  const Pose2 truth = truth_.at_clamped(last.stamp).value();
  EXPECT_LT(std::hypot(last.pose.x - truth.x, last.pose.y - truth.y), 0.2);
}

TEST_F(LocalizeCommand, TableHasUnits) {
  const TempDir out;
  const ProgramResult result = localize({"-o", out / "where.tum", "--initial", initial()});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  for (const char* text : {"scans", " m\n", "TRACKING", "% of the time", "first TRACKING",
                           "x real time", "where.csv"}) {
    EXPECT_THAT(result.out, HasSubstr(text));
  }
}

TEST_F(LocalizeCommand, ReportAndAnimation) {
  const TempDir out;
  const std::vector<std::string> arguments{
      "-o",          out / "where.tum", "--global", "--report", out / "report",
      "--animation", out / "film",      "--quiet",  "--set",    "snapshot_distance_m=1"};
  const ProgramResult result = localize(arguments);
  ASSERT_EQ(result.exit_code, 0) << result.error;
  EXPECT_THAT(result.out, HasSubstr("report/report.html"));
  for (const char* name : {"report.html", "map.png", "summary.json", "options.toml",
                           "trajectory.tum", "localization.csv"}) {
    EXPECT_TRUE(fs::exists(out / ("report/" + std::string(name)))) << name;
  }
  EXPECT_EQ(out.read("report/trajectory.tum"), out.read("where.tum"));
  EXPECT_EQ(out.read("report/localization.csv"), out.read("where.csv"));
  EXPECT_THAT(out.read("report/options.toml"), HasSubstr("snapshot_distance_m = 1"));
  const Json summary = Json::parse(out.read("report/summary.json"));
  EXPECT_EQ(summary.at("map"), map_);
  EXPECT_GT(read_image(out / "film/000001.png").width, 500);
  EXPECT_TRUE(fs::exists(out / "film/000003.png")) << "a metre apart on a path of some metres";
  // Neither folder is written into again without being told to.
  EXPECT_EQ(localize(arguments).exit_code, 2);
  std::vector<std::string> forced = arguments;
  forced.emplace_back("--force");
  EXPECT_EQ(localize(forced).exit_code, 0);
}

TEST_F(LocalizeCommand, SameSeedSameBytesWithAnyThreads) {
  const TempDir out;
  const auto run = [&](const std::string& name, const std::string& seed,
                       const std::string& threads) {
    const ProgramResult result = localize({"-o", out / (name + ".tum"), "--global", "--seed", seed,
                                           "--threads", threads, "--quiet", "--particles", "500"});
    EXPECT_EQ(result.exit_code, 0) << result.error;
    return out.read(name + ".tum") + out.read(name + ".csv");
  };
  const std::string one = run("one", "5", "1");
  EXPECT_EQ(one, run("again", "5", "1"));
  EXPECT_EQ(one, run("many", "5", "4"));
  EXPECT_NE(one, run("other", "6", "1"));
}

TEST_F(LocalizeCommand, MapOfOurOwnAndCutsOfTheLog) {
  const TempDir out;
  ASSERT_EQ(run_program({"map", log_, "-o", out / "map", "--quiet"}).exit_code, 0);
  // The map's frame begins where the log did.
  const ProgramResult result = run_program(
      {"localize", log_, "--map", out / "map", "-o", out / "where.tum", "--initial", "0,0,0",
       "--start", "0", "--duration", "6", "--max-scans", "40", "--json", "-q"});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  EXPECT_EQ(Json::parse(result.out).at("scans"), 40);
  EXPECT_EQ(read_tum(out / "where.tum").size(), 40u);
}

TEST_F(LocalizeCommand, RequirementsAreExitCode3) {
  const TempDir out;
  const std::vector<std::string> arguments{"-o",      out / "w.tum", "--initial",
                                           initial(), "--quiet",     "--force"};
  const auto with = [&](const std::string& bound) {
    std::vector<std::string> all = arguments;
    all.insert(all.end(), {"--require", bound});
    return localize(all);
  };
  EXPECT_EQ(with("poses>=10").exit_code, 0);
  const ProgramResult missed = with("poses<=10");
  EXPECT_EQ(missed.exit_code, 3);
  EXPECT_THAT(missed.error, HasSubstr("bound missed: poses is"));
  EXPECT_EQ(with("traking_share>=0.1").exit_code, 2);
  EXPECT_EQ(with("tracking_share").exit_code, 2);
  EXPECT_EQ(with("last_pose.probability>=0").exit_code, 0);
}

TEST_F(LocalizeCommand, OddGuessesAreWarnedOf) {
  const TempDir out;
  const auto warning_of = [&](const std::string& pose) {
    const ProgramResult result = localize(
        {"-o", out / "w.tum", "--initial", pose, "--max-scans", "2", "--quiet", "--force"});
    EXPECT_EQ(result.exit_code, 0) << result.error;
    return result.error;
  };
  EXPECT_THAT(warning_of("500,2,0"), HasSubstr("--initial 500,2 lies outside the map, which goes"));
  const CellStates map = read_ros_map(map_);
  const auto wall = std::find(map.cells().begin(), map.cells().end(), kOccupiedCell);
  const auto index = static_cast<int>(wall - map.cells().begin());
  const Eigen::Vector2d in_wall =
      map.frame().centre_of({index % map.frame().columns, index / map.frame().columns});
  EXPECT_THAT(warning_of(fmt::format("{},{},0", in_wall.x(), in_wall.y())),
              HasSubstr("lies in a wall of the map"));
  EXPECT_EQ(warning_of(initial()).find("lies"), std::string::npos);
}

TEST_F(LocalizeCommand, CtrlCWritesWhatThereIs) {
  const TempDir out;
  // So many particles that it takes long; the report's folder is made when the work begins.
  const ProgramResult result = interrupt_program(
      out / "report",
      {"localize", log_, "--map", map_, "-o", out / "where.tum", "--initial", initial(), "--report",
       out / "report", "--set", "particles_max=200000", "--set", "particles_min=100000", "--set",
       "update_distance_m=0", "--set", "update_angle_rad=0", "--json"});
  EXPECT_EQ(result.exit_code, 130) << result.error;
  const Json json = Json::parse(result.out);
  EXPECT_EQ(json.at("complete"), false);
  EXPECT_LT(json.at("scans").get<std::size_t>(), truth_.size());
  EXPECT_THAT(result.error, HasSubstr("interrupted"));
  EXPECT_TRUE(fs::exists(out / "where.csv"));
  EXPECT_THAT(out.read("report/report.html"), HasSubstr("Incomplete"));
}

TEST_F(LocalizeCommand, BadUsageIsOneLineThatSaysWhatToDo) {
  const TempDir out;
  const std::string tum = out / "where.tum";
  const std::string empty = out.write("empty.clf", "");
  const std::string no_scan = out.write("odom.clf", "ODOM 0 0 0 0 0 0 1000.0 host 1000.0\n");
  const std::string blank = out.write("blank.pgm", "P5\n4 4\n255\n" + std::string(16, '\xfe'));
  const std::string blank_map =
      out.write("blank.yaml",
                "image: blank.pgm\nresolution: 0.1\norigin: [0, 0, 0]\nnegate: 0\n"
                "occupied_thresh: 0.65\nfree_thresh: 0.196\n");
  const std::size_t files = out.names().size();
  const auto expect = [&](std::vector<std::string> arguments, int code, const char* text) {
    arguments.insert(arguments.begin(), "localize");
    const ProgramResult result = run_program(arguments);
    EXPECT_EQ(result.exit_code, code) << result.error;
    EXPECT_THAT(result.error, HasSubstr(text));
    EXPECT_EQ(count_lines(result.error), 1u) << result.error;
    EXPECT_EQ(result.out, "");
  };
  expect({log_, "--map", map_, "-o", tum}, 2, "--initial X,Y,YAW if that is about known");
  expect({log_, "--map", map_, "-o", tum, "--global", "--initial", "0,0,0"}, 2,
         "exclude each other");
  expect({log_, "--map", map_, "-o", tum, "--global", "--initial-sigma", "1,1"}, 2,
         "--global has none");
  expect({log_, "--map", map_, "-o", tum, "--initial", "1,2"}, 2, "must be X,Y,YAW");
  expect({log_, "--map", map_, "-o", tum, "--initial", "1,b,2"}, 2, "'b' is no number");
  expect({log_, "--map", map_, "-o", tum, "--initial", "1,2,3", "--initial-sigma", "0,1"}, 2,
         "both above 0");
  expect({log_, "--map", map_, "-o", tum, "--global", "--particles", "1"}, 2, "--particles");
  expect({log_, "--map", map_, "-o", tum, "--global", "--set", "partcles_max=9"}, 2,
         "did you mean particles_max?");
  expect({log_, "--map", map_, "-o", out / "x.csv", "--global"}, 2, "name this one .tum");
  expect({log_, "--map", map_, "-o", out / "", "--global"}, 2, "is a folder");
  expect({log_, "--map", map_, "-o", out / "no/where.tum", "--global"}, 1, "there is no folder");
  expect(
      {log_, "--map", map_, "-o", tum, "--global", "--report", out / "r", "--animation", out / "r"},
      2, "each needs its own");
  expect({log_, "--map", map_, "-o", tum, "--global", "--start", "-1"}, 2, "--start");
  expect({log_, "-o", tum, "--global"}, 2, "--map");
  expect({log_, "--map", out / "none.yaml", "-o", tum, "--global"}, 1, "none.yaml");
  expect({log_, "--map", out.path().string(), "-o", tum, "--global"}, 1, "there is no map.yaml");
  expect({log_, "--map", blank_map, "-o", tum, "--global"}, 1, "blank.yaml: ");
  expect({out / "none.clf", "--map", map_, "-o", tum, "--global"}, 1, "none.clf");
  expect({empty, "--map", map_, "-o", tum, "--global"}, 1, "empty.clf");
  expect({no_scan, "--map", map_, "-o", tum, "--global", "-q"}, 1, "no laser scans");
  expect({log_, "--map", map_, "-o", tum, "--global", "--start", "900", "-q"}, 1,
         "no laser scan in it after --start");
  EXPECT_EQ(out.names().size(), files) << "nothing was left behind";
}

TEST_F(LocalizeCommand, ItsOptionsCanBeListed) {
  const ProgramResult result = run_program({"config", "localize"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.out, HasSubstr("\nparticles_max = 2000\n"));
  EXPECT_EQ(run_program({"config", "lokalize"}).exit_code, 2);
}

}  // namespace
}  // namespace loopstone::test
