#include "loopstone/formats/coloured_cloud_file.hpp"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "formats/atomic_file.hpp"
#include "loopstone/base/rng.hpp"
#include "loopstone/formats/point_cloud_file.hpp"
#include "support/temp_dir.hpp"

namespace loopstone {
namespace {

std::vector<ColouredPoint> random_points(std::size_t count) {
  Rng rng(1);
  std::vector<ColouredPoint> points(count);
  for (std::size_t i = 0; i < count; ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      points[i].position_m[axis] = static_cast<float>(rng.normal(0.0, 10.0));
    }
    points[i].rgb = {static_cast<std::uint8_t>(i), static_cast<std::uint8_t>(i / 7),
                     static_cast<std::uint8_t>(i / 256)};
  }
  return points;
}

TEST(ColouredCloudFile, EveryPointComesBackWithItsColour) {
  const test::TempDir dir;
  for (const std::size_t count : {std::size_t{1}, std::size_t{3000}}) {
    const std::vector<ColouredPoint> points = random_points(count);
    const std::string bytes = encode_coloured_cloud(points);
    write_file_atomically(dir / "a.ply", bytes);
    const PointCloud cloud = read_point_cloud(dir / "a.ply");
    ASSERT_EQ(cloud.points.size(), points.size());
    const std::size_t data = bytes.find("end_header\n") + 11;
    ASSERT_EQ(bytes.size(), data + 15 * points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
      ASSERT_EQ(cloud.points[i].cast<float>(), points[i].position_m);
      for (std::size_t channel = 0; channel < 3; ++channel) {
        ASSERT_EQ(static_cast<std::uint8_t>(bytes[data + 15 * i + 12 + channel]),
                  points[i].rgb[channel]);
      }
    }
  }
}

TEST(ColouredCloudFile, NoPointsAreAFileToo) {
  EXPECT_NE(encode_coloured_cloud({}).find("element vertex 0\n"), std::string::npos);
}

}  // namespace
}  // namespace loopstone
