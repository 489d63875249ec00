#include "loopstone/mapping/map_quality.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

#include "loopstone/base/rng.hpp"
#include "loopstone/geometry/angle.hpp"
#include "mapping/judged_scans.hpp"
#include "mapping/map_entropy.hpp"
#include "mapping/visit_agreement.hpp"
#include "mapping/wall_pieces.hpp"
#include "support/segment_world.hpp"

namespace loopstone {
namespace {

const Pose2 kMount{0.14, 0.0, 0.1};

/// Two rounds through a furnished room, about 17 m each.
struct Drive {
  std::vector<LaserScan> scans;
  std::vector<Pose2> truth;
  std::vector<int> round;

  /// The scans at poses that are wrong by `error(i)`, in the map frame.
  template <typename Error>
  [[nodiscard]] std::vector<PosedScan> posed(Error&& error) const {
    std::vector<PosedScan> result;
    for (std::size_t i = 0; i < scans.size(); ++i) {
      const Pose2 map_T_robot = error(i) * truth[i];
      const Pose2 map_T_lidar = map_T_robot * kMount;
      result.push_back({&scans[i], map_T_lidar, map_T_lidar, map_T_robot});
    }
    return result;
  }
  [[nodiscard]] std::vector<PosedScan> posed() const {
    return posed([](std::size_t) { return Pose2{}; });
  }
  /// The second round moved: every wall of the room, all along x or y, lies `offset_m` beside
  /// itself.
  [[nodiscard]] std::vector<PosedScan> doubled(double offset_m) const {
    return posed([&](std::size_t i) {
      return round[i] == 0 ? Pose2{} : Pose2{offset_m, offset_m, 0.0};
    });
  }
};

Drive make_drive(double noise_m) {
  Drive drive;
  const std::vector<Eigen::Vector2d> corners{{1.2, 1.2}, {6.5, 1.2}, {6.5, 4.6}, {1.3, 4.6}};
  std::vector<Eigen::Vector2d> points;
  for (int round = 0; round < 2; ++round)
    points.insert(points.end(), corners.begin(), corners.end());
  points.push_back(corners.front());
  const test::Scanner scanner{
      .angle_increment_rad = radians(1.0), .beams = 271, .noise_m = noise_m};
  Rng rng(7);
  const auto walls = test::furnished_room();
  drive.truth = test::drive_through(points, 0.1, 0.15);
  double travelled_m = 0.0;
  for (std::size_t i = 0; i < drive.truth.size(); ++i) {
    if (i > 0) {
      travelled_m += (drive.truth[i].translation() - drive.truth[i - 1].translation()).norm();
    }
    drive.round.push_back(travelled_m < 17.4 ? 0 : 1);
    drive.scans.push_back(test::scan_from(walls, drive.truth[i], kMount, scanner, &rng));
  }
  return drive;
}

const Drive& exact_drive() {
  static const Drive drive = make_drive(0.0);
  return drive;
}
const Drive& noisy_drive() {
  static const Drive drive = make_drive(0.01);
  return drive;
}

TEST(MapQuality, PerfectScansAtPerfectPosesAgree) {
  const MapQuality quality = assess_map(exact_drive().posed());
  EXPECT_GT(quality.walls_compared, 500);
  EXPECT_GT(quality.beams_tested, 1000);
  EXPECT_GT(quality.held_out_returns, 1000);
  EXPECT_GT(quality.entropy_points, 100);
  EXPECT_LT(quality.sensor_noise_m, 1e-4);
  EXPECT_LT(quality.wall_thickness_m, 0.002);
  EXPECT_LT(quality.doubled_share, 0.01);
  EXPECT_LT(quality.crossed_share, 0.005);
  EXPECT_GT(quality.held_out_agreement, 0.99);
  EXPECT_NEAR(quality.entropy_gain_nats, 0.0, 0.2);
  EXPECT_LE(quality.places_in_trouble() * 20, quality.places.size());
}

TEST(MapQuality, ThicknessIsTheNoiseWhenPosesAreRight) {
  const MapQuality quality = assess_map(noisy_drive().posed());
  // Across the wall: 1 cm along the beam, and walls are rarely met head on.
  EXPECT_GT(quality.sensor_noise_m, 0.0065);
  EXPECT_LT(quality.sensor_noise_m, 0.01);
  EXPECT_GT(quality.wall_thickness_m, quality.sensor_noise_m);
  EXPECT_LT(quality.wall_thickness_m, 0.012);
  EXPECT_LT(quality.crossed_share, 0.005);
}

TEST(MapQuality, WallsDrawnTwiceShowHowFarApartTheyLie) {
  const double noise_m = assess_map(noisy_drive().posed()).sensor_noise_m;
  double crossed_before = -1.0;
  for (const double offset_m : {0.0, 0.08, 0.15, 0.25}) {
    const MapQuality quality = assess_map(noisy_drive().doubled(offset_m));
    EXPECT_NEAR(quality.wall_offset_m, offset_m, 0.2 * offset_m + 0.01) << offset_m;
    EXPECT_NEAR(quality.sensor_noise_m, noise_m, 5e-4) << "the scanner has not changed";
    EXPECT_EQ(quality.held_out_agreement<0.85, offset_m> 0.05) << offset_m;
    if (offset_m > kMapQuality.doubled_m) {
      EXPECT_GT(quality.doubled_share, 0.5) << offset_m;
      EXPECT_GT(quality.crossed_share, crossed_before) << offset_m;
      EXPECT_GT(quality.crossed_share, 0.1) << offset_m;
      EXPECT_GT(quality.places_in_trouble() * 2, quality.places_revisited()) << offset_m;
    } else {
      EXPECT_LT(quality.doubled_share, 0.1) << offset_m;
      crossed_before = std::max(crossed_before, quality.crossed_share);
    }
  }
}

TEST(MapQuality, TroubleIsShownWhereItIs) {
  // Only scans in the right half of the room are wrong, so its left wall stays thin.
  const Drive& drive = noisy_drive();
  const auto posed = drive.posed([&](std::size_t i) {
    return drive.round[i] == 1 && drive.truth[i].x > 4.0 ? Pose2{0.2, 0.2, 0.0} : Pose2{};
  });
  const MapQuality quality = assess_map(posed);
  int right = 0;
  for (const QualityPlace& place : quality.places) {
    if (place.centre.x() > 7.0F && place.is_doubled()) ++right;
  }
  EXPECT_GE(right, 5);
  const QualityPlace* cleanest = nullptr;
  for (const QualityPlace& place : quality.places) {
    if (place.compared < 3) continue;
    if (cleanest == nullptr || place.offset_m < cleanest->offset_m) cleanest = &place;
  }
  ASSERT_NE(cleanest, nullptr);
  EXPECT_LT(cleanest->offset_m, 0.08F);
}

TEST(MapQuality, EveryFigureGetsWorseWithTheErrorOfPoses) {
  const Drive& drive = noisy_drive();
  std::vector<MapQuality> found;
  for (const double sigma_m : {0.0, 0.02, 0.06, 0.15}) {
    Rng rng(3);  // the same directions for every size
    std::vector<Pose2> errors;
    for (int piece = 0; piece < 40; ++piece)
      errors.push_back(
          Pose2{sigma_m * rng.normal(), sigma_m * rng.normal(), 0.2 * sigma_m * rng.normal()});
    found.push_back(
        assess_map(drive.posed([&](std::size_t i) { return errors[i / 24 % errors.size()]; })));
  }
  for (std::size_t i = 1; i < found.size(); ++i) {
    EXPECT_GT(found[i].wall_thickness_m, found[i - 1].wall_thickness_m) << i;
    EXPECT_GT(found[i].entropy_nats, found[i - 1].entropy_nats) << i;
    EXPECT_LT(found[i].held_out_agreement, found[i - 1].held_out_agreement) << i;
    EXPECT_GE(found[i].doubled_share, found[i - 1].doubled_share) << i;
  }
  EXPECT_GT(found.back().crossed_share, found.front().crossed_share + 0.05);
}

TEST(MapQuality, IsTheSameWhereverTheMapLies) {
  const Drive& drive = noisy_drive();
  const MapQuality here = assess_map(drive.doubled(0.12));
  const Pose2 elsewhere{813.37, -402.21, 0.7};
  const MapQuality there = assess_map(drive.posed([&](std::size_t i) {
    return elsewhere * (drive.round[i] == 0 ? Pose2{} : Pose2{0.12, 0.12, 0.0});
  }));
  // Cells fall differently, so figures agree to what that costs.
  EXPECT_NEAR(static_cast<double>(here.scans), static_cast<double>(there.scans), 10.0);
  EXPECT_NEAR(here.sensor_noise_m, there.sensor_noise_m, 2e-4);
  EXPECT_NEAR(here.wall_offset_m, there.wall_offset_m, 0.01);
  EXPECT_NEAR(here.wall_thickness_m, there.wall_thickness_m, 0.01);
  EXPECT_NEAR(here.crossed_share, there.crossed_share, 0.05);
  EXPECT_NEAR(here.held_out_agreement, there.held_out_agreement, 0.05);
  EXPECT_NEAR(here.entropy_gain_nats, there.entropy_gain_nats, 0.15);
}

TEST(MapQuality, SaysNothingWhereNothingWasSeenTwice) {
  EXPECT_EQ(assess_map({}).scans, 0);
  const auto posed = exact_drive().posed();
  const PosedScan without_scan;
  EXPECT_EQ(assess_map(std::vector<PosedScan>{without_scan}).scans, 0);
  for (const std::size_t count : {std::size_t{1}, std::size_t{2}, std::size_t{40}}) {
    const MapQuality quality = assess_map(std::span(posed).first(count));
    EXPECT_EQ(quality.walls_compared, 0) << count;
    EXPECT_EQ(quality.beams_tested, 0) << count;
    EXPECT_EQ(quality.held_out_returns, 0) << count;
    EXPECT_EQ(quality.entropy_points, 0) << count;
    EXPECT_EQ(quality.places_revisited(), 0U) << count;
  }
}

auto figures(const MapQuality& q) {
  return std::tuple(q.scans, q.visits, q.returns, q.sensor_noise_m, q.local_spread_m,
                    q.walls_compared, q.wall_offset_m, q.wall_offset_worst_m, q.doubled_share,
                    q.wall_thickness_m, q.entropy_points, q.entropy_nats, q.entropy_gain_nats,
                    q.beams_tested, q.crossed_share, q.held_out_returns, q.held_out_agreement,
                    q.places.size(), q.places_in_trouble());
}

TEST(MapQuality, IsTheSameForAnyNumberOfThreads) {
  const auto posed = noisy_drive().doubled(0.15);
  const MapQuality one = assess_map(posed, {1});
  const MapQuality many = assess_map(posed, {5});
  EXPECT_EQ(figures(one), figures(many));
  for (std::size_t i = 0; i < one.places.size(); ++i) {
    EXPECT_EQ(one.places[i].centre, many.places[i].centre);
    EXPECT_EQ(one.places[i].offset_m, many.places[i].offset_m);
    EXPECT_EQ(one.places[i].crossed, many.places[i].crossed);
  }
}

/// What the parts work on.
struct Parts {
  std::vector<JudgedScan> scans;
  PieceIndex index;
};

Parts parts_of(const std::vector<PosedScan>& posed) {
  auto scans = judged_scans(posed, {1});
  std::vector<WallPiece> pieces;
  for (std::size_t first = 0; first < scans.size();) {
    std::size_t end = first;
    while (end < scans.size() && scans[end].stretch == scans[first].stretch) ++end;
    const auto walls = stretch_walls(std::span(scans).subspan(first, end - first));
    pieces.insert(pieces.end(), walls.pieces.begin(), walls.pieces.end());
    first = end;
  }
  return {std::move(scans), PieceIndex(std::move(pieces), kWallPieces.piece_m)};
}

TEST(WallOffsets, AreThoseOfASearchThroughAllPieces) {
  const Parts parts = parts_of(noisy_drive().doubled(0.1));
  const auto& pieces = parts.index.items();
  ASSERT_GT(pieces.size(), 1000U);
  ASSERT_LT(pieces.size(), 20000U) << "all of them look for theirs";
  std::vector<float> naive;
  for (const WallPiece& piece : pieces) {
    std::vector<std::pair<int, float>> nearest;
    for (const WallPiece& other : pieces) {
      const Eigen::Vector2f offset = other.position - piece.position;
      const float across = std::abs(piece.normal.dot(offset));
      const float along = std::abs(piece.normal.x() * offset.y() - piece.normal.y() * offset.x());
      if (std::abs(other.stretch - piece.stretch) < kMapQuality.stretches_apart || along > 0.07F ||
          across > static_cast<float>(kMapQuality.most_offset_m) ||
          piece.normal.dot(other.normal) < 0.9F) {
        continue;
      }
      const auto found = std::find_if(nearest.begin(), nearest.end(), [&](const auto& pair) {
        return pair.first == other.stretch;
      });
      if (found == nearest.end()) {
        nearest.emplace_back(other.stretch, across);
      } else {
        found->second = std::min(found->second, across);
      }
    }
    for (const auto& pair : nearest) naive.push_back(pair.second);
  }
  std::vector<float> fast;
  for (const WallOffset& offset : wall_offsets(parts.index, 100, {2}))
    fast.push_back(offset.offset_m);
  std::sort(naive.begin(), naive.end());
  std::sort(fast.begin(), fast.end());
  EXPECT_EQ(fast, naive);
}

TEST(BeamMeetings, CrossOnlyWhatASearchThroughAllPiecesCrosses) {
  const Parts parts = parts_of(noisy_drive().doubled(0.25));
  constexpr float kMargin = 0.1F;
  std::size_t naive = 0;
  for (const JudgedScan& scan : parts.scans) {
    for (const JudgedBeam& beam : scan.beams) {
      const Eigen::Vector2f way = beam.end - beam.start;
      const bool crosses = std::any_of(
          parts.index.items().begin(), parts.index.items().end(), [&](const auto& piece) {
            if (std::abs(piece.stretch - scan.stretch) < kMapQuality.stretches_apart) return false;
            const float before = piece.normal.dot(beam.start - piece.position);
            const float behind = piece.normal.dot(beam.end - piece.position);
            if (before <= kMargin || behind >= -kMargin || before - behind < 0.34F * way.norm())
              return false;
            const Eigen::Vector2f at = beam.start + way * (before / (before - behind));
            return (at - piece.position).norm() <= 0.05F;
          });
      if (crosses) ++naive;
    }
  }
  const auto meetings = beam_meetings(parts.scans, parts.index, kMargin, {2});
  const auto crossed = static_cast<std::size_t>(std::count_if(
      meetings.begin(), meetings.end(), [](const auto& m) { return m.crossed >= 0; }));
  ASSERT_GT(naive, 1000U);
  EXPECT_LE(crossed, naive);
  EXPECT_GE(10 * crossed, 9 * naive) << "only cells that the beam passes are looked at";
  EXPECT_TRUE(
      beam_meetings(parts.scans, PieceIndex({}, kWallPieces.piece_m), kMargin, {1}).empty());
}

TEST(MapEntropy, GrowsByTheLogarithmOfTheThickness) {
  // Two visits to one straight wall, each with noise of 1 cm, the second beside the first: variance
  // s^2 + (d / 2)^2.
  const auto wall = [](double offset_m) {
    Rng rng(11);
    std::vector<JudgedScan> scans(2);
    for (std::size_t visit = 0; visit < 2; ++visit) {
      scans[visit].stretch = static_cast<int>(visit) * kMapQuality.stretches_apart;
      for (int i = 0; i < 1500; ++i) {
        const Eigen::Vector2f at(
            static_cast<float>(0.0027 * i),
            static_cast<float>(0.01 * rng.normal() + static_cast<double>(visit) * offset_m));
        scans[visit].returns.push_back({at, at, {0.0F, 1.0F}});
      }
    }
    return map_entropy(scans, {2});
  };
  for (const double offset_m : {0.0, 0.02, 0.1}) {
    const MapEntropy entropy = wall(offset_m);
    EXPECT_GT(entropy.points, 1000);
    const double ratio = std::hypot(0.01, 0.5 * offset_m) / 0.01;
    EXPECT_NEAR(entropy.mean_nats - entropy.stretch_nats, std::log(ratio), 0.08) << offset_m;
    // Along the wall: a uniform spread over 2 r = 0.6 m, variance r^2 / 3; a little less at the
    // ends.
    EXPECT_NEAR(entropy.stretch_nats,
                std::log(2.0 * kPi) + 1.0 + 0.5 * std::log(0.09 / 3.0 * 1.0e-4), 0.15)
        << offset_m;
  }
}

}  // namespace
}  // namespace loopstone
