#include "loopstone/formats/landmark_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "loopstone/base/error.hpp"
#include "loopstone/base/rng.hpp"
#include "support/temp_dir.hpp"

namespace loopstone {
namespace {

std::string error_of(std::string_view text) {
  try {
    (void)parse_landmarks(text, "hall.csv");
  } catch (const DataError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(LandmarkFile, EveryBitSurvives) {
  Rng rng(1);
  std::vector<MappedLandmark> landmarks;
  for (int i = 0; i < 50; ++i) {
    landmarks.push_back({i * 7 - 100,
                         {rng.uniform(-1e3, 1e3), rng.uniform(-1e3, 1e3)},
                         rng.uniform(0.0, 0.1),
                         rng.uniform(0.0, 0.3)});
  }
  const test::TempDir dir;
  write_landmarks(dir / "landmarks.csv", landmarks);
  for (const std::string& path : {dir / "landmarks.csv", dir.path().string()}) {
    const auto read = read_landmarks(path);
    ASSERT_EQ(read.size(), landmarks.size());
    for (std::size_t i = 0; i < read.size(); ++i) {
      EXPECT_EQ(read[i].id, landmarks[i].id);
      EXPECT_EQ(read[i].position, landmarks[i].position);
      EXPECT_EQ(read[i].sigma_m, landmarks[i].sigma_m);
      EXPECT_EQ(read[i].radius_m, landmarks[i].radius_m);
    }
  }
}

TEST(LandmarkFile, ColumnsMayChangePlacesAndOthersBeThere) {
  const auto read = parse_landmarks(
      "# reflectors of hall 3\n\ny_m,remark,id,radius_m,x_m\r\n0.5, door ,1,,9 # "
      "moved\n6,,2,0.04,7\n");
  ASSERT_EQ(read.size(), 2U);
  EXPECT_EQ(read[0].position, Eigen::Vector2d(9.0, 0.5));
  EXPECT_EQ(read[0].radius_m, 0.0);
  EXPECT_EQ(read[1].radius_m, 0.04);
  EXPECT_EQ(read[1].sigma_m, 0.0);
}

TEST(LandmarkFile, ErrorsNameLineFaultAndRemedy) {
  EXPECT_EQ(error_of(""),
            "hall.csv: is empty; expected a line of column names, such as "
            "id,x_m,y_m,sigma_m,radius_m");
  EXPECT_EQ(error_of("id,x_m,y_m\n"),
            "hall.csv: names columns but no landmark; add a line for each");
  EXPECT_EQ(error_of("id,x_m\n1,2\n"),
            "hall.csv:1: there is no column y_m; expected a line of "
            "column names, such as id,x_m,y_m,sigma_m,radius_m");
  EXPECT_EQ(error_of("id,x_m,y_m,x_m\n1,2,3,4\n"), "hall.csv:1: two columns are 'x_m'");
  EXPECT_EQ(error_of("id,x_m,y_m\n1,2\n"),
            "hall.csv:2: the line has 2 values, the first line names 3");
  EXPECT_EQ(error_of("id,x_m,y_m\n1,2,nan\n"),
            "hall.csv:2: 'nan' can't be y_m; expected metres, 10,000 km at most");
  EXPECT_EQ(error_of("id,x_m,y_m\n1.5,2,3\n"),
            "hall.csv:2: '1.5' can't be an id; expected a whole number of at most nine digits");
  EXPECT_EQ(error_of("id,x_m,y_m,sigma_m\n1,2,3,-1\n"),
            "hall.csv:2: '-1' can't be sigma_m; expected metres, 0 to 100");
  EXPECT_EQ(error_of("id,x_m,y_m\n7,0,0\n\n7,1,0\n"),
            "hall.csv:4: landmark 7 is in line 2 already; give each its own number");
  EXPECT_THAT(error_of("id,x_m,y_m\n1,2," + std::string(200, 'z') + "\n"),
              testing::HasSubstr(std::string(40, 'z') + "...'"));
}

TEST(LandmarkFile, WhatWasFoundIsReadAsAMap) {
  FoundLandmark one{.id = 9, .position = {1.25, -3.5}, .sigma_m = 0.004, .radius_m = 0.04};
  one.covariance << 4e-6, 1e-6, 1e-6, 9e-6;
  one.sightings = 12;
  one.visits = 2;
  const std::vector<FoundLandmark> found{one, {.id = 2, .position = {0.5, 0.25}}};
  const std::string text = format_found_landmarks(found);
  EXPECT_EQ(text,
            "id,x_m,y_m,sigma_m,radius_m,xx_m2,xy_m2,yy_m2,sightings,visits\n"
            "2,0.500000,0.250000,0.000000,0.000,0,0,0,0,0\n"
            "9,1.250000,-3.500000,0.004000,0.040,4e-06,1e-06,9e-06,12,2\n");
  const std::vector<MappedLandmark> read = parse_landmarks(text);
  ASSERT_EQ(read.size(), 2U);
  EXPECT_EQ(read[1].id, 9);
  EXPECT_EQ(read[1].position, one.position);
  EXPECT_EQ(read[1].sigma_m, one.sigma_m);
  EXPECT_EQ(read[1].radius_m, one.radius_m);
}

TEST(LandmarkFile, AFolderWithoutLandmarksSaysWhatItLooksFor) {
  const test::TempDir dir;
  try {
    (void)read_landmarks(dir.path().string());
    FAIL();
  } catch (const DataError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("neither landmarks.csv nor Landmark_Groundtruth"));
  }
}

}  // namespace
}  // namespace loopstone
