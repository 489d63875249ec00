#include "loopstone/formats/tum.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

#include "loopstone/base/error.hpp"
#include "loopstone/base/rng.hpp"
#include "loopstone/formats/decimal_stamp.hpp"
#include "support/temp_dir.hpp"

namespace loopstone {
namespace {

std::string error_of(std::string_view text) {
  try {
    (void)parse_tum(text, "t.tum");
  } catch (const DataError& error) {
    return error.what();
  }
  return "no error";
}

TEST(DecimalStamp, EveryNanosecondSurvives) {
  Rng rng(3);
  for (int i = 0; i < 20000; ++i) {
    const auto bits = static_cast<std::int64_t>(rng() >> rng.below(63));
    const Stamp stamp{i % 2 == 0 ? bits / 2 : -(bits / 2)};
    const auto back = parse_decimal_stamp(format_decimal_stamp(stamp));
    ASSERT_TRUE(back.has_value()) << stamp.nanoseconds;
    ASSERT_EQ(back->nanoseconds, stamp.nanoseconds);
  }
  EXPECT_EQ(format_decimal_stamp(Stamp{-5}), "-0.000000005");
  EXPECT_EQ(format_decimal_stamp(Stamp{1305031102175304001}), "1305031102.175304001");
}

TEST(DecimalStamp, ReadsWhatToolsWrite) {
  const auto ns = [](std::string_view text) {
    return parse_decimal_stamp(text).value_or(Stamp{-1}).nanoseconds;
  };
  EXPECT_EQ(ns("1"), 1000000000);
  EXPECT_EQ(ns("1."), 1000000000);
  EXPECT_EQ(ns(".5"), 500000000);
  EXPECT_EQ(ns("+0.25"), 250000000);
  EXPECT_EQ(ns("1.305031102175304000e+09"), 1305031102175304000);
  EXPECT_EQ(ns("15E-1"), 1500000000);
  EXPECT_EQ(ns("0.0000000005"), 1) << "rounded half up";
  EXPECT_EQ(ns("0.00000000049999"), 0);
  EXPECT_EQ(ns("1e-300"), 0);
  EXPECT_EQ(ns("0e300"), 0);
  for (const char* bad : {"", ".", "-", "1.2.3", "abc", "1e", "1e999999", "nan", "inf", "1 ",
                          "99999999999", "0x10", "1e11"}) {
    EXPECT_FALSE(parse_decimal_stamp(bad).has_value()) << bad;
  }
}

TEST(Tum, RoundTrip) {
  Rng rng(4);
  Trajectory trajectory;
  for (int i = 0; i < 500; ++i) {
    const double yaw = i == 0 ? kPi : rng.uniform(-kPi, kPi);
    trajectory.append(Stamp{1305031102175304001 + i * 24999999LL},
                      {rng.uniform(-300.0, 300.0), rng.normal(), yaw});
  }
  const Trajectory back = parse_tum(format_tum(trajectory));
  ASSERT_EQ(back.size(), trajectory.size());
  for (std::size_t i = 0; i < back.size(); ++i) {
    ASSERT_EQ(back.poses()[i].stamp, trajectory.poses()[i].stamp);
    ASSERT_NEAR(back.poses()[i].pose.x, trajectory.poses()[i].pose.x, 1e-9);
    ASSERT_NEAR(back.poses()[i].pose.y, trajectory.poses()[i].pose.y, 1e-9);
    ASSERT_NEAR(wrap_angle(back.poses()[i].pose.yaw - trajectory.poses()[i].pose.yaw), 0.0, 5e-9);
  }
}

TEST(Tum, LinesAreExact) {
  Trajectory trajectory;
  trajectory.append(Stamp{1500000000}, {1.0, -1e-12, 0.0});
  trajectory.append(Stamp{2500000007}, {1.0, 2.0, -kPi / 2});
  EXPECT_EQ(format_tum(trajectory),
            "1.500000000 1.000000000 0.000000000 0 0 0 0.000000000 1.000000000\n"
            "2.500000007 1.000000000 2.000000000 0 0 0 -0.707106781 0.707106781\n");
}

TEST(Tum, ReadsWhatOtherToolsWrite) {
  const Trajectory trajectory = parse_tum(
      "# timestamp tx ty tz qx qy qz qw\r\n"
      "2.0\t3 4 0.5 0 0 -0.70710678 -0.70710678\r\n"
      "\r\n"
      "1.000000000000000000e+00 1e0 2 0 0 0 0 1");
  ASSERT_EQ(trajectory.size(), 2U);
  EXPECT_EQ(trajectory.front().stamp.nanoseconds, 1000000000);
  EXPECT_NEAR(trajectory.back().pose.yaw, kPi / 2, 1e-7);
  EXPECT_NEAR(trajectory.back().pose.x, 3.0, 0.0);
}

TEST(Tum, DamageIsNamedWithItsLine) {
  EXPECT_NE(error_of("").find("t.tum: holds no poses"), std::string::npos);
  EXPECT_NE(error_of("# only\n").find("holds no poses"), std::string::npos);
  EXPECT_NE(error_of("1 0 0 0 0 0 0 1\n1 2 3\n").find("t.tum:2: expected 8 numbers"),
            std::string::npos);
  EXPECT_NE(error_of("1,0,0,0,0,0,0,1").find("expected 8"), std::string::npos);
  EXPECT_NE(error_of("1 0 0 0 0 0 0 0").find("t.tum:1: the quaternion has length 0"),
            std::string::npos);
  EXPECT_NE(error_of("1 nan 0 0 0 0 0 1").find("not finite"), std::string::npos);
  EXPECT_NE(error_of("1 x 0 0 0 0 0 1").find("'x' is no number"), std::string::npos);
  EXPECT_NE(error_of("t 0 0 0 0 0 0 1").find("no time"), std::string::npos);
  EXPECT_NE(error_of(std::string(2, '\0') + "\x80 0 0 0 0 0 0 1").find("t.tum:1"),
            std::string::npos);
}

TEST(Tum, FileRoundTrip) {
  const test::TempDir dir;
  Trajectory trajectory;
  trajectory.append(Stamp{7}, {1.0, 2.0, 3.0});
  write_tum(dir / "a.tum", trajectory);
  EXPECT_EQ(read_tum(dir / "a.tum").front().stamp.nanoseconds, 7);
  EXPECT_THROW((void)read_tum(dir / "b.tum"), DataError);
}

}  // namespace
}  // namespace loopstone
