#include <cmath>
#include <cstdio>
#include <loopstone/base/rng.hpp>
#include <loopstone/geometry/pose2.hpp>
#include <loopstone/version.hpp>

int main() {
  const loopstone::Pose2 map_T_robot{1.0, 2.0, 0.5};
  const loopstone::Pose2 same = loopstone::exp(loopstone::log(map_T_robot));
  loopstone::Rng rng(1);
  std::printf("loopstone %s: x = %.3f, a number: %.3f\n", loopstone::kVersion.data(), same.x,
              rng.uniform());
  return std::abs(same.x - map_T_robot.x) < 1e-12 ? 0 : 1;
}
