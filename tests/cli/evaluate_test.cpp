#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "loopstone/formats/ros_map.hpp"
#include "loopstone/formats/tum.hpp"
#include "run_program.hpp"
#include "support/temp_dir.hpp"

namespace loopstone::test {
namespace {

using testing::HasSubstr;

/// A winding path, seen from a frame of its own, with an error of a few centimetres that grows.
Trajectory winding_path(const Pose2& frame_T_world, double drift) {
  Trajectory path;
  Pose2 world_T_robot;
  for (int i = 0; i < 100; ++i) {
    path.append({(1000 + i) * std::int64_t{100'000'000}}, frame_T_world * world_T_robot);
    world_T_robot = world_T_robot * exp(Tangent2(0.1 + drift, 0.0, 0.05 * std::sin(0.1 * i)));
  }
  return path;
}

class EvaluateCommand : public testing::Test {
 protected:
  EvaluateCommand() {
    write_tum(reference_, winding_path({}, 0.0));
    write_tum(estimate_, winding_path({3.0, 4.0, 1.0}, 0.001));
  }

  TempDir folder_;
  std::string estimate_ = folder_ / "estimate.tum";
  std::string reference_ = folder_ / "reference.tum";
};

TEST_F(EvaluateCommand, GivesTrajectoryErrorsAsJson) {
  const ProgramResult result =
      run_program({"evaluate", "--estimate", estimate_, "--reference", reference_, "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  const auto json = nlohmann::json::parse(result.out);
  EXPECT_GT(json.at("ate_rmse_m").get<double>(), 0.01);
  EXPECT_LT(json.at("ate_rmse_m").get<double>(), 0.06);
  EXPECT_LT(json.at("ate_rmse_rad").get<double>(), 0.02);
  EXPECT_EQ(json.at("poses"), 100);
  EXPECT_EQ(json.at("poses_missing"), 0);
  EXPECT_NEAR(json.at("rpe").at("translation_m").at("mean").get<double>(), 0.01, 0.002);
}

TEST_F(EvaluateCommand, WithoutAlignmentTheFramesMatter) {
  const ProgramResult result = run_program({"evaluate", "--estimate", estimate_, "--reference",
                                            reference_, "--align", "none", "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  EXPECT_GT(nlohmann::json::parse(result.out).at("ate_rmse_m").get<double>(), 1.0);
}

TEST_F(EvaluateCommand, RelationsOutsideTheTimeAreCountedAndPrinted) {
  const std::string relations = folder_.write(
      "r.relations", "100.0 102.0 2.0 0 0 0 0 0\n100.05 101.0 0.9 0 0 0 0 0\n1 2 0 0 0 0 0 0\n");
  const ProgramResult result =
      run_program({"evaluate", "--estimate", reference_, "--relations", relations, "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  const auto json = nlohmann::json::parse(result.out);
  EXPECT_EQ(json.at("pairs"), 2);
  EXPECT_EQ(json.at("pairs_interpolated"), 1);
  EXPECT_EQ(json.at("pairs_missing"), 1);
  for (const char* key : {"translation_error_m", "squared_translation_error_m2",
                          "rotation_error_deg", "squared_rotation_error_deg2"}) {
    EXPECT_TRUE(json.at(key).contains("mean")) << key;
    EXPECT_TRUE(json.at(key).contains("std")) << key;
  }
  EXPECT_THAT(result.error, HasSubstr("1.000000000 2.000000000"));
}

TEST_F(EvaluateCommand, BoundsDecideTheExitCode) {
  const auto run = [&](const std::string& bound) {
    return run_program({"evaluate", "--estimate", estimate_, "--reference", reference_, "--require",
                        bound, "--quiet"});
  };
  EXPECT_EQ(run("ate_rmse_m<=0.5").exit_code, 0);
  const ProgramResult missed = run("ate_rmse_m<=0.0001");
  EXPECT_EQ(missed.exit_code, 3);
  EXPECT_THAT(missed.error, HasSubstr("ate_rmse_m is 0.0"));
  EXPECT_THAT(missed.out, HasSubstr("absolute position error")) << "the result is still printed";
  EXPECT_EQ(run("poses>=100").exit_code, 0);
  EXPECT_EQ(run("poses>100").exit_code, 3);
  EXPECT_EQ(run("rpe.translation_m.mean<0.001").exit_code, 3);
  EXPECT_EQ(run("ate_rmse<=1").exit_code, 2);
  EXPECT_THAT(run("ate_rmse<=1").error, HasSubstr("did you mean ate_rmse_m?"));
  EXPECT_EQ(run("ate_rmse_m").exit_code, 2);
  EXPECT_EQ(run("ate_rmse_m<=much").exit_code, 2);
}

TEST_F(EvaluateCommand, ScoresMapsInTheAlignedFrame) {
  GridFrame frame;
  frame.resolution = 0.1;
  frame.columns = 60;
  frame.rows = 40;
  CellStates truth(frame, kFreeCell);
  for (int column = 0; column < 60; ++column)
    truth[{column, 0}] = truth[{column, 39}] = kOccupiedCell;
  write_ros_map(folder_ / "truth.yaml", truth);
  CellStates moved = truth;
  GridFrame moved_frame = frame;
  moved_frame.origin = {2.0, 1.0};
  moved = CellStates(moved_frame);
  moved.cells() = truth.cells();
  write_ros_map(folder_ / "map.yaml", moved);
  write_tum(folder_ / "moved.tum", winding_path({2.0, 1.0, 0.0}, 0.0));

  const auto f1 = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments{
        "evaluate", "--map", folder_ / "map.yaml", "--true-map", folder_ / "truth.yaml", "--json"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const ProgramResult result = run_program(arguments);
    EXPECT_EQ(result.exit_code, 0) << result.error;
    return nlohmann::json::parse(result.out).at("map").at("f1").get<double>();
  };
  EXPECT_LT(f1({}), 0.2);
  EXPECT_GT(f1({"--estimate", folder_ / "moved.tum", "--reference", reference_}), 0.99);
}

TEST_F(EvaluateCommand, BadInputIsNamed) {
  const auto run = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "evaluate");
    return run_program(arguments);
  };
  const std::string broken = folder_.write("broken.tum", "1 2 3\n");
  const std::string elsewhere =
      folder_.write("elsewhere.tum", "5 0 0 0 0 0 0 1\n6 1 0 0 0 0 0 1\n");
  EXPECT_EQ(run({"--estimate", folder_ / "none.tum", "--reference", reference_}).exit_code, 1);
  const ProgramResult line = run({"--estimate", broken, "--reference", reference_});
  EXPECT_EQ(line.exit_code, 1);
  EXPECT_THAT(line.error, HasSubstr(broken + ":1: "));
  const ProgramResult apart = run({"--estimate", elsewhere, "--reference", reference_});
  EXPECT_EQ(apart.exit_code, 1);
  EXPECT_THAT(apart.error, HasSubstr("no time in common"));
  EXPECT_EQ(run({"--estimate", estimate_}).exit_code, 2);
  EXPECT_EQ(run({}).exit_code, 2);
  EXPECT_EQ(run({"--map", "a.yaml"}).exit_code, 2);
  EXPECT_EQ(run({"--estimate", estimate_, "--reference", reference_, "--rpe", "1x"}).exit_code, 2);
  EXPECT_EQ(run({"--reference", reference_}).exit_code, 2);
}

}  // namespace
}  // namespace loopstone::test
