#include "loopstone/simulation/world.hpp"

#include <array>

#include "loopstone/base/error.hpp"
#include "simulation/builtin_worlds.hpp"

namespace loopstone {
namespace {

struct Builder {
  std::string_view name;
  void (*build)(World&, Rng);
};

constexpr std::array kBuilders{
    Builder{"office", build_office},       Builder{"campus", build_campus},
    Builder{"corridor", build_corridor},   Builder{"rooms", build_rooms},
    Builder{"warehouse", build_warehouse}, Builder{"loops", build_loops},
    Builder{"wings", build_wings},         Builder{"aisles", build_aisles},
    Builder{"hall", build_hall},           Builder{"outdoors", build_outdoors}};

}  // namespace

const std::vector<std::string_view>& world_names() {
  static const std::vector<std::string_view> names = [] {
    std::vector<std::string_view> list;
    for (const Builder& builder : kBuilders) list.push_back(builder.name);
    return list;
  }();
  return names;
}

World make_world(std::string_view name, std::uint64_t seed) {
  for (const Builder& builder : kBuilders) {
    if (builder.name != name) continue;
    World world;
    world.name = name;
    world.seed = seed;
    builder.build(world, Rng(seed).fork(1));
    return world;
  }
  std::string known;
  for (const std::string_view each : world_names())
    known += (known.empty() ? "" : ", ") + std::string(each);
  throw UsageError("there is no built-in world '" + std::string(name) + "'; there are " + known +
                   ", and any map.yaml");
}

}  // namespace loopstone
