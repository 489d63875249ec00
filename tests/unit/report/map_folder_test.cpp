#include "loopstone/report/map_folder.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "loopstone/base/error.hpp"
#include "loopstone/formats/image.hpp"
#include "loopstone/report/map_outputs.hpp"
#include "loopstone/report/quality_picture.hpp"
#include "loopstone/slam/mapper.hpp"
#include "support/simulated_log.hpp"
#include "support/temp_dir.hpp"

namespace loopstone {
namespace {

using test::TempDir;
using testing::HasSubstr;

const char* const kHeader =
    "from_t_s,to_t_s,from_node,to_node,from_submap,to_submap,x_m,y_m,yaw_rad,xx_m2,xy_m2,"
    "xyaw_m_rad,yy_m2,yyaw_m_rad,yawyaw_rad2,score,second_score,overlap,agreement,chi2,"
    "by_appearance,accepted,state,reason\n";

TEST(ClosureCsv, ReadsItsColumnsByName) {
  const auto closures = parse_closure_csv(
      std::string(kHeader) +
      "1.5,2.5,3,9,0,2,1,2,0.5,0.1,0.01,0.02,0.2,0.03,0.3,0.9,,0.8,0.7,,1,0,rejected,surfaces "
      "disagree\n"
      ",,0,1,0,1,0,0,0,1,0,0,1,0,1,0.5,0.4,0.3,0.2,1.5,0,1,standing,\n");
  ASSERT_EQ(closures.size(), 2U);
  EXPECT_EQ(closures[0].from, Stamp{1'500'000'000});
  EXPECT_EQ(closures[0].closure.to.index, 9);
  EXPECT_EQ(closures[0].closure.covariance(2, 1), 0.03);
  EXPECT_FALSE(closures[0].closure.second_score.has_value());
  EXPECT_TRUE(closures[0].closure.by_appearance);
  EXPECT_EQ(closures[0].closure.reason, ClosureReason::kSurfacesDisagree);
  EXPECT_FALSE(closures[1].from.has_value());
  EXPECT_EQ(closures[1].closure.chi2, 1.5);
  EXPECT_TRUE(parse_closure_csv(kHeader).empty());
  EXPECT_TRUE(parse_closure_csv("").empty());
}

TEST(ClosureCsv, DamageIsToldWithItsLine) {
  const auto reason_of = [](const std::string& line) -> std::string {
    try {
      (void)parse_closure_csv(kHeader + line, "c.csv");
    } catch (const DataError& error) {
      return error.what();
    }
    return "nothing";
  };
  const std::string good = "1,2,3,9,0,2,1,2,0.5,0.1,0,0,0.2,0,0.3,0.9,,0.8,0.7,,1,0,rejected,\n";
  EXPECT_EQ(reason_of(good), "nothing");
  EXPECT_THAT(reason_of("1,2,3\n"), HasSubstr("c.csv:2: the line has 3 values"));
  EXPECT_THAT(reason_of("x" + good), HasSubstr("from_t_s is no number of seconds"));
  for (const auto& [from, to] :
       std::vector<std::pair<std::string, std::string>>{{",3,9,", ",-3,9,"},
                                                        {",3,9,", ",3.5,9,"},
                                                        {",3,9,", ",3,9e99,"},
                                                        {",3,9,", ",,9,"},
                                                        {"0.5", "nan"},
                                                        {"rejected", "liked"},
                                                        {",0.9,", ",much,"}}) {
    std::string bad = good;
    bad.replace(bad.find(from), from.size(), to);
    EXPECT_THAT(reason_of(bad), HasSubstr("c.csv:2")) << bad;
  }
}

/// A small map, written and read again.
class MapFolderOfARun : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    dir_ = new TempDir;
    const auto log = test::simulate_log("rooms", 2, {.duration_s = 30.0});
    Mapper mapper(log.robot, MapOptions{}, Threads{2});
    for (const SensorMessage& message : log.messages) mapper.add(message);
    result_ = new MapResult(mapper.finish());
    result_->warnings.emplace_back("a warning");
    write_map_outputs(*result_, {.log_path = "log", .command_line = "loopstone map log"},
                      *dir_ / "out");
  }
  static void TearDownTestSuite() {
    delete result_;
    delete dir_;
    result_ = nullptr;
    dir_ = nullptr;
  }
  /// A copy that may be spoiled.
  static std::string copy(const TempDir& to) {
    std::filesystem::copy(*dir_ / "out", to / "out");
    return to / "out";
  }

  static inline TempDir* dir_ = nullptr;
  static inline MapResult* result_ = nullptr;
};

TEST_F(MapFolderOfARun, IsReadAgain) {
  const MapFolder folder = read_map_folder(*dir_ / "out");
  EXPECT_TRUE(folder.left_out.empty()) << folder.left_out.front();
  ASSERT_EQ(folder.trajectory.size(), result_->trajectory.size());
  ASSERT_EQ(folder.covariances.size(), folder.trajectory.size());
  const Stamp last = folder.trajectory.back().stamp;
  EXPECT_TRUE(folder.covariances.back().isApprox(result_->covariance_at(last), 1e-3));
  ASSERT_EQ(folder.closures.size(), result_->loop_closures.size());
  for (std::size_t i = 0; i < folder.closures.size(); ++i) {
    const LoopClosure& read = folder.closures[i].closure;
    const LoopClosure& written = result_->loop_closures[i];
    EXPECT_EQ(read.from_T_to, written.from_T_to);
    EXPECT_EQ(read.covariance, written.covariance);
    EXPECT_EQ(read.state, written.state);
    EXPECT_EQ(read.reason, written.reason);
    EXPECT_EQ(read.chi2, written.chi2);
  }
  ASSERT_TRUE(folder.cells.has_value());
  EXPECT_EQ(folder.cells->cells(), cell_states(result_->map).cells());
  EXPECT_THAT(folder.summary_json, HasSubstr("\"a warning\""));
  EXPECT_FALSE(folder.texture.has_value());
}

TEST_F(MapFolderOfARun, TheQualityPictureLiesOnTheMap) {
  const MapFolder folder = read_map_folder(*dir_ / "out");
  ASSERT_TRUE(folder.quality.has_value());
  const Image image = decode_png(folder.quality->png);
  const double right = folder.quality->corner.x() + image.width * folder.quality->resolution_m;
  const double top = folder.quality->corner.y() + image.height * folder.quality->resolution_m;
  for (const StampedPose2& pose : folder.trajectory.poses()) {
    EXPECT_GT(pose.pose.x, folder.quality->corner.x());
    EXPECT_GT(pose.pose.y, folder.quality->corner.y());
    EXPECT_LT(pose.pose.x, right);
    EXPECT_LT(pose.pose.y, top);
  }
  // Places are coloured, the rest is grey: where the layer has one, so has the picture.
  const auto layer = draw_quality_layer(result_->quality);
  ASSERT_TRUE(layer.has_value());
  std::size_t coloured = 0;
  std::size_t compared = 0;
  for (const QualityPlace& place : result_->quality.places) {
    if (place.compared == 0 && place.beams == 0) continue;
    const Eigen::Vector2d at =
        (place.centre.cast<double>() - folder.quality->corner) / folder.quality->resolution_m;
    const int column = static_cast<int>(at.x());
    const int row = image.height - 1 - static_cast<int>(at.y());
    if (column < 0 || row < 0 || column >= image.width || row >= image.height) continue;
    ++compared;
    if (image.sample(row, column, 0) != image.sample(row, column, 2)) ++coloured;
  }
  ASSERT_GT(compared, 0U);
  EXPECT_GT(coloured, compared * 9 / 10);
}

TEST_F(MapFolderOfARun, WhatIsMissingOrDamagedIsLeftOut) {
  const TempDir dir;
  const std::string out = copy(dir);
  std::filesystem::remove(out + "/trajectory.csv");
  std::ofstream(out + "/loop_closures.csv") << kHeader << "1,2\n";
  std::ofstream(out + "/map.pgm") << "no picture";
  std::ofstream(out + "/quality.png") << "no picture";
  const MapFolder folder = read_map_folder(out);
  EXPECT_TRUE(folder.covariances.empty());
  EXPECT_TRUE(folder.closures.empty());
  EXPECT_FALSE(folder.cells.has_value());
  EXPECT_FALSE(folder.quality.has_value());
  EXPECT_EQ(folder.left_out.size(), 3U);
  EXPECT_FALSE(folder.trajectory.empty());
}

TEST_F(MapFolderOfARun, CovariancesOfAnotherPathAreRefused) {
  const TempDir dir;
  const std::string out = copy(dir);
  std::ofstream(out + "/trajectory.tum") << "1.0 0 0 0 0 0 0 1\n2.0 1 0 0 0 0 0 1\n";
  const MapFolder folder = read_map_folder(out);
  EXPECT_TRUE(folder.covariances.empty());
  ASSERT_EQ(folder.left_out.size(), 1U);
  EXPECT_THAT(folder.left_out[0], HasSubstr("not the time of the pose"));
}

TEST_F(MapFolderOfARun, WithoutAPathItIsNone) {
  const TempDir dir;
  const std::string out = copy(dir);
  std::filesystem::remove(out + "/trajectory.tum");
  EXPECT_THROW((void)read_map_folder(out), DataError);
  // Nonsense in the summary keeps nothing else away.
  const TempDir other;
  const std::string spoiled = copy(other);
  std::ofstream(spoiled + "/summary.json")
      << R"({"quality":{"picture":{"width_px":1e300,"height_px":-5,"x_m":"a"}}})";
  EXPECT_FALSE(read_map_folder(spoiled).quality.has_value());
}

}  // namespace
}  // namespace loopstone
