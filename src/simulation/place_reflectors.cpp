#include "loopstone/simulation/place_reflectors.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "loopstone/base/rng.hpp"
#include "loopstone/simulation/surface_index.hpp"

namespace loopstone {
namespace {

constexpr double kStripM = 0.1;        ///< width of a strip
constexpr double kPostRadiusM = 0.04;  ///< as reflectors of vehicles have it
constexpr double kPostGapM = 0.03;     ///< between a post and its wall
constexpr double kColumnM = 0.1;       ///< thinner columns are table legs
constexpr double kSpacingM = 0.8;      ///< of places on a wall
constexpr double kApartM = 1.0;        ///< of reflectors
constexpr double kReachM = 10.0;       ///< from which two beams of a usual scanner meet a strip
constexpr double kLookEveryM = 1.5;    ///< of the route
constexpr double kLeastCosine = 0.7;   ///< between a strip's normal and whoever sees it
constexpr double kTouchM = 0.01;       ///< a ray that ends so near to a place sees it
constexpr int kWanted = 5;             ///< in view

/// Where a reflector may hang, and which places of the route see it.
struct Spot {
  Reflector reflector{};
  bool is_column = false;
  std::vector<std::size_t> seen_from{};
};

std::vector<Eigen::Vector2d> lookouts(const Drive& drive) {
  std::vector<Eigen::Vector2d> places;
  double next_m = 0.0;
  for (double time_s = 0.0; time_s <= drive.duration_s(); time_s += 0.1) {
    if (drive.travelled_m(time_s) < next_m) continue;
    places.push_back(drive.pose_at(time_s).translation());
    next_m = drive.travelled_m(time_s) + kLookEveryM;
  }
  return places;
}

/// Both sides of every flat surface; the inner side of a solid is seen from nowhere.
std::vector<Spot> spots_of(const FloorPlan& plan, Rng& rng) {
  std::vector<Spot> spots;
  for (const Segment& surface : flat_surfaces(plan)) {
    const Eigen::Vector2d along = surface.to - surface.from;
    const double length = along.norm();
    if (length < 2.0 * kStripM) continue;
    const Eigen::Vector2d unit = along / length;
    const Eigen::Vector2d normal(-unit.y(), unit.x());
    for (double at = kStripM + rng.uniform(0.0, kSpacingM); at <= length - kStripM;
         at += kSpacingM * rng.uniform(0.7, 1.3)) {
      const Eigen::Vector2d centre = surface.from + at * unit;
      for (const double side : {1.0, -1.0}) {
        spots.push_back({{.centre = centre, .normal = side * normal, .width_m = kStripM}});
      }
    }
  }
  for (const Circle& circle : plan.circles) {
    if (circle.radius_m < kColumnM) continue;
    spots.push_back({{.centre = circle.centre, .radius_m = circle.radius_m}, true});
  }
  return spots;
}

bool is_seen(const Reflector& reflector, const Eigen::Vector2d& from, const SurfaceIndex& index) {
  const Eigen::Vector2d way = reflector.centre - from;
  const double distance = way.norm();
  if (distance > kReachM || distance < reflector.radius_m + kTouchM) return false;
  const Eigen::Vector2d direction = way / distance;
  if (reflector.radius_m == 0.0 && -direction.dot(reflector.normal) < kLeastCosine) return false;
  const double met = index.cast(from, direction, kReachM);
  return std::abs(met - (distance - reflector.radius_m)) < kTouchM;
}

void keep_seen_spots(std::vector<Spot>& spots, const std::vector<Eigen::Vector2d>& lookouts,
                     const SurfaceIndex& index) {
  for (Spot& spot : spots) {
    for (std::size_t i = 0; i < lookouts.size(); ++i) {
      if (is_seen(spot.reflector, lookouts[i], index)) spot.seen_from.push_back(i);
    }
  }
  std::erase_if(spots, [](const Spot& spot) { return spot.seen_from.empty(); });
}

/// A place of the route gains less from each further reflector, and little once it has enough.
double gain_of(const Spot& spot, const std::vector<int>& in_view) {
  double gain = 0.0;
  for (const std::size_t place : spot.seen_from) {
    gain += in_view[place] < kWanted ? 1.0 / (1.0 + in_view[place]) : 0.01;
  }
  return gain;
}

/// The strip becomes a round post that stands before its wall.
void make_post(World& world, Reflector& reflector) {
  reflector.centre += (kPostGapM + kPostRadiusM) * reflector.normal;
  reflector.normal.setZero();
  reflector.width_m = 0.0;
  reflector.radius_m = kPostRadiusM;
  world.plan.circles.push_back({reflector.centre, kPostRadiusM});
  world.given_map.reset();  // it shows no post
}

}  // namespace

World with_reflectors(World world, double robot_radius_m, const DriveOptions& drive, int count,
                      std::uint64_t seed) {
  Rng rng = Rng(seed).fork(0x5e7);
  const std::vector<Eigen::Vector2d> places = lookouts(drive_route(world, robot_radius_m, drive));
  std::vector<Spot> spots = spots_of(world.plan, rng);
  keep_seen_spots(spots, places, SurfaceIndex(world.plan));
  std::vector<int> in_view(places.size(), 0);
  while (static_cast<int>(world.reflectors.size()) < count) {
    std::erase_if(spots, [&](const Spot& spot) {
      return std::ranges::any_of(world.reflectors, [&](const Reflector& other) {
        return (other.centre - spot.reflector.centre).norm() < kApartM;
      });
    });
    const auto best = std::ranges::max_element(
        spots, {}, [&](const Spot& spot) { return gain_of(spot, in_view); });
    if (best == spots.end()) break;
    for (const std::size_t place : best->seen_from) ++in_view[place];
    Reflector reflector = best->reflector;
    reflector.id = static_cast<int>(world.reflectors.size()) + 1;
    if (!best->is_column && reflector.id % 4 == 0) make_post(world, reflector);
    world.reflectors.push_back(reflector);
  }
  return world;
}

std::vector<MappedLandmark> landmarks_of(const World& world) {
  std::vector<MappedLandmark> landmarks;
  for (const Reflector& reflector : world.reflectors) {
    landmarks.push_back(
        {.id = reflector.id, .position = reflector.centre, .radius_m = reflector.radius_m});
  }
  return landmarks;
}

}  // namespace loopstone
