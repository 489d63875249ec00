// From a CameraInfo to a lens.

#include "formats/camera_lens.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "loopstone/sensor/camera_geometry.hpp"

namespace loopstone {
namespace {

msg::CameraInfo info(const std::string& model, std::vector<double> d) {
  msg::CameraInfo info{.height = 480, .width = 640, .distortion_model = model, .d = std::move(d)};
  info.k = {600, 0, 310, 0, 610, 250, 0, 0, 1};
  info.p = {580, 0, 300, 0, 0, 590, 245, 0, 0, 0, 1, 0};
  return info;
}

TEST(CameraLens, PlumbBobIsTakenAsItIs) {
  const ToldLens told = lens_of(info("plumb_bob", {0.1, -0.2, 0.001, 0.002, 0.05}), false);
  EXPECT_EQ(told.fault, "");
  EXPECT_EQ(told.lens.focal_x_px, 600);
  EXPECT_EQ(told.lens.focal_y_px, 610);
  EXPECT_EQ(told.lens.centre_x_px, 310);
  EXPECT_EQ(told.lens.centre_y_px, 250);
  EXPECT_EQ(told.lens.k1, 0.1);
  EXPECT_EQ(told.lens.k2, -0.2);
  EXPECT_EQ(told.lens.p1, 0.001);
  EXPECT_EQ(told.lens.p2, 0.002);
  EXPECT_EQ(told.lens.k3, 0.05);
  EXPECT_EQ(told.worst_px, 0.0);
}

TEST(CameraLens, RectifiedPicturesHaveTheProjection) {
  const ToldLens told = lens_of(info("plumb_bob", {0.1, -0.2, 0, 0, 0}), true);
  EXPECT_EQ(told.lens.focal_x_px, 580);
  EXPECT_EQ(told.lens.centre_y_px, 245);
  EXPECT_FALSE(is_distorted(told.lens));
}

TEST(CameraLens, RationalPolynomialIsFollowed) {
  // An Azure Kinect's colour camera.
  const std::vector<double> d{0.57, -2.57, 0.0008, -0.0002, 1.48, 0.44, -2.39, 1.41};
  const ToldLens told = lens_of(info("rational_polynomial", d), false);
  ASSERT_EQ(told.fault, "");
  EXPECT_LT(told.worst_px, 0.5);
  EXPECT_EQ(told.lens.p1, 0.0008);
  for (double x = -0.5; x <= 0.5; x += 0.1) {
    for (double y = -0.38; y <= 0.38; y += 0.1) {
      const double r2 = x * x + y * y;
      const double radial =
          (1 + r2 * (d[0] + r2 * (d[1] + r2 * d[4]))) / (1 + r2 * (d[5] + r2 * (d[6] + r2 * d[7])));
      const Eigen::Vector2d expected(
          310 + 600 * (x * radial + 2 * d[2] * x * y + d[3] * (r2 + 2 * x * x)),
          250 + 610 * (y * radial + d[2] * (r2 + 2 * y * y) + 2 * d[3] * x * y));
      EXPECT_LT((project(told.lens, {x, y, 1.0}) - expected).norm(), told.worst_px + 0.05);
    }
  }
}

TEST(CameraLens, FisheyeIsFollowedWhereItCanBe) {
  const std::vector<double> d{0.01, -0.002, 0.0005, -0.0001};
  const ToldLens told = lens_of(info("equidistant", d), false);
  ASSERT_EQ(told.fault, "");
  for (double r = 0.05; r < 0.6; r += 0.05) {
    const double a = std::atan(r);
    const double seen = a * (1 + a * a * (d[0] + a * a * (d[1] + a * a * (d[2] + a * a * d[3]))));
    EXPECT_NEAR(project(told.lens, {r, 0.0, 1.0}).x(), 310 + 600 * seen, told.worst_px + 0.05);
  }
}

TEST(CameraLens, PartsAndBinning) {
  msg::CameraInfo part = info("plumb_bob", {});
  part.roi = {.x_offset = 100, .y_offset = 40, .height = 300, .width = 400};
  part.binning_x = part.binning_y = 2;
  const LensModel lens = lens_of(part, false).lens;
  EXPECT_EQ(lens.width_px, 200);
  EXPECT_EQ(lens.height_px, 150);
  // A point seen at pixel (210, 140) of the sensor is at (110, 100) of the part.
  const LensModel whole = lens_of(info("plumb_bob", {}), false).lens;
  const Eigen::Vector3d ray = ray_through(whole, {210, 140});
  EXPECT_NEAR(project(lens, ray).x(), (110 + 0.5) / 2 - 0.5, 1e-9);
  EXPECT_NEAR(project(lens, ray).y(), (100 + 0.5) / 2 - 0.5, 1e-9);
}

TEST(CameraLens, CamerasThatWereNotCalibrated) {
  msg::CameraInfo none = info("plumb_bob", {});
  none.k = {};
  EXPECT_NE(lens_of(none, false).fault, "");
  EXPECT_NE(lens_of(msg::CameraInfo{}, false).fault, "");
  EXPECT_NE(lens_of(info("plumb_bob", {std::nan(""), 0, 0, 0, 0}), false).fault, "");
  EXPECT_NE(lens_of(info("rational_polynomial", {0, 0, 0, 0, 0, -1e4, 0, 0}), false).fault, "");
}

}  // namespace
}  // namespace loopstone
