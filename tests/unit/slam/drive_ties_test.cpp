#include "slam/drive_ties.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "loop_scene.hpp"
#include "loopstone/geometry/angle.hpp"

namespace loopstone {
namespace {

/// A wing: a corridor along x with a room at each end and boxes in it.
/// \param bend_m  of the corridor's middle
test::Walls wing(double bend_m) {
  return test::together({{{{-8.0, -2.0}, {8.0, -2.0}},
                          {{8.0, -2.0}, {8.0, 5.0}},
                          {{8.0, 5.0}, {-8.0, 5.0}},
                          {{-8.0, 5.0}, {-8.0, -2.0}},
                          {{-6.0, 1.2}, {0.0, 1.2 + bend_m}},
                          {{0.0, 1.2 + bend_m}, {6.0, 1.2}}},
                         test::rectangle({-3.0, -2.0}, {-2.2, -1.5}),
                         test::rectangle({4.0, -2.0}, {4.6, -1.6})});
}

/// As many rooms, and other ones.
test::Walls elsewhere() {
  return test::together({test::rectangle({-8.0, -2.0}, {8.0, 5.0}),
                         test::rectangle({-5.0, 0.5}, {-3.5, 3.0}),
                         test::rectangle({1.0, -0.5}, {5.0, 0.6})});
}

struct Drive {
  std::vector<SubmapRecord> submaps{};
  std::vector<Pose2> map_T_submaps{};
  [[nodiscard]] LaidDrive laid() const { return {submaps, map_T_submaps}; }
};

/// A submap every two metres along the corridor.
Drive drive_through(const test::Walls& place, double y, double from_x = -6.0) {
  const test::Scanner scanner{.angle_min_rad = -kPi, .beams = 720, .range_max_m = 12.0};
  Drive drive;
  for (double x = from_x; x < 6.0; x += 2.0) {
    const std::vector<Pose2> poses{{x, y, 0.0}, {x + 1.0, y, 0.0}};
    drive.submaps.emplace_back().freeze(
        test::submap_seen_from(place, poses, drive.submaps.size() - 1, scanner));
    drive.map_T_submaps.push_back(poses.front());
  }
  return drive;
}

SurfaceFit fit_between(const Drive& older, const Drive& newer) {
  return fit_of(older.laid(), newer.laid(), overlapping(older.laid(), newer.laid()), {}, {}, {2});
}

TEST(DriveTies, DrivesThroughOnePlaceShowIt) {
  const SurfaceFit fit = fit_between(drive_through(wing(0.0), 0.0), drive_through(wing(0.0), -0.4));
  EXPECT_TRUE(shows_one_place(fit, kDriveTies.usual_off))
      << fit.on << ' ' << fit.off << ' ' << fit.empty;
  EXPECT_GT(fit.on, 0.9 * fit.seen());
}

TEST(DriveTies, ACopyWithWallsBentByDecimetresIsAnotherPlace) {
  const SurfaceFit fit = fit_between(drive_through(wing(0.0), 0.0), drive_through(wing(0.3), -0.4));
  EXPECT_FALSE(shows_one_place(fit, kDriveTies.usual_off))
      << fit.on << ' ' << fit.off << ' ' << fit.empty;
}

TEST(DriveTies, OtherRoomsAreAnotherPlace) {
  const SurfaceFit fit =
      fit_between(drive_through(wing(0.0), 0.0), drive_through(elsewhere(), -1.0));
  EXPECT_GT(fit.empty, kDriveTies.most_empty * fit.seen());
  EXPECT_FALSE(shows_one_place(fit, kDriveTies.usual_off));
}

/// What a blurry laser sees differs from itself as much.
TEST(DriveTies, ADriveThatScattersIsAllowedAsMuch) {
  const SurfaceFit fit{.on = 900.0, .off = 90.0, .empty = 50.0};
  EXPECT_FALSE(shows_one_place(fit, 0.01));
  EXPECT_TRUE(shows_one_place(fit, 0.07));
}

TEST(DriveTies, ScatterIsOfWhatADriveSawAgain) {
  Drive drive = drive_through(wing(0.0), 0.0);
  EXPECT_LT(scatter_of(drive.laid(), {}, {}, {1}), kDriveTies.usual_off);
  const Drive bent = drive_through(wing(0.3), -0.4);
  for (std::size_t i = 0; i < bent.submaps.size(); ++i) {
    drive.submaps.push_back(bent.submaps[i]);
    drive.map_T_submaps.push_back(bent.map_T_submaps[i]);
  }
  EXPECT_GT(scatter_of(drive.laid(), {}, {}, {1}), kDriveTies.usual_off);
  drive = drive_through(wing(0.0), 0.0, 5.0);
  EXPECT_EQ(scatter_of(drive.laid(), {}, {}, {1}), kDriveTies.usual_off) << "it never came back";
}

TEST(DriveTies, WhatNobodySawTwiceShowsNothing) { EXPECT_FALSE(shows_one_place({}, 1.0)); }

TEST(DriveTies, FitsAreTheSameForAnyNumberOfThreads) {
  const Drive older = drive_through(wing(0.0), 0.0);
  const Drive newer = drive_through(wing(0.1), -0.4);
  const auto pairs = overlapping(older.laid(), newer.laid());
  const SurfaceFit one = fit_of(older.laid(), newer.laid(), pairs, {}, {}, {1});
  const SurfaceFit four = fit_of(older.laid(), newer.laid(), pairs, {}, {}, {4});
  EXPECT_EQ(one.on, four.on);
  EXPECT_EQ(one.off, four.off);
  EXPECT_EQ(one.empty, four.empty);
}

TEST(DriveTies, EachSubmapIsAskedAboutTheNearestOfTheOther) {
  const Drive older = drive_through(wing(0.0), 0.0);
  Drive newer = drive_through(wing(0.0), -0.4);
  const auto pairs = overlapping(older.laid(), newer.laid());
  ASSERT_EQ(pairs.size(), kDriveTies.beside_max * newer.submaps.size());
  for (const SubmapPair& pair : pairs) {
    const auto apart_m = [&](std::size_t other) {
      return (older.map_T_submaps[other] * older.submaps[other].centre -
              newer.map_T_submaps[pair.newer.index] * newer.submaps[pair.newer.index].centre)
          .norm();
    };
    std::size_t nearer = 0;
    for (std::size_t other = 0; other < older.submaps.size(); ++other)
      if (apart_m(other) < apart_m(pair.older.index)) ++nearer;
    EXPECT_LT(nearer, kDriveTies.beside_max);
  }
  for (Pose2& pose : newer.map_T_submaps) pose.y += 100.0;
  EXPECT_TRUE(overlapping(older.laid(), newer.laid()).empty());
}

TEST(DriveTies, OfALongDriveSoManySubmapsAreAskedSpreadEvenly) {
  const Drive older = drive_through(wing(0.0), 0.0);
  Drive newer;
  const std::size_t count = 5 * kDriveTies.submaps_max / 2;
  for (std::size_t i = 0; i < count; ++i) {
    newer.submaps.push_back(older.submaps[2]);
    newer.map_T_submaps.push_back(older.map_T_submaps[2]);
  }
  const auto pairs = overlapping(older.laid(), newer.laid());
  ASSERT_EQ(pairs.size(), kDriveTies.beside_max * kDriveTies.submaps_max);
  EXPECT_EQ(pairs.front().newer.index, 0U);
  EXPECT_GE(pairs.back().newer.index, count - 3);
}

}  // namespace
}  // namespace loopstone
