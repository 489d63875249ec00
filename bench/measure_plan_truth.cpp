// Prints what stands in a built-in world, as JSON, for bench/plans.py:
//   measure_plan_truth WORLD SEED

#include <cstdio>
#include <cstdlib>
#include <exception>

#include "loopstone/simulation/world.hpp"

namespace loopstone::bench {
namespace {

void print(const World& world) {
  std::printf("{\"boxes\": [");
  const char* between = "";
  for (const Box& box : world.plan.boxes) {
    std::printf("%s\n[%.9f, %.9f, %.9f, %.9f, %.9f, %s]", between, box.map_T_box.x, box.map_T_box.y,
                box.map_T_box.yaw, box.length_m, box.width_m, box.is_wall ? "true" : "false");
    between = ",";
  }
  std::printf("],\n\"circles\": [");
  between = "";
  for (const Circle& circle : world.plan.circles) {
    std::printf("%s\n[%.9f, %.9f, %.9f]", between, circle.centre.x(), circle.centre.y(),
                circle.radius_m);
    between = ",";
  }
  std::printf("]}\n");
}

}  // namespace
}  // namespace loopstone::bench

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr, "usage: measure_plan_truth WORLD SEED\n");
    return 2;
  }
  try {
    loopstone::bench::print(
        loopstone::make_world(argv[1], static_cast<std::uint64_t>(std::atoll(argv[2]))));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  return 0;
}
