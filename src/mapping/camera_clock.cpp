#include "loopstone/mapping/camera_clock.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "loopstone/base/error.hpp"
#include "loopstone/geometry/angle.hpp"
#include "mapping/floor_alignment.hpp"
#include "mapping/smooth_pose.hpp"

namespace loopstone {
namespace {

constexpr double kOffsetStep_s = 0.005;
constexpr int kOffsetSteps = 60;  ///< to either side
constexpr double kMostOffset_s = kOffsetSteps * kOffsetStep_s;
/// Between the two pictures of a pair, at least; the longer one tells more while both still see the
/// same floor.
constexpr std::array kSpans_s{0.1, 0.3};
constexpr double kMostSpan_s = 0.5;
constexpr double kMostTurn_rad = 0.4;  ///< of a pair, so that it shares floor
constexpr double kMostTravel_m = 0.35;
constexpr double kLeastChange_rad_s = 0.05;  ///< of the turning during a pair: less tells nothing
constexpr double kNoise_rad = 0.001;         ///< of a pair's turning by the trajectory
constexpr std::size_t kFewestPairs = 8;
constexpr double kLargestSigma_s = 0.02;

/// Two pictures between which the robot changed how fast it turns.
struct Pair {
  std::size_t from = 0;
  std::size_t to = 0;
  double change_rad_s = 0.0;
};

std::optional<Pose2> motion_between(const Trajectory& trajectory, Stamp from, Stamp to,
                                    double late_s) {
  const Duration late = Duration::from_seconds(late_s);
  const auto a = smooth_pose_at(trajectory, from - late);
  const auto b = smooth_pose_at(trajectory, to - late);
  if (!a || !b) return {};
  return a->inverse() * *b;
}

std::optional<double> yaw_rate_at(const Trajectory& trajectory, Stamp stamp) {
  constexpr double kSpan_s = 0.06;
  const Duration half = Duration::from_seconds(0.5 * kSpan_s);
  const auto motion = motion_between(trajectory, stamp - half, stamp + half, 0.0);
  if (!motion) return {};
  return motion->yaw / kSpan_s;
}

/// For each frame the first one at least `span_s` later, where that pair tells something.
void add_pairs(const std::vector<RgbdFrame>& frames, const Trajectory& trajectory, double span_s,
               std::vector<Pair>& pairs) {
  std::size_t to = 0;
  for (std::size_t from = 0; from < frames.size(); ++from) {
    const Stamp start = frames[from].colour_stamp;
    to = std::max(to, from);
    while (to < frames.size() && (frames[to].colour_stamp - start).seconds() < span_s) ++to;
    if (to == frames.size()) break;
    const Stamp end = frames[to].colour_stamp;
    if ((end - start).seconds() > kMostSpan_s) continue;
    const auto motion = motion_between(trajectory, start, end, 0.0);
    const auto rate_from = yaw_rate_at(trajectory, start);
    const auto rate_to = yaw_rate_at(trajectory, end);
    if (!motion || !rate_from || !rate_to) continue;
    if (std::abs(motion->yaw) > kMostTurn_rad || motion->translation().norm() > kMostTravel_m) {
      continue;
    }
    const double change = std::abs(*rate_to - *rate_from);
    if (change > kLeastChange_rad_s) pairs.push_back({from, to, change});
  }
}

/// The pairs that tell most about the clock, in order of time.
std::vector<Pair> telling_pairs(const std::vector<RgbdFrame>& frames, const Trajectory& trajectory,
                                std::size_t most) {
  std::vector<Pair> pairs;
  for (const double span_s : kSpans_s) add_pairs(frames, trajectory, span_s, pairs);
  const auto more = [](const Pair& a, const Pair& b) {
    if (a.change_rad_s != b.change_rad_s) return a.change_rad_s > b.change_rad_s;
    return a.from != b.from ? a.from < b.from : a.to < b.to;
  };
  std::sort(pairs.begin(), pairs.end(), more);
  if (pairs.size() > most) pairs.resize(most);
  std::sort(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) {
    return a.from != b.from ? a.from < b.from : a.to < b.to;
  });
  return pairs;
}

/// How much the robot turned between two pictures, by the floor.
struct SeenTurn {
  Stamp from{};
  Stamp to{};
  double yaw_rad = 0.0;
  double variance_rad2 = 0.0;
};

/// Bounded, so that pairs of which the pictures tell something wrong do not decide (Geman and
/// McClure 1985).
double robust(double squared) {
  constexpr double kWidth2 = 9.0;
  return kWidth2 * squared / (kWidth2 + squared);
}

double cost_of(const std::vector<SeenTurn>& turns, const Trajectory& trajectory, double late_s) {
  double cost = 0.0;
  for (const SeenTurn& turn : turns) {
    const auto motion = motion_between(trajectory, turn.from, turn.to, late_s);
    if (!motion) continue;
    const double error = wrap_angle(turn.yaw_rad - motion->yaw);
    cost += robust(error * error / (turn.variance_rad2 + kNoise_rad * kNoise_rad));
  }
  return cost;
}

}  // namespace

CameraClock estimate_camera_clock(const RgbdSource& source, const Trajectory& trajectory,
                                  const CameraModel& camera, Threads threads,
                                  std::size_t most_pairs) {
  CameraClock clock;
  const std::vector<Pair> pairs = telling_pairs(source.frames, trajectory, most_pairs);
  if (pairs.size() < kFewestPairs) return clock;

  // A few at a time, each with an aligner of its own.
  const std::size_t lanes = static_cast<std::size_t>(threads.resolved());
  std::vector<std::optional<SeenTurn>> seen(pairs.size());
  constexpr double kFloorNoise_per_m = 0.003;  // only what stands on the floor must be told from it
  parallel_for(lanes, threads, [&](std::size_t lane) {
    FloorAligner aligner(camera, floor_plane_of(camera.robot_T_camera), kFloorNoise_per_m);
    for (std::size_t i = lane; i < pairs.size(); i += lanes) {
      const RgbdFrame& from = source.frames[pairs[i].from];
      const RgbdFrame& to = source.frames[pairs[i].to];
      std::vector<Pose2> guesses;
      for (const double late_s : {0.0, 0.1, -0.1, 0.2, -0.2, kMostOffset_s, -kMostOffset_s}) {
        if (const auto motion =
                motion_between(trajectory, from.colour_stamp, to.colour_stamp, late_s)) {
          guesses.push_back(*motion);
        }
      }
      try {
        const auto motion = aligner.align(source.load(from), source.load(to), guesses);
        if (motion) {
          seen[i] = SeenTurn{from.colour_stamp, to.colour_stamp, motion->from_T_to.yaw,
                             motion->covariance(2, 2)};
        }
      } catch (const DataError&) {  // counted when the frame's turn comes
      }
    }
  });
  std::vector<SeenTurn> turns;
  for (const auto& turn : seen) {
    if (turn) turns.push_back(*turn);
  }
  clock.pairs = static_cast<int>(turns.size());
  if (turns.size() < kFewestPairs) return clock;

  std::vector<double> costs;
  for (int step = -kOffsetSteps; step <= kOffsetSteps; ++step) {
    costs.push_back(cost_of(turns, trajectory, step * kOffsetStep_s));
  }
  const auto lowest = static_cast<std::size_t>(
      std::distance(costs.begin(), std::min_element(costs.begin(), costs.end())));
  if (lowest == 0 || lowest + 1 == costs.size()) return clock;
  // The parabola through the lowest cost and its neighbours; a sum of squares in sigmas has
  // curvature 2 / sigma^2, and the residuals that remain say whether the sigmas were true.
  const double curvature = (costs[lowest - 1] - 2.0 * costs[lowest] + costs[lowest + 1]) /
                           (kOffsetStep_s * kOffsetStep_s);
  if (curvature <= 0.0) return clock;
  const double slope = (costs[lowest + 1] - costs[lowest - 1]) / (2.0 * kOffsetStep_s);
  const double excess = std::max(1.0, costs[lowest] / (static_cast<double>(turns.size()) - 1.0));
  clock.late_s = (static_cast<double>(lowest) - kOffsetSteps) * kOffsetStep_s - slope / curvature;
  clock.sigma_s = std::sqrt(2.0 * excess / curvature);
  if (clock.sigma_s > kLargestSigma_s) return clock;
  clock.status = ClockStatus::kEstimated;
  return clock;
}

}  // namespace loopstone
