#include "loopstone/formats/mrclam.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "loopstone/base/error.hpp"
#include "loopstone/formats/landmark_file.hpp"
#include "support/temp_dir.hpp"

namespace loopstone {
namespace {

using testing::HasSubstr;

constexpr const char* kBarcodes = "# Subject # Barcode #\n1 5\n2 14\n6 72\n7 27\n";
constexpr const char* kOdometry =
    "# Time [s]  forward velocity [m/s]  angular velocity [rad/s]\n"
    "1288971842.000\t1.000\t0.000\n1288971842.500\t0.000\t0.500\n1288971843.500\t0.000\t0.000\n";
constexpr const char* kMeasurement =
    "# Time [s]  barcode  range [m]  bearing [rad]\n1288971842.100 72 2.000 0.500\n"
    "1288971842.100 27 3.000 -0.500\n1288971842.200 14 1.000 0.100\n1288971843.000 27 2.5 0\n";
constexpr const char* kLandmarks = "6 1.5 -5.5 0.00002 0.00004\n7 1.75 -2.5 0.00003 0.00003\n";

MrclamLog parse(std::string_view odometry, std::string_view measurement,
                MrclamOptions options = {}) {
  return parse_mrclam_log(odometry, "Robot1_Odometry.dat", measurement, "Robot1_Measurement.dat",
                          parse_barcodes(kBarcodes, "Barcodes.dat"), options);
}

template <typename Body>
std::string error_of(Body&& body) {
  try {
    body();
  } catch (const std::exception& error) {
    return error.what();
  }
  return "accepted";
}

TEST(Mrclam, SpeedsBecomePosesAndLinesOfOneTimeOneReading) {
  const MrclamLog log = parse(kOdometry, kMeasurement);
  ASSERT_EQ(log.odometry.size(), 3U);
  EXPECT_EQ(log.odometry[0].stamp.nanoseconds, 1288971842'000000000);
  EXPECT_EQ(log.odometry[0].odom_T_robot, Pose2{});
  EXPECT_NEAR(log.odometry[1].odom_T_robot.x, 0.5, 1e-12) << "the speed of the line before";
  EXPECT_NEAR(log.odometry[2].odom_T_robot.yaw, 0.5, 1e-12);
  ASSERT_EQ(log.readings.size(), 2U);
  ASSERT_EQ(log.readings[0].observations.size(), 2U);
  EXPECT_EQ(log.readings[0].observations[0].id, 6) << "the subject, not its barcode";
  EXPECT_EQ(log.readings[0].observations[1].id, 7);
  EXPECT_NEAR(log.readings[0].observations[0].point.norm(), 2.0, 1e-12);
  EXPECT_EQ(log.of_robots, 1);
  EXPECT_EQ(log.skipped.records, 0);
}

TEST(Mrclam, BrokenLinesAreCountedOrNamed) {
  const std::string broken = std::string(kMeasurement) +
                             "1288971843.1 99 1 0\n1288971843.1 72 -1 0\n1288971842.0 72 1 0\n"
                             "1288971843.2 72 1\n1288971843.2 72 x 0\n1288971843.2 72 1 9\n";
  int told = 0;
  MrclamOptions options;
  options.on_problem = [&](const LogProblem& problem) {
    ++told;
    EXPECT_EQ(problem.location.path, "Robot1_Measurement.dat");
  };
  const MrclamLog log = parse(kOdometry, broken, options);
  EXPECT_EQ(log.readings.size(), 2U);
  EXPECT_EQ(log.skipped.records, 6);
  EXPECT_EQ(log.skipped.reasons.size(), 6U);
  EXPECT_EQ(told, 6);
  EXPECT_EQ(error_of([&] { (void)parse(kOdometry, broken, {.strict = true}); }),
            "Robot1_Measurement.dat:6: a barcode that nobody carries by Barcodes.dat");
  EXPECT_EQ(error_of([&] { (void)parse("1 2\n", kMeasurement); }),
            "Robot1_Odometry.dat: no line of it can be used; line 1: expected 3 values (time, "
            "forward speed, yaw rate), found 2");
  EXPECT_EQ(error_of([&] { (void)parse("# nothing\n", kMeasurement); }),
            "Robot1_Odometry.dat: holds no line but comments");
}

TEST(Mrclam, ASpeedThatNobodyRenewsIsNotHeldForLong) {
  const MrclamLog log = parse("10 1 0\n100 0 0\n", kMeasurement);
  EXPECT_NEAR(log.odometry[1].odom_T_robot.x, 1.0, 1e-12) << "a second's way, not ninety";
}

TEST(Mrclam, TablesAreRead) {
  const auto landmarks = parse_mrclam_landmarks(kLandmarks, "Landmark_Groundtruth.dat");
  ASSERT_EQ(landmarks.size(), 2U);
  EXPECT_EQ(landmarks[0].id, 6);
  EXPECT_EQ(landmarks[0].position, Eigen::Vector2d(1.5, -5.5));
  EXPECT_EQ(landmarks[0].sigma_m, 0.00004);
  const Trajectory truth =
      parse_mrclam_truth("# t x y yaw\n1288971842.041 1.25 2.5 4.0\n", "Robot1_Groundtruth.dat");
  EXPECT_NEAR(truth.front().pose.yaw, 4.0 - 2.0 * kPi, 1e-12);
  EXPECT_EQ(error_of([] { (void)parse_mrclam_landmarks("6 1 2 3\n", "L.dat"); }),
            "L.dat:1: expected 5 values (subject, x, y, sigma x, sigma y), found 4");
  EXPECT_EQ(error_of([] { (void)parse_mrclam_landmarks("6 1 2 0 0\n6 1 2 0 0\n", "L.dat"); }),
            "L.dat:2: landmark 6 is given twice");
  EXPECT_EQ(error_of([] { (void)parse_barcodes("1 5\n2 5\n", "B.dat"); }),
            "B.dat:2: barcode 5 is carried by subject 1 already");
  EXPECT_EQ(error_of([] { (void)parse_mrclam_truth("1 2 3\n", "T.dat"); }),
            "T.dat:1: expected 4 values (time, x, y, heading), found 3");
}

class MrclamFolder : public testing::Test {
 protected:
  void SetUp() override {
    for (const int robot : {2, 3}) {
      const std::string name = "Robot" + std::to_string(robot);
      dir_.write(name + "_Odometry.dat", kOdometry);
      dir_.write(name + "_Measurement.dat", kMeasurement);
    }
    dir_.write("Barcodes.dat", kBarcodes);
    dir_.write("Landmark_Groundtruth.dat", kLandmarks);
    dir_.write("Robot2_Groundtruth.dat", "1 2 3 0.5\n");
  }
  test::TempDir dir_;
};

TEST_F(MrclamFolder, RobotsAreToldApartByNumber) {
  const std::string folder = dir_.path().string();
  EXPECT_TRUE(is_mrclam_log(folder));
  EXPECT_TRUE(is_mrclam_log(folder + "#3"));
  EXPECT_EQ(read_mrclam_log(folder, {}).robot, 2) << "the first that is there";
  EXPECT_EQ(read_mrclam_log(folder + "#3", {}).robot, 3);
  EXPECT_THAT(error_of([&] { (void)read_mrclam_log(folder + "#1", {}); }),
              HasSubstr("there is no Robot1_Odometry.dat"));
  EXPECT_FALSE(is_mrclam_log(folder + "/nowhere"));
  EXPECT_FALSE(is_mrclam_log(dir_ / "Barcodes.dat"));
}

TEST_F(MrclamFolder, LandmarksByFolderOrFile) {
  EXPECT_EQ(read_landmarks(dir_.path().string()).size(), 2U);
  EXPECT_EQ(read_landmarks(dir_ / "Landmark_Groundtruth.dat").size(), 2U);
  EXPECT_TRUE(is_mrclam_truth(dir_ / "Robot2_Groundtruth.dat"));
  EXPECT_FALSE(is_mrclam_truth(dir_ / "Landmark_Groundtruth.dat"));
  EXPECT_EQ(read_mrclam_truth(dir_ / "Robot2_Groundtruth.dat").size(), 1U);
}

}  // namespace
}  // namespace loopstone
