#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "loopstone/formats/landmark_file.hpp"
#include "loopstone/formats/localization_csv.hpp"
#include "loopstone/formats/tum.hpp"
#include "loopstone/geometry/angle.hpp"
#include "run_program.hpp"
#include "support/temp_dir.hpp"

namespace loopstone::test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using Json = nlohmann::json;

std::string text_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// Some seconds in an office with reflectors, as an MCAP file; made once.
class LandmarksCommand : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TempDir;
    sim_ = *folder_ / "sim";
    const ProgramResult result =
        run_program({"simulate", "office", "-o", sim_, "--format", "mcap", "--reflectors", "120",
                     "--seed", "3", "--duration", "15", "--json", "--quiet"});
    ASSERT_EQ(result.exit_code, 0) << result.error;
    simulated_ = Json::parse(result.out);
    log_ = sim_ + "/log.mcap";
    landmarks_ = sim_ + "/landmarks.csv";
    truth_ = read_tum(sim_ + "/truth.tum");
  }
  static void TearDownTestSuite() {
    delete folder_;
    folder_ = nullptr;
  }
  static ProgramResult localize(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"localize", log_, "--landmarks", landmarks_});
    return run_program(arguments);
  }
  static double largest_error_m(const std::string& tum) {
    double largest = 0.0;
    const Trajectory estimate = read_tum(tum);
    for (const StampedPose2& stamped : estimate.poses()) {
      const Pose2 truth = truth_.at_clamped(stamped.stamp).value();
      largest = std::max(largest, std::hypot(stamped.pose.x - truth.x, stamped.pose.y - truth.y));
    }
    return largest;
  }

  static inline TempDir* folder_ = nullptr;
  static inline std::string sim_;
  static inline std::string log_;
  static inline std::string landmarks_;
  static inline Trajectory truth_;
  static inline Json simulated_;
};

TEST_F(LandmarksCommand, SimulateLeavesLandmarksBesideTheLog) {
  EXPECT_EQ(simulated_.at("reflectors"), read_landmarks(landmarks_).size());
  EXPECT_GT(read_landmarks(landmarks_).size(), 60U);
}

TEST_F(LandmarksCommand, FindsAndFollowsTheRobotByReflectorsAlone) {
  const TempDir out;
  const ProgramResult result = localize({"-o", out / "where.tum", "--global", "--json", "--quiet"});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  const Json json = Json::parse(result.out);
  EXPECT_EQ(json.at("start"), "global");
  EXPECT_EQ(json.at("map"), landmarks_);
  EXPECT_EQ(json.at("complete"), true);
  EXPECT_GT(json.at("tracking_share").get<double>(), 0.9);
  EXPECT_GT(json.at("poses").get<int>(), 130);
  EXPECT_LT(largest_error_m(out / "where.tum"), 0.06);
  const auto estimates = read_localization_csv(out / "where.csv");
  EXPECT_EQ(estimates.back().state, LocalizationState::kTracking);
  EXPECT_EQ(out.names(), (std::vector<std::string>{"where.csv", "where.tum"}));
}

TEST_F(LandmarksCommand, FollowsFromAGuessAndTellsInATable) {
  const TempDir out;
  const Pose2& pose = truth_.front().pose;
  const ProgramResult result =
      localize({"-o", out / "where.tum", "--initial",
                fmt::format("{},{},{}", pose.x + 0.3, pose.y - 0.3, pose.yaw + 0.1), "--require",
                "tracking_share>=0.9"});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  for (const char* text : {"scans", "TRACKING", "first TRACKING", "x real time", "where.csv"}) {
    EXPECT_THAT(result.out, HasSubstr(text));
  }
  EXPECT_LT(largest_error_m(out / "where.tum"), 0.35) << "the first pose is the guess";
}

TEST_F(LandmarksCommand, TheSameBytesWithAnyThreads) {
  const TempDir out;
  for (const char* threads : {"1", "4"}) {
    ASSERT_EQ(localize({"-o", out / (std::string(threads) + ".tum"), "--global", "--threads",
                        threads, "--quiet"})
                  .exit_code,
              0);
  }
  EXPECT_EQ(out.read("1.csv"), out.read("4.csv"));
  EXPECT_EQ(out.read("1.tum"), out.read("4.tum"));
}

TEST_F(LandmarksCommand, ReportHasAllItsFiles) {
  const TempDir out;
  const ProgramResult result =
      localize({"-o", out / "where.tum", "--global", "--report", out / "report", "--quiet"});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  for (const char* name : {"report.html", "map.png", "summary.json", "options.toml",
                           "trajectory.tum", "localization.csv"}) {
    EXPECT_TRUE(fs::exists(out / ("report/" + std::string(name)))) << name;
  }
  EXPECT_EQ(out.read("report/localization.csv"), out.read("where.csv"));
  EXPECT_THAT(out.read("report/options.toml"), HasSubstr("[reflectors]"));
}

TEST_F(LandmarksCommand, WhatCantBeIsSaidInWords) {
  const TempDir out;
  const auto expect = [&](const ProgramResult& result, int exit_code, const char* text) {
    EXPECT_EQ(result.exit_code, exit_code) << result.error;
    EXPECT_THAT(result.error, HasSubstr(text));
    EXPECT_FALSE(fs::exists(out / "where.tum"));
  };
  expect(run_program({"localize", log_, "-o", out / "where.tum", "--global"}), 2, "on which map?");
  expect(localize({"-o", out / "where.tum"}), 2, "where does the robot start?");
  expect(localize({"-o", out / "where.tum", "--global", "--map", sim_ + "/map.yaml"}), 2,
         "on which map?");
  expect(localize({"-o", out / "where.tum", "--global", "--particles", "100"}), 2, "--particles");
  expect(run_program({"localize", log_, "-o", out / "where.tum", "--global", "--map",
                      sim_ + "/map.yaml", "--nameless"}),
         2, "need --landmarks");
  expect(localize({"-o", out / "where.tum", "--global", "--reflector-threshold", "0.2"}), 2,
         "reflectors.brightness");
  expect(localize({"-o", out / "where.tum", "--global", "--reflector-threshold", "900"}), 1,
         "no beam is bright enough");
  expect(run_program({"simulate", "office", "-o", out / "sim", "--reflectors", "5"}), 2,
         "--reflectors needs --format mcap, bag or rosbag2");
  const std::string bad = out.write("bad.csv", "id,x_m,y_m\n1,2\n");
  expect(run_program({"localize", log_, "--landmarks", bad, "-o", out / "where.tum", "--global"}),
         1, "bad.csv:2: the line has 2 values");
  expect(run_program({"localize", log_, "--landmarks", out / "none.csv", "-o", out / "where.tum",
                      "--global"}),
         1, "none.csv");
}

TEST_F(LandmarksCommand, ALogWithoutIntensitiesIsRefusedWithARemedy) {
  const TempDir out;
  ASSERT_EQ(run_program({"convert", log_, out / "log.clf", "--quiet"}).exit_code, 0);
  const ProgramResult result = run_program({"localize", out / "log.clf", "--landmarks", landmarks_,
                                            "-o", out / "where.tum", "--global"});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.error, HasSubstr("its scans have no intensities"));
}

TEST_F(LandmarksCommand, ALogWithoutOdometryIsWarnedOf) {
  const TempDir out;
  const ProgramResult result = localize({"-o", out / "where.tum", "--global", "--json", "--topic",
                                         "wheels=none", "--topic", "imu=none"});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  EXPECT_THAT(result.error, HasSubstr("the log has no odometry: the robot is assumed to keep"));
  EXPECT_THAT(Json::parse(result.out).at("warnings").dump(), HasSubstr("no odometry"));
}

TEST_F(LandmarksCommand, ConvertKeepsIntensities) {
  const TempDir out;
  ASSERT_EQ(run_program({"convert", log_, out / "log.bag", "--quiet"}).exit_code, 0);
  const ProgramResult result = run_program({"localize", out / "log.bag", "--landmarks", landmarks_,
                                            "-o", out / "where.tum", "--global", "--quiet"});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  EXPECT_LT(largest_error_m(out / "where.tum"), 0.06);
}

TEST_F(LandmarksCommand, OptionsAreShown) {
  const ProgramResult result = run_program({"config", "landmarks"});
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_THAT(result.out, HasSubstr("brightness = 3.0"));
}

/// A mapped minute of an office with reflectors; made once.
class MapLandmarksCommand : public LandmarksCommand {
 protected:
  static void SetUpTestSuite() {
    LandmarksCommand::SetUpTestSuite();
    out_ = *folder_ / "mapped";
    const ProgramResult result = run_program(
        {"map", log_, "-o", out_, "--landmarks", "--threads", "1", "--json", "--quiet"});
    ASSERT_EQ(result.exit_code, 0) << result.error;
    summary_ = Json::parse(result.out);
  }
  static inline std::string out_;
  static inline Json summary_;
};

TEST_F(MapLandmarksCommand, ReflectorsAreWhereTheyAre) {
  EXPECT_TRUE(summary_.at("complete"));
  EXPECT_GT(summary_.at("landmarks").at("count").get<int>(), 8);
  EXPECT_LT(summary_.at("landmarks").at("sigma_mean_m").get<double>(), 0.05);
  const std::vector<MappedLandmark> truth = read_landmarks(landmarks_);
  // The map begins at the first pose.
  const Pose2 world_T_map =
      truth_.front().pose * read_tum(out_ + "/trajectory.tum").front().pose.inverse();
  std::vector<double> off;
  for (const MappedLandmark& found : read_landmarks(out_)) {
    double nearest = 100.0;
    for (const MappedLandmark& landmark : truth)
      nearest = std::min(nearest, (world_T_map * found.position - landmark.position).norm());
    off.push_back(nearest);
  }
  std::ranges::sort(off);
  EXPECT_LT(off[off.size() / 2], 0.02);
  EXPECT_LT(off.back(), 0.15) << "none that is not there";
}

TEST_F(MapLandmarksCommand, LocalisesOnItsOwnLandmarks) {
  const TempDir out;
  const ProgramResult result = run_program({"localize", log_, "--landmarks", out_, "-o",
                                            out / "where.tum", "--global", "--json", "--quiet"});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  EXPECT_GT(Json::parse(result.out).at("tracking_share").get<double>(), 0.8);
}

TEST_F(MapLandmarksCommand, TheSameBytesWithAnyThreads) {
  const TempDir out;
  ASSERT_EQ(
      run_program({"map", log_, "-o", out / "map", "--landmarks", "--threads", "4", "--quiet"})
          .exit_code,
      0);
  for (const std::string name : {"landmarks.csv", "trajectory.tum", "graph.g2o", "map.pgm"})
    EXPECT_EQ(text_of(out / ("map/" + name)), text_of(out_ + "/" + name)) << name;
}

TEST_F(MapLandmarksCommand, WithoutTheFlagNothingIsSaidOfLandmarks) {
  const TempDir out;
  const ProgramResult result = run_program({"map", log_, "-o", out / "map", "--json", "--quiet"});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  EXPECT_FALSE(Json::parse(result.out).contains("landmarks"));
  EXPECT_FALSE(fs::exists(out / "map/landmarks.csv"));
  EXPECT_EQ(text_of(out / "map/options.toml").find("[landmarks"), std::string::npos);
  EXPECT_EQ(text_of(out / "map/decisions.toml").find("[landmark"), std::string::npos);
}

TEST_F(MapLandmarksCommand, OptionsAreReadBack) {
  EXPECT_THAT(text_of(out_ + "/options.toml"), HasSubstr("[landmarks.reflectors]"));
  EXPECT_THAT(text_of(out_ + "/decisions.toml"), HasSubstr("[landmark_mapping]"));
  EXPECT_THAT(text_of(out_ + "/report.html"), HasSubstr("<h2>Landmarks</h2>"));
  EXPECT_THAT(text_of(out_ + "/graph.g2o"), HasSubstr("EDGE_SE2_XY"));
}

TEST_F(MapLandmarksCommand, WhatCantBeIsSaidInWords) {
  const TempDir out;
  const auto expect = [&](std::vector<std::string> flags, int exit_code, const char* text) {
    std::vector<std::string> arguments{"map", log_, "-o", out / "map", "--quiet"};
    arguments.insert(arguments.end(), flags.begin(), flags.end());
    const ProgramResult result = run_program(arguments);
    EXPECT_EQ(result.exit_code, exit_code) << result.error;
    EXPECT_THAT(result.error, HasSubstr(text));
    EXPECT_FALSE(fs::exists(out / "map"));
  };
  expect({"--nameless"}, 2, "need --landmarks");
  expect({"--landmarks", "--nameless"}, 2, "reflectors have no names");
  expect({"--landmarks", "--pipeline", "scan_to_scan"}, 2, "leave out --pipeline");
  expect({"--landmarks", "--checkpoint", "10"}, 2, "leave out --checkpoint");
  expect({"--landmarks", "--reflector-threshold", "0.2"}, 2, "reflectors.brightness");
  expect({"--landmarks", "--set", "landmarks.sightings_min=1"}, 2, "landmarks.sightings_min");
}

TEST_F(MapLandmarksCommand, WithoutIntensitiesTheMapIsLeftAndTheReasonSaid) {
  const TempDir out;
  ASSERT_EQ(run_program({"convert", log_, out / "log.clf", "--quiet"}).exit_code, 0);
  const ProgramResult result =
      run_program({"map", out / "log.clf", "-o", out / "map", "--landmarks", "--quiet"});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.error, HasSubstr("the scans have no intensities"));
  EXPECT_TRUE(fs::exists(out / "map/map.pgm"));
  EXPECT_EQ(Json::parse(text_of(out / "map/summary.json")).at("complete"), false);
}

/// A folder as MRCLAM has them: a robot on a circle among six landmarks, each seen in its turn.
class MrclamCommand : public testing::Test {
 protected:
  void SetUp() override {
    const std::vector<Eigen::Vector2d> landmarks{{4.0, 0.5},   {2.5, 3.6},   {-1.8, 4.1},
                                                 {-4.4, -0.7}, {-1.2, -3.9}, {3.1, -2.8}};
    std::string barcodes = "1 5\n";
    std::string places;
    for (std::size_t i = 0; i < landmarks.size(); ++i) {
      barcodes += fmt::format("{} {}\n", i + 6, 10 * (i + 1));
      places += fmt::format("{} {} {} 0.0001 0.0001\n", i + 6, landmarks[i].x(), landmarks[i].y());
    }
    std::string odometry = "# Time forward_velocity angular_velocity\n";
    std::string measurement = "# Time barcode range bearing\n";
    std::string truth;
    Pose2 pose{2.0, 0.0, kPi / 2.0};
    for (int step = 0; step < 1200; ++step) {
      const double time_s = 1000.0 + 0.05 * step;
      odometry += fmt::format("{:.3f} 0.2 0.1\n", time_s);
      truth += fmt::format("{:.3f} {} {} {}\n", time_s, pose.x, pose.y, pose.yaw);
      if (step % 6 == 0) {
        const std::size_t i = static_cast<std::size_t>(step / 6) % landmarks.size();
        const Eigen::Vector2d at = pose.inverse() * landmarks[i];
        measurement += fmt::format("{:.3f} {} {} {}\n", time_s, 10 * (i + 1),
                                   at.norm() + 0.05 * std::sin(step),
                                   std::atan2(at.y(), at.x()) + 0.01 * std::cos(step));
      }
      pose = pose * exp(Tangent2(0.2 * 0.05, 0.0, 0.1 * 0.05));
    }
    dir_.write("Barcodes.dat", barcodes);
    dir_.write("Landmark_Groundtruth.dat", places);
    dir_.write("Robot1_Odometry.dat", odometry);
    dir_.write("Robot1_Measurement.dat", measurement);
    dir_.write("Robot1_Groundtruth.dat", truth);
  }
  ProgramResult localize(std::vector<std::string> arguments) {
    const std::string folder = dir_.path().string();
    arguments.insert(arguments.begin(), {"localize", folder, "--landmarks", folder, "-o",
                                         out_ / "where.tum", "--json", "--quiet"});
    return run_program(arguments);
  }
  double rmse_m() {
    const ProgramResult result =
        run_program({"evaluate", "--estimate", out_ / "where.tum", "--reference",
                     dir_ / "Robot1_Groundtruth.dat", "--align", "none", "--json"});
    EXPECT_EQ(result.exit_code, 0) << result.error;
    return Json::parse(result.out).at("ate_rmse_m").get<double>();
  }
  TempDir dir_;
  TempDir out_;
};

TEST_F(MrclamCommand, NamedLandmarksFromNowhere) {
  const ProgramResult result = localize({"--global"});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  EXPECT_GT(Json::parse(result.out).at("tracking_share").get<double>(), 0.5);
  EXPECT_LT(rmse_m(), 0.1);
}

TEST_F(MrclamCommand, NamelessFromAGuess) {
  const ProgramResult result = localize({"--initial", "2.1,0.1,1.5", "--nameless"});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  EXPECT_LT(rmse_m(), 0.1);
}

TEST_F(MrclamCommand, LandmarksOfUnknownPlacesAreFound) {
  const std::string folder = dir_.path().string();
  for (const bool nameless : {false, true}) {
    std::vector<std::string> arguments{"map",         folder,   "-o",      out_ / "map",
                                       "--landmarks", "--json", "--quiet", "--force"};
    if (nameless) arguments.emplace_back("--nameless");
    const ProgramResult result = run_program(arguments);
    ASSERT_EQ(result.exit_code, 0) << result.error;
    EXPECT_EQ(Json::parse(result.out).at("landmarks").at("count"), 6);
    const auto found = read_landmarks(out_ / "map");
    const auto truth = read_landmarks(folder);
    ASSERT_EQ(found.size(), truth.size());
    // Distances between them do not depend on the frame.
    for (std::size_t i = 1; i < found.size() && !nameless; ++i) {
      EXPECT_EQ(found[i].id, truth[i].id);
      EXPECT_NEAR((found[i].position - found[0].position).norm(),
                  (truth[i].position - truth[0].position).norm(), 0.08);
    }
    const ProgramResult error =
        run_program({"evaluate", "--estimate", out_ / "map/trajectory.tum", "--reference",
                     dir_ / "Robot1_Groundtruth.dat", "--align", "se2", "--json"});
    EXPECT_LT(Json::parse(error.out).at("ate_rmse_m").get<double>(), 0.1);
    for (const char* name : {"map.png", "report.html", "graph.g2o", "odometry.tum", "options.toml"})
      EXPECT_TRUE(fs::exists(out_ / ("map/" + std::string(name)))) << name;
  }
}

TEST_F(MrclamCommand, AMapOfItNeedsLandmarksAndNoScans) {
  const std::string folder = dir_.path().string();
  const auto expect = [&](std::vector<std::string> flags, const char* text) {
    std::vector<std::string> arguments{"map", folder, "-o", out_ / "map"};
    arguments.insert(arguments.end(), flags.begin(), flags.end());
    const ProgramResult result = run_program(arguments);
    EXPECT_EQ(result.exit_code, 2) << result.error;
    EXPECT_THAT(result.error, HasSubstr(text));
  };
  expect({}, "--landmarks maps them");
  expect({"--landmarks", "--checkpoint", "10"}, "holds landmarks and odometry, no scans");
  expect({"--landmarks", "--keep-state"}, "holds landmarks and odometry, no scans");
  expect({"--landmarks", "--continue", "out"}, "holds landmarks and odometry, no scans");
  expect({"--landmarks", "--reflector-threshold", "4"}, "--reflector-threshold");
}

TEST_F(MrclamCommand, DamageIsCountedOrNamed) {
  dir_.write("Robot1_Measurement.dat", dir_.read("Robot1_Measurement.dat") + "1059.9 10 x 0\n");
  const ProgramResult counted = localize({"--global"});
  ASSERT_EQ(counted.exit_code, 0) << counted.error;
  EXPECT_EQ(Json::parse(counted.out).at("records_skipped"), 1);
  const ProgramResult strict = localize({"--global", "--strict", "--force"});
  EXPECT_EQ(strict.exit_code, 1);
  EXPECT_THAT(strict.error, HasSubstr("Robot1_Measurement.dat:202: 'x' is no finite number"));
}

TEST_F(MrclamCommand, AnotherRobotThatIsNotThere) {
  const std::string folder = dir_.path().string();
  const ProgramResult result = run_program(
      {"localize", folder + "#4", "--landmarks", folder, "-o", out_ / "where.tum", "--global"});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_THAT(result.error, HasSubstr("there is no Robot4_Odometry.dat"));
}

}  // namespace
}  // namespace loopstone::test
