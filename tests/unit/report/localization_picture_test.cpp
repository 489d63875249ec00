#include "loopstone/report/localization_picture.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "localization_scene.hpp"
#include "report/localization_figures.hpp"
#include "report/state_style.hpp"

namespace loopstone {
namespace {

using test::small_localization;
using test::small_room;

/// How many pixels of about this colour there are, and where their middle is.
struct Found {
  int count = 0;
  double row = 0.0;
  double column = 0.0;
};

Found find(const Image& image, const Colour& colour, int rows) {
  Found found;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < image.width; ++column) {
      const double off = std::abs(image.sample(row, column, 0) - 255.0 * colour.red) +
                         std::abs(image.sample(row, column, 1) - 255.0 * colour.green) +
                         std::abs(image.sample(row, column, 2) - 255.0 * colour.blue);
      if (off > 12.0) continue;
      ++found.count;
      found.row += row;
      found.column += column;
    }
  }
  found.row /= std::max(found.count, 1);
  found.column /= std::max(found.count, 1);
  return found;
}

/// Without the strip below.
int map_rows(const Image& image) { return image.height * 85 / 100; }

const Colour kTracking = state_colour(LocalizationState::kTracking);
const Colour kDoubtful = state_colour(LocalizationState::kDoubtful);
const Colour kLost = state_colour(LocalizationState::kLost);

TEST(LocalizationPicture, PathHasTheColourOfItsState) {
  LocalizationResult result = small_localization();
  result.snapshots.clear();
  result.searches.clear();
  const Image image = draw_localization_picture(result, small_room(), {.target_side_px = 1000});
  const Found tracking = find(image, kTracking, map_rows(image));
  const Found doubtful = find(image, kDoubtful, map_rows(image));
  const Found lost = find(image, kLost, map_rows(image));
  EXPECT_GT(tracking.count, 500);
  EXPECT_GT(doubtful.count, 40);
  EXPECT_GT(lost.count, 10);
  // It was lost at first, at the left and near the upper wall.
  EXPECT_LT(lost.row, tracking.row);
  EXPECT_LT(lost.column, tracking.column);
  EXPECT_LT(doubtful.column, tracking.column);
}

TEST(LocalizationPicture, ParticlesLieWhereTheyAre) {
  LocalizationResult result = small_localization();
  result.searches.clear();
  LocalizationResult none = result;
  for (BeliefSnapshot& snapshot : none.snapshots) snapshot.particles.clear();
  const Image with = draw_localization_picture(result, small_room(), {.target_side_px = 1000});
  const Image without = draw_localization_picture(none, small_room(), {.target_side_px = 1000});
  ASSERT_EQ(with.bytes.size(), without.bytes.size());
  int changed_left = 0;
  for (int row = 0; row < map_rows(with); ++row) {
    for (int column = 0; column < with.width; ++column) {
      if (column < with.width / 4 && with.sample(row, column) != without.sample(row, column))
        ++changed_left;
    }
  }
  EXPECT_GT(changed_left, 1000) << "the wide cloud of the lost robot";
}

TEST(LocalizationPicture, StaysWithinBoundsAndDrawsAnything) {
  const LocalizationResult result = small_localization();
  const Image small = draw_localization_picture(result, small_room());
  EXPECT_GT(std::max(small.width, small.height), 900);
  EXPECT_LT(std::max(small.width, small.height), 2300);
  const GridFrame frame{.origin = {0.0, 0.0}, .resolution = 0.05, .columns = 9000, .rows = 700};
  const Grid<std::int8_t> wide(frame, 0);
  const Image large = draw_localization_picture(result, wide);
  EXPECT_LE(large.width, 4000);
  EXPECT_GT(large.width, 2000);
  (void)draw_localization_picture({}, small_room());
  LocalizationResult one = result;
  one.estimates.resize(1);
  (void)draw_localization_picture(one, small_room());
}

TEST(BeliefPicture, ShowsTheWholeMapWhereTheBeliefIsWide) {
  const LocalizationResult result = small_localization();
  const Grid<std::int8_t> room = small_room();
  const BeliefPainter painter(room, result.estimates.front().stamp,
                              {.width_px = 400, .close_up_m = 2.0, .whole_map = false});
  const Image lost = painter.draw(result.snapshots.front());
  const Image tracking = painter.draw(result.snapshots[3]);
  EXPECT_EQ(lost.width, tracking.width);
  EXPECT_EQ(lost.height, tracking.height);
  // In a close-up of 2 m in the middle of the room there is no wall; the whole room has some.
  const Colour wall = hex_colour(0x161b26);
  EXPECT_GT(find(lost, wall, lost.height).count, 500);
  EXPECT_LT(find(tracking, wall, tracking.height).count, 100);
}

TEST(BeliefPicture, SaysTheState) {
  const LocalizationResult result = small_localization();
  const Grid<std::int8_t> room = small_room();
  const BeliefPainter painter(room, result.estimates.front().stamp);
  const auto chip = [&](const BeliefSnapshot& snapshot, const Colour& colour) {
    const Image image = painter.draw(snapshot);
    return find(image, colour, 40).count;
  };
  EXPECT_GT(chip(result.snapshots.front(), kLost), 1000);
  EXPECT_EQ(chip(result.snapshots.front(), kTracking), 0);
  EXPECT_GT(chip(result.snapshots.back(), kTracking), 1000);
  EXPECT_EQ(chip(result.snapshots.back(), kLost), 0);
}

TEST(BeliefPicture, BeliefsWithoutAnythingAreDrawn) {
  const Grid<std::int8_t> room = small_room();
  const BeliefPainter painter(room, Stamp{});
  BeliefSnapshot nothing;
  (void)painter.draw(nothing);
  nothing.estimate.map_T_robot = {1e4, -1e4, 1.0};
  nothing.estimate.covariance.setIdentity();
  (void)painter.draw(nothing);
}

/// What the three colours are to eyes without one kind of cones.
/// Source: Machado, Oliveira and Fernandes 2009, severity 1, on linear RGB.
TEST(StateColours, CanBeToldApartWithoutOneKindOfCones) {
  using Matrix = std::array<std::array<double, 3>, 3>;
  const Matrix normal{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  const Matrix protan{{{0.152286, 1.052583, -0.204868},
                       {0.114503, 0.786281, 0.099216},
                       {-0.003882, -0.048116, 1.051998}}};
  const Matrix deutan{{{0.367322, 0.860646, -0.227968},
                       {0.280085, 0.672501, 0.047413},
                       {-0.011820, 0.042940, 0.968881}}};
  const Matrix tritan{{{1.255528, -0.076749, -0.178779},
                       {-0.078411, 0.930809, 0.147602},
                       {0.004733, 0.691367, 0.303900}}};
  const auto linear = [](double c) {
    return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
  };
  // CIE L*a*b*, in which equal distances look about equally far.
  const auto seen = [&](const Colour& colour, const Matrix& eye) {
    const double rgb[] = {linear(colour.red), linear(colour.green), linear(colour.blue)};
    double s[3];
    for (std::size_t i = 0; i < 3; ++i) {
      s[i] = 0.0;
      for (std::size_t k = 0; k < 3; ++k) s[i] += eye[i][k] * rgb[k];
      s[i] = std::clamp(s[i], 0.0, 1.0);
    }
    const auto f = [](double t) { return t > 0.008856 ? std::cbrt(t) : 7.787 * t + 16.0 / 116.0; };
    const double x = f((0.4124 * s[0] + 0.3576 * s[1] + 0.1805 * s[2]) / 0.9505);
    const double y = f(0.2126 * s[0] + 0.7152 * s[1] + 0.0722 * s[2]);
    const double z = f((0.0193 * s[0] + 0.1192 * s[1] + 0.9505 * s[2]) / 1.089);
    return std::array<double, 3>{116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)};
  };
  for (const Matrix& eye : {normal, protan, deutan, tritan}) {
    const std::array<std::array<double, 3>, 3> colours{seen(kTracking, eye), seen(kDoubtful, eye),
                                                       seen(kLost, eye)};
    for (std::size_t a = 0; a < 3; ++a) {
      for (std::size_t b = a + 1; b < 3; ++b) {
        const double distance =
            std::hypot(colours[a][0] - colours[b][0], colours[a][1] - colours[b][1],
                       colours[a][2] - colours[b][2]);
        EXPECT_GT(distance, 30.0) << a << " and " << b;
      }
    }
  }
}

TEST(StateRuns, EndWhereTheStateChangesOrThePoseJumps) {
  const LocalizationResult result = small_localization();
  const auto& estimates = result.estimates;
  EXPECT_EQ(state_runs(estimates).size(), 5u);
  EXPECT_TRUE(is_jump(estimates[19], estimates[20])) << "4.5 m in a tenth of a second";
  EXPECT_FALSE(is_jump(estimates[20], estimates[21]));
  const auto runs = state_runs(estimates, [](std::size_t i) { return i == 150; });
  ASSERT_EQ(runs.size(), 6u);
  EXPECT_EQ(runs.back().first, 150u);
  EXPECT_EQ(runs.back().last, 200u);
  EXPECT_EQ(runs[4].last, 149u);
}

TEST(EstimateAt, IsTheLastOneUntilThen) {
  const LocalizationResult result = small_localization();
  const Stamp start = result.estimates.front().stamp;
  EXPECT_EQ(estimate_at(result, start + Duration{150'000'000}), &result.estimates[1]);
  EXPECT_EQ(estimate_at(result, start + Duration{100'000'000}), &result.estimates[1]);
  EXPECT_EQ(estimate_at(result, start - Duration{1}), &result.estimates[0]);
  EXPECT_EQ(estimate_at(result, start + Duration::from_seconds(99.0)), &result.estimates[200]);
  EXPECT_EQ(estimate_at({}, start), nullptr);
}

}  // namespace
}  // namespace loopstone
