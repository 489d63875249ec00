// Finds robots on maps by single scans, and prints how that went as one JSON object:
//   measure_relocalize PLACE [key=value]...
// Keys: seed, scans, clutter (things gone from the map, and as many that it lacks), map_seed (the
// map is that of another place of the kind), places (of the kind, with seeds one after the other,
// side by side on one map), prepared_times (of which the least time counts).

#include <fmt/format.h>

#include <algorithm>
#include <ctime>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "localization_runs.hpp"
#include "loopstone/localization/relocalize.hpp"
#include "registration_pairs.hpp"

namespace loopstone::bench {
namespace {

double cpu_ms() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

struct Request {
  std::string place;
  std::uint64_t seed = 1;
  int scans = 100;
  int clutter = 0;
  std::uint64_t map_seed = 0;
  int places = 1;
  int prepared_times = 1;
};

Request parse(int argc, char** argv) {
  if (argc < 2) throw std::invalid_argument("usage: measure_relocalize PLACE [key=value]...");
  Request request{.place = argv[1]};
  for_each_setting(argc, argv, [&](const std::string& key, const std::string& value) {
    if (key == "seed")
      request.seed = std::stoull(value);
    else if (key == "scans")
      request.scans = std::stoi(value);
    else if (key == "clutter")
      request.clutter = std::stoi(value);
    else if (key == "map_seed")
      request.map_seed = std::stoull(value);
    else if (key == "places")
      request.places = std::stoi(value);
    else if (key == "prepared_times")
      request.prepared_times = std::stoi(value);
    else
      throw std::invalid_argument("unknown key: " + key);
  });
  return request;
}

/// The least of some.
double preparing_ms(const Grid<std::int8_t>& map, int times) {
  double least = 1e12;
  for (int i = 0; i < times; ++i) {
    const double start = cpu_ms();
    const LocalizationMap prepared(map);
    least = std::min(least, cpu_ms() - start);
  }
  return least;
}

/// A place of a site: what the robot meets there, and what the site's map shows of it.
struct Place {
  World world;
  Grid<std::int8_t> bare;
  Grid<std::int8_t> map;
  SurfaceIndex surfaces;
  Eigen::Vector2d on_map{0.0, 0.0};  ///< where the site's map has the place's origin
};

Place place_of(const Request& request, std::uint64_t seed, Rng& rng) {
  World world = make_world(request.place, seed);
  World mapped = world;
  const Grid<std::int8_t> bare = true_map(world, 0.05);
  Grid<std::int8_t> map = bare;
  if (request.clutter > 0) {
    add_clutter(mapped, bare, request.clutter, rng);
    add_clutter(world, bare, request.clutter, rng);
    map = true_map(mapped, 0.05);
  }
  if (request.map_seed != 0) map = true_map(make_world(request.place, request.map_seed), 0.05);
  SurfaceIndex surfaces(world.plan);
  return {std::move(world), bare, std::move(map), std::move(surfaces)};
}

/// One map of all, four in a row, two metres of unknown between them. A single one stays as it is.
Grid<std::int8_t> side_by_side(std::vector<Place>& places) {
  if (places.size() == 1) return places.front().map;
  constexpr int kInARow = 4;
  constexpr int kBetween = 40;
  int columns = 0;
  int rows = 0;
  for (const Place& place : places) {
    columns = std::max(columns, place.map.frame().columns + kBetween);
    rows = std::max(rows, place.map.frame().rows + kBetween);
  }
  const auto count = static_cast<int>(places.size());
  GridFrame frame = places.front().map.frame();
  frame.columns = columns * std::min(count, kInARow);
  frame.rows = rows * ((count + kInARow - 1) / kInARow);
  Grid<std::int8_t> site(frame, kUnknownCell);
  for (int i = 0; i < count; ++i) {
    Place& place = places[static_cast<std::size_t>(i)];
    const GridFrame& own = place.map.frame();
    const Cell corner{columns * (i % kInARow), rows * (i / kInARow)};
    for (int row = 0; row < own.rows; ++row) {
      for (int column = 0; column < own.columns; ++column)
        site[{corner.column + column, corner.row + row}] = place.map[{column, row}];
    }
    place.on_map =
        frame.origin - own.origin + frame.resolution * Eigen::Vector2d(corner.column, corner.row);
  }
  return site;
}

int measure(const Request& request) {
  Rng rng = Rng(request.seed).fork(78);
  std::vector<Place> places;
  double floor_m2 = 0.0;
  for (int i = 0; i < request.places; ++i) {
    places.push_back(place_of(request, request.seed + static_cast<std::uint64_t>(i), rng));
    floor_m2 += places.back().world.floor_area_m2;
  }
  const Grid<std::int8_t> grid = side_by_side(places);
  const LocalizationMap map(grid);
  nlohmann::json scans = nlohmann::json::array();
  for (int i = 0; i < request.scans; ++i) {
    const Place& place = places[static_cast<std::size_t>(i) % places.size()];
    const Eigen::Vector2d at = random_place(place.bare, place.surfaces, rng);
    const Pose2 there{at.x(), at.y(), rng.uniform(-kPi, kPi)};
    const LaserScan scan = cast_scan(place.surfaces, there, kSensor1081, rng);
    const Pose2 truth{at.x() + place.on_map.x(), at.y() + place.on_map.y(), there.yaw};
    const double start = cpu_ms();
    const Relocalization found = relocalize(map, scan, Pose2{});
    const double took_ms = cpu_ms() - start;
    nlohmann::json said{{"ms", took_ms},
                        {"none", found.none_probability},
                        {"complete", found.complete},
                        {"candidates", found.candidates.size()}};
    bool listed = false;
    nlohmann::json stated = nlohmann::json::array();
    for (const PlaceCandidate& candidate : found.candidates) {
      const bool right = request.map_seed == 0 && error_of(candidate.map_T_robot, truth).right();
      listed = listed || right;
      if (stated.size() < 10) stated.push_back({candidate.probability, right});
    }
    said["listed"] = listed;
    said["stated"] = stated;
    scans.push_back(std::move(said));
  }
  const nlohmann::json result{{"place", request.place},
                              {"seed", request.seed},
                              {"floor_m2", floor_m2},
                              {"columns", grid.frame().columns},
                              {"rows", grid.frame().rows},
                              {"prepare_ms", preparing_ms(grid, request.prepared_times)},
                              {"memory_bytes", map.memory_bytes()},
                              {"scans", scans}};
  fmt::print("{}\n", result.dump());
  return 0;
}

}  // namespace
}  // namespace loopstone::bench

int main(int argc, char** argv) {
  try {
    return loopstone::bench::measure(loopstone::bench::parse(argc, argv));
  } catch (const std::exception& error) {
    fmt::print(stderr, "measure_relocalize: {}\n", error.what());
    return 1;
  }
}
