#pragma once

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "loopstone/geometry/pose2.hpp"
#include "pairs_file.hpp"

// What matchers answer, one line a pair, the same for ours and others':
//   pair x y yaw converged cpu_ms [covariance: xx xy xyaw yy yyaw yawyaw]
namespace loopstone::bench {

/// CPU time of this thread [s].
[[nodiscard]] inline double thread_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

struct Answer {
  Pose2 target_T_source;
  bool converged = false;  ///< what the matcher says of itself
  std::optional<Eigen::Matrix3d> covariance{};
};

/// The returns of a scan as points in the lidar's frame.
[[nodiscard]] inline std::vector<Eigen::Vector2d> points_of(const LaserScan& scan) {
  std::vector<Eigen::Vector2d> points;
  for (std::size_t beam = 0; beam < scan.ranges_m.size(); ++beam) {
    const double range = scan.ranges_m[beam];
    const double angle = scan.angle_rad(beam);
    if (std::isfinite(range)) points.emplace_back(range * std::cos(angle), range * std::sin(angle));
  }
  return points;
}

using Points = std::vector<Eigen::Vector2d>;

/// A pair with its returns as points, which are made outside the measured time.
struct PairToMatch {
  const StoredPair& pair;
  Points target;
  Points source;
};
using Matcher = std::function<Answer(const PairToMatch&)>;

/// Asks a matcher about `count` pairs, evenly spread over the file, and prints its answers. A few
/// calls before warm it up.
inline void answer_pairs(const std::string& path, const Matcher& matcher, std::size_t count) {
  const std::vector<StoredPair> pairs = read_pairs(path);
  count = std::min(pairs.size(), count);
  constexpr std::size_t kWarmUp = 3;
  for (std::size_t i = 0; i < count + kWarmUp; ++i) {
    const std::size_t number = i < kWarmUp ? 0 : (i - kWarmUp) * pairs.size() / count;
    const StoredPair& pair = pairs.at(number);
    const PairToMatch input{pair, points_of(pair.target), points_of(pair.source)};
    const double start = thread_seconds();
    const Answer answer = matcher(input);
    const double took = thread_seconds() - start;
    if (i < kWarmUp) continue;
    const Pose2& pose = answer.target_T_source;
    std::printf("%zu %.9g %.9g %.9g %d %.6f", number, pose.x, pose.y, pose.yaw,
                answer.converged ? 1 : 0, 1e3 * took);
    if (answer.covariance) {
      const Eigen::Matrix3d& c = *answer.covariance;
      std::printf(" %.9g %.9g %.9g %.9g %.9g %.9g", c(0, 0), c(0, 1), c(0, 2), c(1, 1), c(1, 2),
                  c(2, 2));
    }
    std::printf("\n");
  }
}

struct NamedMatcher {
  std::string name;
  Matcher matcher;
};

/// main() of a program that has nothing but matchers: PROGRAM FILE MATCHER COUNT; without arguments
/// it lists them.
inline int answer_main(int argc, char** argv, const std::vector<NamedMatcher>& matchers) {
  if (argc != 4) {
    for (const NamedMatcher& known : matchers) std::printf("%s\n", known.name.c_str());
    return argc == 1 ? 0 : 2;
  }
  try {
    for (const NamedMatcher& known : matchers) {
      if (known.name == argv[2]) {
        answer_pairs(argv[1], known.matcher, std::stoul(argv[3]));
        return 0;
      }
    }
    throw std::runtime_error(std::string(argv[2]) + ": no such matcher");
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}

}  // namespace loopstone::bench
