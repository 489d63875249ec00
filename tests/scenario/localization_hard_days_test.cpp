// A robot on a map that is known, on days when something fails: its laser is covered, its odometry
// says what is not so.

#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "localization_drives.hpp"
#include "support/simulated_log.hpp"

namespace loopstone::test {
namespace {

using Fault = SimulatedOdometryFault;

Drive drive_in(const std::string& world, std::uint64_t seed, const SimulationOptions& options) {
  return on_its_map(simulate_log(world, seed, options));
}

class CoveredLaser : public testing::TestWithParam<const char*> {};

TEST_P(CoveredLaser, RidesOnOdometryAndIsRightAgainWithinAMetre) {
  constexpr double kFromS = 20.0;
  constexpr double kUntilS = 50.0;
  const std::uint64_t seeds = small_scale() ? 1 : 3;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    SimulationOptions options{.duration_s = 70.0, .odometry_poses = true};
    options.laser.beams = 361;
    const Drive drive = covered(drive_in(GetParam(), seed, options), 0, kFromS, kUntilS);
    const LocalizationResult result = localize(drive, guess_of(drive));
    EXPECT_EQ(judge(result, drive).wrong_tracking, 0) << "seed " << seed;
    double seen_again_m = 0.0;
    double wrong_until_m = 0.0;
    bool tracks_again = false;
    int not_doubtful = 0;
    for (const LocalizationEstimate& estimate : result.estimates) {
      const double time_s = (estimate.stamp - drive.truth.front().stamp).seconds();
      // Later it may be anywhere within metres.
      const bool is_riding = time_s > kFromS + 3.0 && time_s < kFromS + 15.0;
      if (is_riding && estimate.state != LocalizationState::kDoubtful) ++not_doubtful;
      if (time_s <= kUntilS) seen_again_m = estimate.travelled_m;
      if (time_s <= kUntilS) continue;
      if (!error_of(estimate, drive).right()) wrong_until_m = estimate.travelled_m - seen_again_m;
      tracks_again = tracks_again || estimate.state == LocalizationState::kTracking;
    }
    EXPECT_EQ(not_doubtful, 0) << "seed " << seed;
    EXPECT_LE(wrong_until_m, 1.0) << "seed " << seed;
    EXPECT_TRUE(tracks_again) << "seed " << seed;
  }
}

// Rooms that are all alike: no search tells where the robot is once it has lost its way.
INSTANTIATE_TEST_SUITE_P(Worlds, CoveredLaser, testing::Values("office", "rooms"),
                         [](const auto& world) { return std::string(world.param); });

struct Failure {
  Fault fault;
  const char* name;
  std::vector<std::string> warnings;  ///< one of these words
};

class FailingOdometry : public testing::TestWithParam<Failure> {};

TEST_P(FailingOdometry, IsNoticedAndTheLaserTellsTheWay) {
  const std::uint64_t seeds = small_scale() ? 1 : 2;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    SimulationOptions options{.duration_s = 60.0, .odometry_poses = true};
    options.laser.beams = 361;
    options.faults = {.odometry = GetParam().fault, .from_s = 15.0, .to_s = 45.0};
    const Drive drive = drive_in("office", seed, options);
    const LocalizationResult result = localize(drive, guess_of(drive));
    const Verdict verdict = judge(result, drive);
    EXPECT_GE(verdict.right, 0.98 * verdict.scans) << "seed " << seed;
    EXPECT_GE(verdict.tracking, 0.9 * verdict.scans) << "seed " << seed;
    EXPECT_LE(verdict.wrong_tracking, 0.002 * verdict.scans) << "seed " << seed;
    const bool is_told = std::ranges::any_of(result.warnings, [](const std::string& text) {
      return text.starts_with("odometry was not used") &&
             std::ranges::any_of(GetParam().warnings, [&](const std::string& words) {
               return text.find(words) != std::string::npos;
             });
    });
    EXPECT_TRUE(is_told) << "seed " << seed << ": " << testing::PrintToString(result.warnings);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Faults, FailingOdometry,
    testing::Values(Failure{Fault::kStuck, "stuck", {"stands still while the robot"}},
                    Failure{Fault::kScaled, "scaled", {"times the true one"}},
                    Failure{Fault::kMirrored, "mirrored", {"turns the other way", "its heading"}}),
    [](const auto& failure) { return std::string(failure.param.name); });

TEST(SoundOdometry, IsAccusedOfNothing) {
  for (const char* world : {"office", "warehouse", "corridor"}) {
    SimulationOptions options{.duration_s = small_scale() ? 40.0 : 90.0, .people = 5};
    options.laser.beams = 361;
    const Drive drive = drive_in(world, 3, options);
    EXPECT_TRUE(localize(drive, guess_of(drive)).warnings.empty()) << world;
  }
}

}  // namespace
}  // namespace loopstone::test
