#include "loopstone/formats/coloured_cloud_file.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "formats/atomic_file.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/base/rng.hpp"
#include "loopstone/formats/point_cloud_file.hpp"
#include "support/temp_dir.hpp"

namespace loopstone {
namespace {

TEST(ColouredCloudFile, EveryPointComesBackWithItsColour) {
  const test::TempDir dir;
  Rng rng(1);
  // More than one buffer of the file's.
  std::vector<Eigen::Vector3f> points(40'000);
  for (auto& point : points) {
    for (int axis = 0; axis < 3; ++axis) point[axis] = static_cast<float>(rng.normal(0.0, 10.0));
  }
  const auto colour = [](std::size_t i) {
    return std::array<std::uint8_t, 3>{static_cast<std::uint8_t>(i),
                                       static_cast<std::uint8_t>(i / 7),
                                       static_cast<std::uint8_t>(i / 256)};
  };
  {
    ColouredCloudFile file(dir / "a.ply");
    for (std::size_t i = 0; i < points.size(); ++i) file.add(points[i], colour(i));
    EXPECT_EQ(file.points(), 40'000);
    EXPECT_FALSE(std::filesystem::exists(dir / "a.ply"));
    file.commit();
  }
  const PointCloud cloud = read_point_cloud(dir / "a.ply");
  ASSERT_EQ(cloud.points.size(), points.size());
  const std::string bytes = read_whole_file(dir / "a.ply");
  const std::size_t data = bytes.find("end_header\n") + 11;
  ASSERT_EQ(bytes.size(), data + 15 * points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    ASSERT_EQ(cloud.points[i].cast<float>(), points[i]);
    for (std::size_t channel = 0; channel < 3; ++channel) {
      ASSERT_EQ(static_cast<std::uint8_t>(bytes[data + 15 * i + 12 + channel]), colour(i)[channel]);
    }
  }
}

TEST(ColouredCloudFile, NothingIsLeftWithoutCommit) {
  const test::TempDir dir;
  {
    ColouredCloudFile file(dir / "a.ply");
    file.add({1.0F, 2.0F, 3.0F}, {1, 2, 3});
  }
  EXPECT_TRUE(std::filesystem::is_empty(dir.path()));
  EXPECT_THROW(ColouredCloudFile(dir / "none/a.ply"), DataError);
  ColouredCloudFile pipe("/dev/null");
  EXPECT_THROW(pipe.commit(), DataError);
}

TEST(ColouredCloudFile, OnePointHasTheSameHeadLengthAsMany) {
  const test::TempDir dir;
  ColouredCloudFile file(dir / "a.ply");
  file.add({1.0F, 2.0F, 3.0F}, {1, 2, 3});
  file.commit();
  EXPECT_EQ(read_point_cloud(dir / "a.ply").points.size(), 1u);
}

}  // namespace
}  // namespace loopstone
