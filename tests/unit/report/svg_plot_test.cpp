#include "report/svg_plot.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <limits>

#include "report/motion_profile.hpp"

namespace loopstone {
namespace {

TEST(SvgPlot, TicksAreRoundAndInside) {
  EXPECT_EQ(round_ticks(0.0, 10.0, 5), (std::vector<double>{0, 2, 4, 6, 8, 10}));
  EXPECT_EQ(round_ticks(-0.13, 0.11, 5).size(), 5U);
  EXPECT_TRUE(round_ticks(1.0, 1.0, 5).empty());
  for (double size = 1e-6; size < 1e7; size *= 1.7) {
    const auto ticks = round_ticks(-0.3 * size, 0.7 * size, 6);
    EXPECT_GE(ticks.size(), 2U) << size;
    EXPECT_LE(ticks.size(), 8U) << size;
    for (const double tick : ticks) {
      EXPECT_GE(tick, -0.3 * size * 1.0001);
      EXPECT_LE(tick, 0.7 * size * 1.0001);
    }
  }
}

TEST(SvgPlot, EqualAxesKeepShapes) {
  PlotSpec spec{.x_label = "x", .y_label = "y", .equal_axes = true};
  spec.curves.push_back({"square", "a", {0, 10, 10, 0, 0}, {0, 0, 10, 10, 0}});
  const std::string svg = svg_plot(spec);
  const auto begin = svg.find("class=\"curve a\" d=\"M");
  ASSERT_NE(begin, std::string::npos);
  double x[3];
  double y[3];
  ASSERT_EQ(std::sscanf(svg.c_str() + begin, "class=\"curve a\" d=\"M%lf %lfL%lf %lfL%lf %lf",
                        &x[0], &y[0], &x[1], &y[1], &x[2], &y[2]),
            6);
  EXPECT_NEAR(x[1] - x[0], y[1] - y[2], 0.3) << "a square stays a square, y upwards";
}

TEST(SvgPlot, NothingToDrawIsNoPlot) {
  EXPECT_EQ(svg_plot({}), "");
  PlotSpec spec;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  spec.curves.push_back({"a", "a", {0, 1, 2}, {nan, nan, 1}});
  EXPECT_EQ(svg_plot(spec), "");
  spec.curves[0].y = {1, 1, 1};
  EXPECT_EQ(svg_plot(spec).find("nan"), std::string::npos) << "a constant is a plot, too";
  spec.curves[0].label = "<&>";
  spec.curves.push_back(spec.curves[0]);
  EXPECT_NE(svg_plot(spec).find("&lt;&amp;&gt;"), std::string::npos);
}

TEST(SvgPlot, BandsLieBehindTheCurvesAndWithinTheAxes) {
  PlotSpec spec{.x_label = "time", .y_label = "share"};
  spec.curves.push_back({"a", "a", {0, 5, 10}, {0.4, 0.5, 0.6}});
  spec.bands = {{"lost", -3.0, 5.0}, {"tracking", 5.0, 99.0}};
  spec.y_shown = {0.0, 1.0};
  const std::string svg = svg_plot(spec);
  const auto lost = svg.find("<rect class=\"band lost\"");
  const auto tracking = svg.find("<rect class=\"band tracking\"");
  ASSERT_NE(lost, std::string::npos);
  ASSERT_NE(tracking, std::string::npos);
  EXPECT_LT(tracking, svg.find("class=\"curve a\"")) << "drawn later lies on top";
  double x[2];
  double width[2];
  ASSERT_EQ(
      std::sscanf(svg.c_str() + lost, "<rect class=\"band lost\" x=\"%lf\" y=\"%*f\" width=\"%lf",
                  &x[0], &width[0]),
      2);
  ASSERT_EQ(std::sscanf(svg.c_str() + tracking,
                        "<rect class=\"band tracking\" x=\"%lf\" y=\"%*f\" width=\"%lf", &x[1],
                        &width[1]),
            2);
  EXPECT_NEAR(x[0] + width[0], x[1], 0.2) << "they meet";
  EXPECT_NEAR(width[0], width[1], 0.2) << "cut at the ends of the axis";
  EXPECT_NE(svg.find(">0</text>"), std::string::npos) << "the axis reaches what was asked for";
  EXPECT_NE(svg.find(">1</text>"), std::string::npos);
}

TEST(MotionProfile, CircleHasConstantSpeedAndYawRate) {
  Trajectory trajectory;
  Pose2 pose;
  for (int i = 0; i < 1000; ++i) {
    trajectory.append(Stamp{i * 50000000LL}, pose);
    pose = pose * exp(Tangent2(0.05, 0.0, -0.02));
  }
  const MotionProfile profile = motion_profile(trajectory, 90);
  ASSERT_EQ(profile.time_s.size(), 90U);
  for (std::size_t i = 0; i < 90; ++i) {
    EXPECT_NEAR(profile.speed_m_s[i], 1.0, 1e-9);
    EXPECT_NEAR(profile.yaw_rate_rad_s[i], -0.4, 1e-9);
  }
  EXPECT_TRUE(motion_profile(Trajectory{}, 10).time_s.empty());
}

}  // namespace
}  // namespace loopstone
