#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "loopstone/base/stamp.hpp"
#include "loopstone/formats/image.hpp"
#include "loopstone/formats/texture_files.hpp"
#include "loopstone/formats/tum.hpp"
#include "loopstone/sensor/camera_model.hpp"
#include "run_program.hpp"
#include "support/rendered_floor.hpp"
#include "support/temp_dir.hpp"

namespace loopstone::test {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using Json = nlohmann::json;

std::string lens_toml(const char* table, const LensModel& lens) {
  return fmt::format(
      "[camera.{}]\nwidth_px = {}\nheight_px = {}\nfocal_x_px = {}\nfocal_y_px = {}\ncentre_x_px = "
      "{}\ncentre_y_px = {}\n",
      table, lens.width_px, lens.height_px, lens.focal_x_px, lens.focal_y_px, lens.centre_x_px,
      lens.centre_y_px);
}

/// A few seconds in a simulated office with small pictures, so that it is fast. Made once for all
/// tests.
class TextureCommand : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TempDir;
    log_ = *folder_ / "sim";
    truth_ = log_ + "/truth.tum";
    const CameraModel camera = small_camera();
    robot_ = folder_->write("robot.toml",
                            lens_toml("depth", camera.depth) + lens_toml("colour", camera.colour));
    const ProgramResult result =
        run_program({"simulate", "office", "-o", log_, "--seed", "3", "--duration", "6", "--beams",
                     "361", "--rgbd", "--robot", robot_, "--quiet"});
    ASSERT_EQ(result.exit_code, 0) << result.error;
  }
  static void TearDownTestSuite() {
    delete folder_;
    folder_ = nullptr;
  }
  void SetUp() override { ASSERT_TRUE(fs::exists(truth_)) << "nothing was simulated"; }

  static ProgramResult with_robot(std::vector<std::string> arguments) {
    arguments.insert(arguments.end(),
                     {"--robot", robot_, "--quiet", "--set", "texture.max_blur_m=0.04", "--set",
                      "texture.resolution_m=0.02"});
    return run_program(arguments);
  }
  /// The log once more, so that it may be damaged.
  static std::string copy_of_log(const TempDir& dir) {
    fs::copy(log_, dir / "log", fs::copy_options::recursive);
    return dir / "log";
  }

  static inline TempDir* folder_ = nullptr;
  static inline std::string log_;
  static inline std::string truth_;
  static inline std::string robot_;
};

TEST_F(TextureCommand, PutsTheFloorOnTheMap) {
  const TempDir dir;
  const std::string out = dir / "floor";
  const ProgramResult result = with_robot(
      {"texture", log_, "--trajectory", truth_, "-o", out, "--map", log_ + "/map.yaml", "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  for (const char* name : {"texture.png", "texture.yaml", "texture.pgw", "coverage.png",
                           "texture_map.png", "summary.json", "options.toml"}) {
    EXPECT_TRUE(fs::exists(out + "/" + name)) << name;
  }
  EXPECT_FALSE(fs::exists(out + "/cloud.ply"));
  const Json json = Json::parse(result.out);
  Json summary = Json::parse(dir.read("floor/summary.json"));
  EXPECT_GT(summary.at("peak_memory_bytes").get<double>(), 1e6);
  EXPECT_LE(summary.at("peak_memory_bytes").get<double>(),
            json.at("peak_memory_bytes").get<double>() + 1e6);
  summary["peak_memory_bytes"] = json.at("peak_memory_bytes");
  EXPECT_EQ(json, summary);
  EXPECT_EQ(json.at("complete"), true);
  EXPECT_GT(json.at("seen_area_m2").get<double>(), 0.5);
  EXPECT_GT(json.at("frames_used").get<int>(), 5);
  EXPECT_EQ(json.at("frames_unreadable"), 0);
  // The simulated mount looks 0.0175 rad farther down than the robot's file says.
  EXPECT_EQ(json.at("floor").at("status"), "estimated");
  EXPECT_NEAR(json.at("floor").at("pitch_error_deg").get<double>(), 1.0, 0.15);
  for (const char* key : {"wall_time_s", "cpu_time_s", "peak_memory_bytes", "memory_bytes",
                          "filled_area_m2", "brightness_spread", "frames_tilted"}) {
    EXPECT_TRUE(json.at(key).is_number()) << key;
  }
  EXPECT_THAT(result.error, HasSubstr("mount differs from the robot file"));

  // Where it was seen it has the colours of the true floor, at the place that the YAML says.
  const TextureInfo info = read_texture_yaml(out + "/texture.yaml");
  const TextureInfo true_info = read_texture_yaml(log_ + "/floor.yaml");
  const Image texture = read_image(info.image);
  const Image floor = read_image(true_info.image);
  const GridFrame frame = info.frame(texture.width, texture.height);
  const GridFrame true_frame = true_info.frame(floor.width, floor.height);
  EXPECT_NEAR(frame.resolution, 0.02, 1e-12);
  double off = 0.0;
  int seen = 0;
  for (int row = 0; row < texture.height; ++row) {
    for (int column = 0; column < texture.width; ++column) {
      if (texture.sample(row, column, 3) == 0) continue;
      const Cell there = true_frame.cell_of(frame.centre_of({column, frame.rows - 1 - row}) -
                                            Eigen::Vector2d::Constant(0.25 * frame.resolution));
      if (!true_frame.contains(there) || there.column + 1 >= floor.width || there.row < 1) continue;
      for (int channel = 0; channel < 3; ++channel) {
        off += std::abs(texture.sample(row, column, channel) -
                        floor.sample(floor.height - 1 - there.row, there.column, channel)) /
               3.0;
      }
      ++seen;
    }
  }
  EXPECT_GT(seen, 1000);
  EXPECT_LT(off / seen, 12.0) << "mean difference, of 255; 2 cm aside it is 12.7";
}

TEST_F(TextureCommand, TableAndCloud) {
  const TempDir dir;
  const ProgramResult result =
      with_robot({"texture", log_, "--trajectory", truth_, "-o", dir / "floor", "--cloud"});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  for (const char* text : {"floor seen in colour", " m2", "camera frames", "pitch +",
                           "texture_map.png", "frames a second"}) {
    EXPECT_THAT(result.out, HasSubstr(text));
  }
  const std::string cloud = dir.read("floor/cloud.ply");
  EXPECT_THAT(cloud.substr(0, 200), HasSubstr("ply\nformat binary_little_endian 1.0\n"));
  EXPECT_GT(cloud.size(), 15U * 1000U);
  EXPECT_THAT(dir.read("floor/options.toml"), HasSubstr("resolution_m = 0.02"));
}

TEST_F(TextureCommand, SameBytesWithAnyThreads) {
  const TempDir dir;
  for (const char* threads : {"1", "3"}) {
    ASSERT_EQ(with_robot({"texture", log_, "--trajectory", truth_, "-o", dir / threads, "--threads",
                          threads, "--cloud"})
                  .exit_code,
              0);
  }
  for (const char* name : {"/texture.png", "/coverage.png", "/texture.yaml", "/cloud.ply"}) {
    EXPECT_EQ(dir.read("1" + std::string(name)), dir.read("3" + std::string(name))) << name;
  }
}

TEST_F(TextureCommand, MapDoesItToo) {
  const TempDir dir;
  const ProgramResult with = with_robot({"map", log_, "-o", dir / "with", "--cloud", "--json"});
  ASSERT_EQ(with.exit_code, 0) << with.error;
  EXPECT_TRUE(fs::exists(dir / "with/texture.png"));
  EXPECT_TRUE(fs::exists(dir / "with/cloud.ply"));
  EXPECT_THAT(dir.read("with/report.html"), HasSubstr("<h2>Floor</h2>"));
  EXPECT_GT(Json::parse(with.out).at("texture").at("seen_area_m2").get<double>(), 0.5);

  const ProgramResult without =
      with_robot({"map", log_, "-o", dir / "without", "--no-texture", "--json"});
  ASSERT_EQ(without.exit_code, 0) << without.error;
  EXPECT_FALSE(fs::exists(dir / "without/texture.png"));
  EXPECT_FALSE(fs::exists(dir / "without/cloud.ply"));
  EXPECT_FALSE(Json::parse(without.out).contains("texture"));
  for (const char* name : {"/trajectory.tum", "/map.pgm"}) {
    EXPECT_EQ(dir.read("with" + std::string(name)), dir.read("without" + std::string(name)))
        << "the floor changes nothing of the map: " << name;
  }
}

TEST_F(TextureCommand, DamagedPicturesAreCountedAndWarnedOf) {
  const TempDir dir;
  const std::string log = copy_of_log(dir);
  std::ofstream(log + "/dataRGBD/RGB20/rgb20_20.png", std::ios::binary) << "no picture";
  const std::string depth = log + "/dataRGBD/Disparity20/disparity20_25.png";
  fs::resize_file(depth, fs::file_size(depth) / 2);
  const ProgramResult result =
      with_robot({"texture", log, "--trajectory", truth_, "-o", dir / "out", "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  const Json json = Json::parse(result.out);
  EXPECT_EQ(json.at("frames_unreadable"), 2);
  EXPECT_GT(json.at("frames_used").get<int>(), 5);
  EXPECT_THAT(result.error, HasSubstr("rgb20_20.png"));
  EXPECT_THAT(result.error, HasSubstr("disparity20_25.png"));
}

TEST_F(TextureCommand, BadInputSaysWhatToDo) {
  const TempDir dir;
  const std::string out = dir / "out";
  const std::string blind = dir / "blind";
  ASSERT_EQ(run_program(
                {"simulate", "office", "-o", blind, "--duration", "2", "--beams", "91", "--quiet"})
                .exit_code,
            0);
  const Trajectory truth = read_tum(truth_);
  Trajectory elsewhen;
  for (const StampedPose2& pose : truth.poses()) {
    elsewhen.append(pose.stamp + Duration::from_seconds(1e5), pose.pose);
  }
  write_tum(dir / "elsewhen.tum", elsewhen);
  fs::create_directory(dir / "full");
  dir.write("full/mine.txt", "x");
  struct Case {
    std::vector<std::string> arguments;
    int exit_code;
    std::string says;
  };
  const std::vector<Case> cases{
      {{log_, "-o", out}, 2, "--trajectory"},
      {{log_, "--trajectory", truth_}, 2, "--out"},
      {{log_, "--trajectory", dir / "none.tum", "-o", out}, 1, "none.tum"},
      {{dir / "none", "--trajectory", truth_, "-o", out}, 1, "none"},
      {{blind, "--trajectory", blind + "/truth.tum", "-o", out}, 1, "no RGB-D frames"},
      {{log_, "--trajectory", dir / "elsewhen.tum", "-o", out}, 1, "on its clock?"},
      {{log_, "--trajectory", truth_, "-o", dir / "full"}, 2, "--force"},
      {{log_, "--trajectory", truth_, "-o", out, "--set", "texture.foo=1"}, 2, "texture.foo"},
      {{log_, "--trajectory", truth_, "-o", out, "--set", "texture.resolution_m=0"},
       2,
       "texture.resolution_m"},
      {{log_, "--trajectory", truth_, "-o", out, "--map", dir / "none.yaml"}, 1, "none.yaml"},
  };
  for (const Case& each : cases) {
    std::vector<std::string> arguments{"texture"};
    arguments.insert(arguments.end(), each.arguments.begin(), each.arguments.end());
    arguments.insert(arguments.end(), {"--robot", robot_, "--quiet"});
    const ProgramResult run = run_program(arguments);
    EXPECT_EQ(run.exit_code, each.exit_code) << each.says << ": " << run.error;
    EXPECT_THAT(run.error, HasSubstr(each.says));
    EXPECT_EQ(run.out, "");
    if (fs::exists(out)) {
      EXPECT_TRUE(fs::is_empty(out)) << each.says;
      fs::remove_all(out);
    }
  }
  EXPECT_EQ(dir.read("full/mine.txt"), "x");
}

TEST_F(TextureCommand, PicturesOfAnotherSizeThanTheLensAreRefused) {
  // Without the robot's file the lenses are those of 640 x 480 pictures.
  const TempDir dir;
  const ProgramResult result = run_program(
      {"texture", log_, "--trajectory", truth_, "-o", dir / "out", "--json", "--quiet"});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_EQ(result.out, "");
  EXPECT_THAT(result.error, HasSubstr("is 160 x 120 pixels, but"));
  EXPECT_THAT(result.error, HasSubstr("none of its pictures can be used"));
}

TEST_F(TextureCommand, ItsOptionsAreListedWithTheMaps) {
  const ProgramResult result = run_program({"config", "map"});
  EXPECT_EQ(result.exit_code, 0) << result.error;
  EXPECT_THAT(result.out, HasSubstr("[texture]\n"));
}

}  // namespace
}  // namespace loopstone::test
