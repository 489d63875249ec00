#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "loopstone/base/rng.hpp"
#include "loopstone/formats/image.hpp"
#include "loopstone/formats/point_cloud_file.hpp"
#include "loopstone/formats/tum.hpp"
#include "loopstone/geometry/pose3.hpp"
#include "office_command.hpp"
#include "run_program.hpp"
#include "support/temp_dir.hpp"

namespace loopstone::test {
namespace {

using testing::HasSubstr;
using Json = nlohmann::json;

Pose2 pose_of(const Json& json) {
  return {json.at("x_m").get<double>(), json.at("y_m").get<double>(),
          json.at("yaw_rad").get<double>()};
}

class MatchCommand : public OfficeCommand {
 protected:
  static Pose2 truth(std::size_t scan) { return truth_.poses().at(scan).pose; }
  static std::string scan(int index) { return log_ + "#" + std::to_string(index); }

  static Json match(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "match");
    arguments.emplace_back("--json");
    const ProgramResult result = run_program(arguments);
    EXPECT_EQ(result.exit_code, 0) << result.error;
    return result.exit_code == 0 ? Json::parse(result.out) : Json::object();
  }

  static void expect_near(const Pose2& pose, const Pose2& wanted, double distance_m, double yaw) {
    EXPECT_LT(std::hypot(pose.x - wanted.x, pose.y - wanted.y), distance_m)
        << pose.x << ' ' << pose.y << " instead of " << wanted.x << ' ' << wanted.y;
    EXPECT_LT(std::abs(wrap_angle(pose.yaw - wanted.yaw)), yaw) << pose.yaw;
  }
};

/// First task of a course: the current scan's pose, given where the previous one was taken.
TEST_F(MatchCommand, PoseOfAScanFromTheScanBefore) {
  const Pose2 before = truth(79);
  const Json json = match({scan(80), scan(79), "--target-pose",
                           fmt::format("{},{},{}", before.x, before.y, before.yaw)});
  EXPECT_EQ(json.at("status"), "converged");
  expect_near(pose_of(json.at("target_T_source")), before.inverse() * truth(80), 0.02, 0.01);
  expect_near(pose_of(json.at("world_T_source")), truth(80), 0.02, 0.01);
  EXPECT_EQ(json.at("covariance").size(), 3u);
  EXPECT_GT(json.at("covariance")[2][2].get<double>(), 0.0);
  EXPECT_GT(json.at("score").get<double>(), 0.6);
  for (const char* key : {"rmse_m", "inlier_fraction", "pairs", "iterations", "wall_time_s"}) {
    EXPECT_TRUE(json.at(key).is_number()) << key;
  }
  EXPECT_EQ(json.at("matrix").size(), 4u);
  EXPECT_NEAR(json.at("matrix")[0][3].get<double>(),
              json.at("target_T_source").at("x_m").get<double>(), 1e-12);
}

/// Second task: the assumed pose on a map is wrong by metres.
TEST_F(MatchCommand, PoseOnAMapFromAWrongGuess) {
  const Pose2 right = truth(80);
  const Json json = match({scan(80), map_, "--initial",
                           fmt::format("{},{},{}", right.x + 2.5, right.y - 2.0, right.yaw + 2.0),
                           "--search-xy", "5", "--search-yaw", "3.15"});
  EXPECT_EQ(json.at("status"), "converged");
  EXPECT_EQ(json.at("sure"), true);
  expect_near(pose_of(json.at("target_T_source")), right, 0.04, 0.01);
}

/// Third task: the transform that aligns a scan with a map, from nothing.
TEST_F(MatchCommand, PoseOnAMapFromNoGuess) {
  const Json json = match({scan(80), map_, "--global", "--png", *folder_ / "global.png"});
  EXPECT_EQ(json.at("status"), "converged");
  expect_near(pose_of(json.at("target_T_source")), truth(80), 0.04, 0.01);
  EXPECT_GE(json.at("best").size(), 1u);
  EXPECT_GT(read_image(*folder_ / "global.png").width, 500);
}

TEST_F(MatchCommand, EveryMethodFindsTheMotion) {
  const Pose2 wanted = truth(79).inverse() * truth(80);
  for (const char* method :
       {"icp_point", "icp_line", "icp_plane", "gicp", "correlative", "grid", "auto"}) {
    const Json json = match({scan(80), scan(79), "--method", method});
    SCOPED_TRACE(method);
    EXPECT_EQ(json.at("status"), "converged");
    expect_near(pose_of(json.at("target_T_source")), wanted, 0.05, 0.02);
  }
}

/// Bare points do not say which side of a wall is free, so ICP's guess must be nearer than the wall
/// is thick.
TEST_F(MatchCommand, EveryMethodFindsThePlaceOnAMap) {
  const Pose2 right = truth(40);
  const auto guess = [&](double off) {
    return fmt::format("{},{},{}", right.x + off, right.y - off, right.yaw + 0.02);
  };
  for (const std::string method :
       {"icp_point", "icp_line", "icp_plane", "gicp", "correlative", "grid", "auto"}) {
    const bool icp = method == "gicp" || method.starts_with("icp");
    const Json json =
        match({scan(40), map_, "--method", method, "--initial", guess(icp ? 0.03 : 0.12)});
    SCOPED_TRACE(method);
    EXPECT_EQ(json.at("status"), "converged");
    expect_near(pose_of(json.at("target_T_source")), right, 0.06, 0.02);
  }
}

TEST_F(MatchCommand, ScansByTimeAreTheSameAsByNumber) {
  const double second = (truth_.poses()[80].stamp - truth_.poses()[0].stamp).seconds();
  const Json by_time = match({fmt::format("{}@+{:.3f}", log_, second), scan(79)});
  EXPECT_EQ(by_time.at("target_T_source"), match({scan(80), scan(79)}).at("target_T_source"));
}

TEST_F(MatchCommand, SweepTellsHowManyHeadingsAgree) {
  const Json json = match({scan(80), scan(79), "--method", "icp_plane", "--sweep-yaw", "12"});
  EXPECT_EQ(json.at("starts"), 12);
  const int agreeing = json.at("agreeing").get<int>();
  EXPECT_GE(agreeing, 1);
  EXPECT_LT(agreeing, 12) << "headings that are half a turn off can't end there";
  EXPECT_EQ(json.at("best")[0].at("starts"), agreeing);
  expect_near(pose_of(json.at("target_T_source")), truth(79).inverse() * truth(80), 0.04, 0.02);
}

/// A table for people: units, and no JSON.
TEST_F(MatchCommand, TableHasUnits) {
  const ProgramResult result = run_program({"match", scan(80), scan(79)});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  for (const char* text : {"target_T_source", " mm", " deg", "converged", "% of the source"}) {
    EXPECT_THAT(result.out, HasSubstr(text));
  }
}

TEST_F(MatchCommand, NoMatchIsAStatusAndARequirementMissed) {
  // Two points are no scan of anything.
  const std::string nothing = folder_->write("two.csv", "0,0\n1,0\n");
  const ProgramResult result = run_program({"match", nothing, map_, "--initial", "0,0,0"});
  EXPECT_EQ(result.exit_code, 0) << result.error;
  EXPECT_THAT(result.out, HasSubstr("NO MATCH"));
  EXPECT_THAT(result.out, HasSubstr("unknown: no pose was found"));
  const Json json = match({nothing, map_, "--initial", "0,0,0", "--target-pose", "1,2,3"});
  EXPECT_EQ(json.at("covariance")[0][0], nullptr) << "nothing is known, which is not zero";
  EXPECT_EQ(json.at("world_covariance")[0][0], nullptr);
  const ProgramResult required =
      run_program({"match", nothing, map_, "--initial", "0,0,0", "--require", "converged"});
  EXPECT_EQ(required.exit_code, 3);
  EXPECT_THAT(required.error, HasSubstr("the match is "));
  EXPECT_EQ(run_program(
                {"match", scan(80), scan(79), "--require", "converged", "--require", "score>=0.5"})
                .exit_code,
            0);
  EXPECT_EQ(run_program({"match", scan(80), scan(79), "--require", "rmse_m<=1e-9"}).exit_code, 3);
}

TEST_F(MatchCommand, BadUsageIsOneLineThatSaysWhatToDo) {
  const std::string flat = folder_->write("flat.csv", "0,0\n1,0\n1,1\n");
  const std::string deep = folder_->write("deep.csv", "0,0,1\n1,0,2\n1,1,3\n");
  const auto expect = [&](std::vector<std::string> arguments, int code, const char* text) {
    arguments.insert(arguments.begin(), "match");
    const ProgramResult result = run_program(arguments);
    EXPECT_EQ(result.exit_code, code) << result.error;
    EXPECT_THAT(result.error, HasSubstr(text));
    EXPECT_EQ(count_lines(result.error), 1u) << result.error;
    EXPECT_EQ(result.out, "");
  };
  expect({log_, map_}, 2, "is a whole log; name one scan of it");
  expect({map_, scan(0)}, 2, "a map can only be the target");
  (void)folder_->write("blank.pgm", "P5 40 40 255\n" + std::string(1600, '\xfe'));
  const std::string blank = folder_->write(
      "blank.yaml",
      "image: blank.pgm\nresolution: 0.05\norigin: [0, 0, 0]\noccupied_thresh: 0.65\n"
      "free_thresh: 0.196\nnegate: 0\n");
  expect({scan(0), blank, "--global"}, 1, "shows no wall");
  (void)folder_->write("blank.pgm", "P5 40 40 255\n" + std::string(1600, '\0'));
  expect({scan(0), blank, "--global"}, 1, "is wall to 100 %");
  expect({flat, deep}, 2, "have no common motion");
  expect({scan(100000), map_}, 1, "has no scan 100000");
  expect({flat, folder_->write("two.csv", "0,0\n1,0\n")}, 1, "has fewer than 3 points");
  expect({log_ + "/none#3", map_}, 1, "there is no such file or folder");
  expect({*folder_ / "none.ply", map_}, 1, "none.ply");
  expect({scan(0), map_, "--initial", "1,2"}, 2, "must be X,Y,YAW");
  expect({scan(0), map_, "--initial", "1,b,2"}, 2, "'b' is no number");
  expect({scan(0), map_, "--initial", "1,2,3", "--global"}, 2, "--global needs no guess");
  expect({scan(0), map_, "--method", "icp_plane", "--search-xy", "3"}, 2,
         "converges from its guess");
  expect({deep, deep, "--method", "grid"}, 2, "is for the plane");
  expect({flat, flat, "--method", "grid"}, 2, "use icp_line or icp_plane");
  expect({scan(0), map_, "--set", "icp.kernal=tukey"}, 2, "kernel");
  expect({scan(0), map_, "--aligned", "a.obj"}, 2, "is written as .ply or .pcd");
  expect({scan(0), map_, "--require", "converge"}, 2, "must read like");
}

/// Three sides of a box and a ramp, in space: nothing in it is symmetric. At random, for a lattice
/// fits onto itself in many ways.
PointCloud furniture() {
  PointCloud cloud;
  Rng rng(5);
  for (int i = 0; i < 600; ++i) {
    const double u = rng.uniform(0.0, 2.0);
    const double v = rng.uniform(0.0, 2.0);
    cloud.points.emplace_back(u, v, 0.0);
    cloud.points.emplace_back(u, 0.0, 0.6 * v);
    cloud.points.emplace_back(0.0, v, 0.8 * u);
    cloud.points.emplace_back(1.0 + 0.4 * u, 1.5 + 0.2 * v, 0.2 * u);
  }
  return cloud;
}

TEST(MatchClouds, InSpaceWithAlignedCopyAndPicture) {
  const TempDir folder;
  const Pose3 target_T_source = Pose3::from_roll_pitch_yaw({0.2, -0.1, 0.15}, 0.05, -0.04, 0.1);
  const PointCloud target = furniture();
  PointCloud source;
  for (const Eigen::Vector3d& p : target.points)
    source.points.push_back(target_T_source.inverse() * p);
  write_point_cloud(folder / "target.pcd", target);
  write_point_cloud(folder / "source.ply", source);
  for (const char* method : {"auto", "icp_point", "icp_plane", "gicp"}) {
    const ProgramResult result = run_program(
        {"match", folder / "source.ply", folder / "target.pcd", "--method", method, "--json",
         "--aligned", folder / "aligned.ply", "--png", folder / "m.png", "--force"});
    ASSERT_EQ(result.exit_code, 0) << result.error;
    const Json json = Json::parse(result.out);
    EXPECT_EQ(json.at("status"), "converged") << method;
    EXPECT_EQ(json.at("covariance").size(), 6u);
    const Eigen::Matrix3d rotation = target_T_source.rotation.toRotationMatrix();
    for (std::size_t row = 0; row < 3; ++row) {
      const auto r = static_cast<Eigen::Index>(row);
      EXPECT_NEAR(json.at("matrix")[row][3].get<double>(), target_T_source.translation(r), 0.01);
      for (std::size_t column = 0; column < 3; ++column) {
        EXPECT_NEAR(json.at("matrix")[row][column].get<double>(),
                    rotation(r, static_cast<Eigen::Index>(column)), 0.01);
      }
    }
    const PointCloud aligned = read_point_cloud(folder / "aligned.ply");
    ASSERT_EQ(aligned.points.size(), target.points.size());
    for (std::size_t i = 0; i < aligned.points.size(); ++i)
      ASSERT_LT((aligned.points[i] - target.points[i]).norm(), 0.02);
    EXPECT_GT(read_image(folder / "m.png").height, 300);
  }
}

TEST(MatchClouds, FromNoGuessHoweverItIsTurned) {
  const TempDir folder;
  const Pose3 target_T_source = Pose3::from_roll_pitch_yaw({3.0, -2.0, 1.0}, 2.0, 0.7, -2.5);
  const PointCloud target = furniture();
  PointCloud source;
  for (const Eigen::Vector3d& p : target.points)
    source.points.push_back(target_T_source.inverse() * p);
  write_point_cloud(folder / "target.ply", target);
  write_point_cloud(folder / "source.ply", source);
  const ProgramResult result =
      run_program({"match", folder / "source.ply", folder / "target.ply", "--global", "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  const Json json = Json::parse(result.out);
  EXPECT_EQ(json.at("status"), "converged");
  EXPECT_GE(json.at("agreeing").get<int>(), 1);
  EXPECT_NEAR(json.at("target_T_source").at("x_m").get<double>(), 3.0, 0.01);
  EXPECT_NEAR(json.at("target_T_source").at("roll_rad").get<double>(), 2.0, 0.01);
  EXPECT_NEAR(json.at("target_T_source").at("yaw_rad").get<double>(), -2.5, 0.01);
}

TEST(MatchClouds, MillimetresAreNoticedAndScaled) {
  const TempDir folder;
  PointCloud target = furniture();
  write_point_cloud(folder / "source.ply", target);
  for (Eigen::Vector3d& p : target.points) p *= 1000.0;
  write_point_cloud(folder / "target.ply", target);
  const ProgramResult plain =
      run_program({"match", folder / "source.ply", folder / "target.ply", "--initial", "identity"});
  EXPECT_THAT(plain.error, HasSubstr("--target-scale 0.001"));
  const ProgramResult scaled =
      run_program({"match", folder / "source.ply", folder / "target.ply", "--initial", "identity",
                   "--target-scale", "0.001", "--json"});
  EXPECT_EQ(scaled.error, "");
  EXPECT_NEAR(Json::parse(scaled.out).at("rmse_m").get<double>(), 0.0, 1e-6);
}

/// A corridor leaves its axis open, and the answer says so in words.
TEST(MatchClouds, ACorridorIsDegenerate) {
  const TempDir folder;
  std::string walls;
  for (int i = 0; i < 300; ++i) walls += fmt::format("{},0\n{},2\n", 0.05 * i, 0.05 * i);
  const std::string cloud = folder.write("corridor.csv", walls);
  const std::string piece = folder.write("piece.csv", walls.substr(walls.size() / 3, 3000));
  const ProgramResult result =
      run_program({"match", piece, cloud, "--method", "icp_line", "--initial", "0,0.1,0.02"});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  EXPECT_THAT(result.out, HasSubstr("degenerate"));
  EXPECT_THAT(result.out, HasSubstr("along 0.0 deg of the target's x axis"));
}

}  // namespace
}  // namespace loopstone::test
