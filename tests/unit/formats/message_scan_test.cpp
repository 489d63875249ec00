// Scans and clouds as messages hold them become ours.

#include "formats/message_scan.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <rapidcheck/gtest.h>

#include <array>
#include <chrono>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <random>

#include "loopstone/geometry/angle.hpp"
#include "loopstone/messages/message_codec.hpp"
#include "support/generators.hpp"
#include "support/pose_near.hpp"

namespace loopstone {
namespace {

using test::pose_near;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Pair;

constexpr float kInf = std::numeric_limits<float>::infinity();
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

msg::LaserScan message(std::vector<float> ranges) {
  msg::LaserScan scan{.header = {Stamp{17}, "laser"}};
  scan.angle_min = -1.0F;
  scan.angle_increment = 0.1F;
  scan.angle_max = -1.0F + 0.1F * static_cast<float>(ranges.size() - 1);
  scan.range_min = 0.1F;
  scan.range_max = 30.0F;
  scan.ranges = std::move(ranges);
  return scan;
}
LaserScan converted(const msg::LaserScan& scan, double period_s = 0.1) {
  ScanRemarks remarks;
  LaserScan result = to_laser_scan(scan, period_s, remarks);
  EXPECT_THAT(remarks.counts(), IsEmpty());
  return result;
}
std::string remark_of(const msg::LaserScan& scan, LaserScan& result, double period_s = 0.1) {
  ScanRemarks remarks;
  result = to_laser_scan(scan, period_s, remarks);
  return remarks.counts().empty() ? "" : remarks.counts().begin()->first;
}

TEST(MessageScan, RangesFollowRep117) {
  const auto ranges = converted(message({1.0F, 0.1F, 0.05F, 0.0F, -kInf, kInf, kNan, 30.0F, 29.99F,
                                         65.533F, -1.0F}))
                          .ranges_m;
  EXPECT_THAT(ranges, ElementsAre(1.0F, 0.1F, testing::IsNan(), testing::IsNan(), testing::IsNan(),
                                  kInf, testing::IsNan(), kInf, 29.99F, kInf, testing::IsNan()));
}

TEST(MessageScan, LimitsThatAreNone) {
  msg::LaserScan scan = message({1.0F, 500.0F, 0.0F});
  scan.range_min = kNan;
  scan.range_max = 0.0F;
  LaserScan read;
  EXPECT_THAT(remark_of(scan, read), HasSubstr("how far the laser sees"));
  EXPECT_EQ(read.range_min_m, 0.0);
  EXPECT_EQ(read.range_max_m, 100.0);
  EXPECT_THAT(read.ranges_m, ElementsAre(1.0F, kInf, testing::IsNan()));
  scan.range_max = kInf;
  EXPECT_EQ(remark_of(scan, read), "");
  EXPECT_TRUE(std::isfinite(read.range_max_m));
  EXPECT_EQ(read.ranges_m[1], 500.0F);
}

TEST(MessageScan, AnglesThatDoNotFit) {
  msg::LaserScan scan = message(std::vector<float>(11, 1.0F));
  scan.angle_min = 1.0F;
  scan.angle_max = -1.0F;
  scan.angle_increment = -0.2F;
  EXPECT_NEAR(converted(scan).angle_rad(10), -1.0, 1e-6) << "clockwise";
  LaserScan read;
  scan.angle_max = 5.0F;
  EXPECT_THAT(remark_of(scan, read), HasSubstr("the angle between beams is believed"));
  EXPECT_NEAR(read.angle_increment_rad, -0.2, 1e-6);
  scan.angle_max = -1.0F;
  for (const float none : {0.0F, kNan}) {
    scan.angle_increment = none;
    EXPECT_THAT(remark_of(scan, read), HasSubstr("follows from the first and last"));
    EXPECT_NEAR(read.angle_increment_rad, -0.2, 1e-6);
  }
  scan.angle_max = scan.angle_min;
  EXPECT_THROW((void)remark_of(scan, read), MessageError);
  scan.angle_min = kNan;
  EXPECT_THROW((void)remark_of(scan, read), MessageError);
  scan = message(std::vector<float>(200, 1.0F));
  EXPECT_THROW((void)remark_of(scan, read), MessageError) << "three turns";
  EXPECT_THROW((void)remark_of(message({}), read), MessageError);
  EXPECT_EQ(converted(message({1.0F})).ranges_m.size(), 1u);
}

TEST(MessageScan, ASweepLongerThanThePeriodIsNotBelieved) {
  msg::LaserScan scan = message(std::vector<float>(20, 1.0F));
  scan.time_increment = 0.005F;
  EXPECT_NEAR(converted(scan).time_increment_s, 0.005, 1e-9);
  LaserScan read;
  for (const float wrong : {0.01F, 5.0F, kNan, kInf, -1.0F}) {
    scan.time_increment = wrong;
    EXPECT_THAT(remark_of(scan, read), HasSubstr("the time between beams can't be")) << wrong;
    EXPECT_EQ(read.time_increment_s, 0.0);
  }
  scan.time_increment = 0.01F;
  EXPECT_EQ(remark_of(scan, read, 0.0), "") << "the period is not known";
}

TEST(MessageScan, OfEchoesTheFirstOrTheStrongest) {
  msg::MultiEchoLaserScan scan{.angle_min = 0.0F,
                               .angle_max = 0.4F,
                               .angle_increment = 0.1F,
                               .range_min = 0.1F,
                               .range_max = 30.0F};
  scan.ranges = {{{1.0F, 2.0F}}, {{}}, {{3.0F, 4.0F}}, {{5.0F, 6.0F}}, {{kInf}}};
  scan.intensities = {{{10.0F, 20.0F}}, {{}}, {{7.0F}}};
  ScanRemarks remarks;
  EXPECT_THAT(to_laser_scan(scan, EchoUse::kFirst, 0.1, remarks).ranges_m,
              ElementsAre(1.0F, testing::IsNan(), 3.0F, 5.0F, kInf));
  EXPECT_THAT(to_laser_scan(scan, EchoUse::kStrongest, 0.1, remarks).ranges_m,
              ElementsAre(2.0F, testing::IsNan(), 3.0F, 5.0F, kInf))
      << "strengths that do not fit the ranges say nothing";
}

/// The points of a scan in the robot's frame, as the plane sees them.
std::vector<Eigen::Vector2d> points_of(const LaserScan& scan) {
  std::vector<Eigen::Vector2d> points;
  for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
    const double angle = scan.angle_rad(i);
    const double range = static_cast<double>(scan.ranges_m[i]);
    points.push_back(*scan.robot_T_lidar *
                     Eigen::Vector2d(range * std::cos(angle), range * std::sin(angle)));
  }
  return points;
}

RC_GTEST_PROP(MessageScanLaw, PlacedScansHaveThePointsThatTheFullTransformGives, ()) {
  std::vector<float> ranges;
  for (int i = 0; i < 20; ++i) ranges.push_back(static_cast<float>(*test::between(0.2, 20.0)));
  msg::LaserScan told = message(ranges);
  if (*rc::gen::arbitrary<bool>()) {
    told.angle_min = 1.5F;
    told.angle_increment = -0.1F;
    told.angle_max = 1.5F - 1.9F;
  }
  ScanRemarks remarks;
  LaserScan scan = to_laser_scan(told, 0.1, remarks);
  const bool down = *rc::gen::arbitrary<bool>();
  const bool by_pitch = *rc::gen::arbitrary<bool>();
  const Pose3 base_T_laser = Pose3::from_roll_pitch_yaw(
      {*test::between(-1, 1), *test::between(-1, 1), *test::between(0, 1)},
      down && !by_pitch ? kPi : 0.0, down && by_pitch ? kPi : 0.0, *test::any_angle());
  std::vector<Eigen::Vector2d> wanted;
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    const double angle = static_cast<double>(told.angle_min) +
                         static_cast<double>(i) * static_cast<double>(told.angle_increment);
    const double range = static_cast<double>(ranges[i]);
    const Eigen::Vector3d point =
        base_T_laser * Eigen::Vector3d(range * std::cos(angle), range * std::sin(angle), 0.0);
    wanted.push_back(point.head<2>());
  }
  place(base_T_laser, scan);
  const auto points = points_of(scan);
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    RC_ASSERT((points[i] - wanted[i]).norm() < 1e-5);
  }
}

TEST(MessageScan, BecomesTheSameMessageAgain) {
  LaserScan scan{.stamp = Stamp{1'234'567'891},
                 .angle_min_rad = 1.5,
                 .angle_increment_rad = -0.25,
                 .range_min_m = 0.25,
                 .range_max_m = 32.0,
                 .time_increment_s = 0.0009765625,
                 .ranges_m = {1.0F, kInf, kNan, 0.25F}};
  const msg::LaserScan told = to_message(scan, "laser");
  EXPECT_EQ(told.header.frame_id, "laser");
  EXPECT_FLOAT_EQ(told.angle_max, 0.75F);
  EXPECT_FLOAT_EQ(told.scan_time, 4 * 0.0009765625F);
  const LaserScan again = converted(told);
  EXPECT_EQ(again.stamp, scan.stamp);
  EXPECT_EQ(again.angle_min_rad, scan.angle_min_rad);
  EXPECT_EQ(again.angle_increment_rad, scan.angle_increment_rad);
  EXPECT_EQ(again.range_max_m, scan.range_max_m);
  EXPECT_EQ(again.time_increment_s, scan.time_increment_s);
  EXPECT_THAT(again.ranges_m, ElementsAre(1.0F, kInf, testing::IsNan(), 0.25F));
}

// Clouds.

/// Makes the bytes of clouds.
struct CloudMaker {
  bool big = false;
  std::uint32_t point_step = 23;
  std::string time_field{};
  std::uint8_t time_type = 0;

  template <typename Number>
  void put(msg::PointCloud2& cloud, std::size_t at, Number value) const {
    std::array<std::uint8_t, sizeof(Number)> bytes{};
    std::memcpy(bytes.data(), &value, sizeof value);
    if (big) std::reverse(bytes.begin(), bytes.end());
    std::copy(bytes.begin(), bytes.end(), cloud.data.begin() + static_cast<std::ptrdiff_t>(at));
  }
  [[nodiscard]] msg::PointCloud2 empty() const {
    using msg::PointField;
    msg::PointCloud2 cloud{.header = {Stamp{5'000'000'000}, "velodyne"}, .height = 1};
    cloud.fields = {{"x", 1, PointField::kFloat32, 1},
                    {"y", 5, PointField::kFloat32, 1},
                    {"z", 9, PointField::kFloat32, 1}};
    if (!time_field.empty()) cloud.fields.push_back({time_field, 13, time_type, 1});
    cloud.is_bigendian = big;
    cloud.point_step = point_step;
    return cloud;
  }
  void add(msg::PointCloud2& cloud, const Eigen::Vector3d& point, double time_s = 0.0) const {
    using msg::PointField;
    const std::size_t at = cloud.data.size();
    cloud.data.resize(at + point_step);
    put(cloud, at + 1, static_cast<float>(point.x()));
    put(cloud, at + 5, static_cast<float>(point.y()));
    put(cloud, at + 9, static_cast<float>(point.z()));
    if (time_type == PointField::kFloat32) put(cloud, at + 13, static_cast<float>(time_s));
    if (time_type == PointField::kFloat64) put(cloud, at + 13, time_s);
    if (time_type == PointField::kUint32) {
      put(cloud, at + 13, static_cast<std::uint32_t>(std::lround(1e9 * time_s)));
    }
    ++cloud.width;
    cloud.row_step = cloud.width * point_step;
  }
};

/// To the wall of a room of 8 m by 6 m around the robot's origin.
double wall_range(const Eigen::Vector2d& from, double angle) {
  const double dx = std::cos(angle);
  const double dy = std::sin(angle);
  const double tx = dx > 0 ? (4.0 - from.x()) / dx : dx < 0 ? (-4.0 - from.x()) / dx : 1e9;
  const double ty = dy > 0 ? (3.0 - from.y()) / dy : dy < 0 ? (-3.0 - from.y()) / dy : 1e9;
  return std::min(tx, ty);
}

/// What a spinning scanner with 16 rings sees of that room, floor and all.
msg::PointCloud2 room(const CloudMaker& maker, const Pose3& base_T_laser, int steps = 1440,
                      double start_rad = 0.3, bool clockwise = false, double first_s = 0.0) {
  msg::PointCloud2 cloud = maker.empty();
  for (int step = 0; step < steps; ++step) {
    const double turned = start_rad + (clockwise ? -1 : 1) * 2.0 * kPi * step / steps;
    for (int ring = -8; ring < 8; ++ring) {
      const double up = radians(2.0 * ring + 1.0);
      const Eigen::Vector3d ray(std::cos(up) * std::cos(turned), std::cos(up) * std::sin(turned),
                                std::sin(up));
      const Eigen::Vector3d seen = base_T_laser.rotation * ray;
      const Eigen::Vector2d from = base_T_laser.translation.head<2>();
      double range = wall_range(from, std::atan2(seen.y(), seen.x())) / seen.head<2>().norm();
      if (seen.z() < 0.0) range = std::min(range, -base_T_laser.translation.z() / seen.z());
      maker.add(cloud, range * ray, first_s + 0.1 * step / steps);
    }
  }
  return cloud;
}

TEST(CloudSlice, OfARoomIsWhatAPlanarLaserWouldSee) {
  for (const bool big : {false, true}) {
    for (const double roll : {0.0, 0.2, kPi}) {
      const Pose3 base_T_laser = Pose3::from_roll_pitch_yaw({0.5, -0.3, 1.0}, roll, 0.0, 1.0);
      const auto cloud = room({.big = big}, base_T_laser, 7200);
      const LaserScan scan = slice(cloud, base_T_laser, {0.5, 1.5});
      ASSERT_EQ(scan.ranges_m.size(), 720u);
      EXPECT_EQ(scan.stamp, cloud.header.stamp);
      EXPECT_EQ(scan.time_increment_s, 0.0);
      EXPECT_TRUE(pose_near(*scan.robot_T_lidar, Pose2{0.5, -0.3, 0.0}, 1e-12, 1e-12));
      std::size_t seen = 0;
      for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
        if (std::isnan(scan.ranges_m[i])) continue;
        ++seen;
        const double angle = scan.angle_rad(i);
        // Within a beam the nearest point counts.
        double low = 1e9;
        double high = 0.0;
        for (const double off : {-0.5, -0.25, 0.0, 0.25, 0.5}) {
          const double range = wall_range({0.5, -0.3}, angle + off * scan.angle_increment_rad);
          low = std::min(low, range);
          high = std::max(high, range);
        }
        EXPECT_GT(static_cast<double>(scan.ranges_m[i]), low - 0.01) << i;
        EXPECT_LT(static_cast<double>(scan.ranges_m[i]), high + 0.01) << i;
      }
      EXPECT_GT(seen, 650u) << roll;
    }
  }
}

TEST(CloudSlice, IgnoresWhatIsTooHighOrLow) {
  const CloudMaker maker;
  auto cloud = maker.empty();
  maker.add(cloud, {3.0, 0.0, 0.0});
  maker.add(cloud, {1.0, 0.0, -0.5});
  maker.add(cloud, {2.0, 0.0, 0.6});
  maker.add(cloud, {0.01, 0.0, 0.0});
  maker.add(cloud, {0.0, 0.0, 0.0});
  maker.add(cloud, {std::nan(""), 0.0, 0.0});
  maker.add(cloud, {0.0, 1e6, 0.0});
  const Pose3 up{{0, 0, 0.5}};
  const LaserScan scan = slice(cloud, up, slice_about(up));
  std::vector<float> seen;
  for (const float range : scan.ranges_m) {
    if (!std::isnan(range)) seen.push_back(range);
  }
  EXPECT_THAT(seen, ElementsAre(3.0F));
}

struct Timing {
  const char* name;
  const char* field;
  std::uint8_t type;
  double first_s;
  bool clockwise;
};
class TimedCloud : public testing::TestWithParam<Timing> {};

TEST_P(TimedCloud, BecomesASweep) {
  const Timing& timing = GetParam();
  const Pose3 up{{0, 0, 1.0}};
  const auto cloud = room({.time_field = timing.field, .time_type = timing.type}, up, 1440, 0.3,
                          timing.clockwise, timing.first_s);
  const LaserScan scan = slice(cloud, up, {0.5, 1.5});
  EXPECT_NEAR(scan.time_increment_s, 0.1 / 720, 2e-6);
  EXPECT_NEAR(std::abs(scan.angle_increment_rad), kPi / 360, 1e-12);
  EXPECT_EQ(scan.angle_increment_rad < 0.0, timing.clockwise);
  EXPECT_NEAR(wrap_angle(scan.angle_min_rad - 0.3), 0.0, 0.01);
  const bool is_stamp = timing.first_s > 1e6;
  EXPECT_NEAR((scan.stamp - cloud.header.stamp).seconds(), is_stamp ? 0.0 : timing.first_s, 3e-4);
  for (std::size_t i = 0; i < 720; i += 7) {
    if (std::isnan(scan.ranges_m[i])) continue;
    EXPECT_NEAR(static_cast<double>(scan.ranges_m[i]), wall_range({0, 0}, scan.angle_rad(i)), 0.05);
  }
}

INSTANTIATE_TEST_SUITE_P(
    All, TimedCloud,
    testing::Values(Timing{"seconds", "time", msg::PointField::kFloat32, 0.0, false},
                    Timing{"before_the_stamp", "time", msg::PointField::kFloat32, -0.1, true},
                    Timing{"nanoseconds", "t", msg::PointField::kUint32, 0.0, false},
                    Timing{"nanoseconds_clockwise", "t", msg::PointField::kUint32, 0.02, true},
                    Timing{"stamps", "timestamp", msg::PointField::kFloat64, 1.7e9, false}),
    [](const auto& given) { return given.param.name; });

TEST(CloudSlice, TimesThatAreNoSweepAreLeftAlone) {
  const Pose3 up{{0, 0, 1.0}};
  const CloudMaker maker{.time_field = "time", .time_type = msg::PointField::kFloat32};
  auto cloud = room(maker, up);
  std::mt19937 random(1);
  for (std::size_t at = 13; at < cloud.data.size(); at += 23) {
    maker.put(cloud, at, random() % 3 == 0 ? kNan : static_cast<float>(random() % 1000));
  }
  const LaserScan scan = slice(cloud, up, {0.5, 1.5});
  EXPECT_EQ(scan.time_increment_s, 0.0);
  EXPECT_EQ(scan.stamp, cloud.header.stamp);
}

TEST(CloudSlice, RowsMayHaveGapsOrStateNoLength) {
  const CloudMaker maker;
  auto cloud = maker.empty();
  maker.add(cloud, {1.0, 0.0, 0.0});
  maker.add(cloud, {0.0, 2.0, 0.0});
  const auto ranges = [](const msg::PointCloud2& told) {
    std::vector<float> seen;
    for (const float range : slice(told, {}, {-1, 1}).ranges_m) {
      if (!std::isnan(range)) seen.push_back(range);
    }
    return seen;
  };
  EXPECT_THAT(ranges(cloud), ElementsAre(1.0F, 2.0F));
  cloud.row_step = 0;
  EXPECT_THAT(ranges(cloud), ElementsAre(1.0F, 2.0F));
  cloud.height = 2;
  cloud.width = 1;
  EXPECT_THAT(ranges(cloud), ElementsAre(1.0F, 2.0F)) << "packed";
  cloud.row_step = 30;
  cloud.data.insert(cloud.data.begin() + 23, 7, std::uint8_t{0xff});
  EXPECT_THAT(ranges(cloud), ElementsAre(1.0F, 2.0F)) << "padded rows";
}

TEST(CloudSlice, HostileLayoutsAreRefusedOrBounded) {
  const CloudMaker maker;
  auto good = maker.empty();
  for (int i = 0; i < 100; ++i) maker.add(good, {1.0, 0.01 * i, 0.0});
  const auto start = std::chrono::steady_clock::now();
  const auto refused = [&](auto&& change) {
    auto cloud = good;
    change(cloud);
    EXPECT_THROW((void)slice(cloud, {}, {-1, 1}), MessageError);
  };
  const auto bounded = [&](auto&& change) {
    auto cloud = good;
    change(cloud);
    EXPECT_EQ(slice(cloud, {}, {-1, 1}).ranges_m.size(), 720u);
  };
  constexpr std::uint32_t kMost = 0xffffffffU;
  refused([](auto& c) { c.point_step = 0; });
  refused([](auto& c) { c.fields[1].offset = 20; });
  refused([](auto& c) { c.fields[1].offset = kMost; });
  refused([](auto& c) { c.fields[2].datatype = 9; });
  refused([](auto& c) { c.fields[2].datatype = 0; });
  refused([](auto& c) { c.fields.pop_back(); });
  refused([](auto& c) { c.height = kMost, c.row_step = 1; });
  bounded([](auto& c) { c.width = kMost; });
  bounded([](auto& c) {
    c.height = c.width = c.row_step = kMost, c.point_step = 23;
    c.width = 9;
  });
  bounded([](auto& c) { c.height = kMost, c.width = 0; });
  bounded([](auto& c) { c.height = kMost, c.width = 1, c.row_step = 0; });
  bounded([](auto& c) { c.height = kMost; });
  bounded([](auto& c) { c.point_step = kMost; });
  bounded([](auto& c) { c.data.clear(); });
  bounded([](auto& c) { c.data.resize(c.data.size() - 1); });
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(10));
}

}  // namespace
}  // namespace loopstone
