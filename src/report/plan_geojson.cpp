#include <cmath>
#include <nlohmann/json.hpp>

#include "loopstone/base/words.hpp"
#include "loopstone/geometry/angle.hpp"
#include "loopstone/report/plan_outputs.hpp"

namespace loopstone {

namespace {

using Json = nlohmann::ordered_json;

// WGS 84: half axis and flattening (NIMA TR8350.2, table 3.1).
constexpr double kHalfAxisM = 6378137.0;
constexpr double kFlattening = 1.0 / 298.257223563;
constexpr double kEccentricity2 = kFlattening * (2.0 - kFlattening);

double rounded(double value, double unit) { return std::round(value / unit) * unit; }

Json metres(double value) { return rounded(value, 1e-4); }

Json position(const GeoAnchor& anchor, const Eigen::Vector2d& in_map) {
  const Eigen::Vector2d degrees = longitude_latitude(anchor, in_map);
  return Json::array({rounded(degrees.x(), 1e-9), rounded(degrees.y(), 1e-9)});
}

Json ring(const GeoAnchor& anchor, const Polygon2& polygon) {
  Json positions = Json::array();
  for (const Eigen::Vector2d& corner : polygon.corners)
    positions.push_back(position(anchor, corner));
  if (!positions.empty()) positions.push_back(positions.front());
  return positions;
}

Json feature(const char* type, Json coordinates, Json properties) {
  return {{"type", "Feature"},
          {"geometry", {{"type", type}, {"coordinates", std::move(coordinates)}}},
          {"properties", std::move(properties)}};
}

Json segment_feature(const GeoAnchor& anchor, const PlanSegment& segment) {
  return feature("LineString",
                 Json::array({position(anchor, segment.from), position(anchor, segment.to)}),
                 {{"layer", to_string(segment.layer)},
                  {"length_m", metres(segment.length_m())},
                  {"sigma_across_m", metres(segment.sigma_across_m)},
                  {"sigma_from_m", metres(segment.sigma_from_m)},
                  {"sigma_to_m", metres(segment.sigma_to_m)},
                  {"squared", segment.squared}});
}

/// Rooms are called by their numbers, from 1; null: outside, or not explored.
Json room_name(int room) { return room < 0 ? Json() : Json(room + 1); }

Json door_feature(const GeoAnchor& anchor, const PlanDoor& door) {
  return feature("LineString",
                 Json::array({position(anchor, door.from), position(anchor, door.to)}),
                 {{"layer", door.is_opening() ? "opening" : "door"},
                  {"width_m", metres(door.width_m)},
                  {"width_sigma_m", metres(door.width_sigma_m)},
                  {"depth_m", metres(door.depth_m)},
                  {"rooms", Json::array({room_name(door.room), room_name(door.other_room)})}});
}

/// Of each side of the outer ring, in order, what it runs along.
Json side_words(const PlanOutline& outline) {
  Json words = Json::array();
  for (const PlanSide side : outline.sides) words.push_back(to_string(side));
  return words;
}

Json room_feature(const GeoAnchor& anchor, const PlanRoom& room, int number) {
  Json rings = Json::array({ring(anchor, room.outline.polygon)});
  for (const PlanOutline& hole : room.holes) rings.push_back(ring(anchor, hole.polygon));
  return feature("Polygon", std::move(rings),
                 {{"layer", "room"},
                  {"room", number},
                  {"area_m2", metres(room.area_m2)},
                  {"area_sigma_m2", metres(room.area_sigma_m2)},
                  {"closed", room.is_closed()},
                  {"open_m", metres(room.open_m)},
                  {"hidden_m", metres(room.hidden_m)},
                  {"sides", side_words(room.outline)}});
}

}  // namespace

bool is_on_earth(const GeoAnchor& anchor) {
  return std::abs(anchor.latitude_deg) <= 89.9 && std::abs(anchor.longitude_deg) <= 180.0 &&
         std::abs(anchor.bearing_deg) <= 360.0;
}

Eigen::Vector2d longitude_latitude(const GeoAnchor& anchor, const Eigen::Vector2d& in_map) {
  const double turn = radians(anchor.bearing_deg);  // of x, from north to east
  const double north = std::cos(turn) * in_map.x() + std::sin(turn) * in_map.y();
  const double east = std::sin(turn) * in_map.x() - std::cos(turn) * in_map.y();
  const double latitude = radians(anchor.latitude_deg);
  const double sine = std::sin(latitude);
  const double cosine = std::cos(latitude);
  const double normal = kHalfAxisM / std::sqrt(1.0 - kEccentricity2 * sine * sine);
  // Earth-centred, the meridian of the anchor in the plane of x and z.
  const double x = normal * cosine - sine * north;
  const double z = normal * (1.0 - kEccentricity2) * sine + cosine * north;
  const double distance = std::sqrt(x * x + east * east);
  // Bowring 1976: exact to far below a micrometre near the surface.
  const double minor = kHalfAxisM * (1.0 - kFlattening);
  const double reduced = std::atan2(z * kHalfAxisM, distance * minor);
  const double second = kEccentricity2 / (1.0 - kEccentricity2);
  const double found =
      std::atan2(z + second * minor * std::pow(std::sin(reduced), 3),
                 distance - kEccentricity2 * kHalfAxisM * std::pow(std::cos(reduced), 3));
  const double longitude = radians(anchor.longitude_deg) + std::atan2(east, x);
  return {degrees(wrap_angle(longitude)), degrees(found)};
}

std::string format_plan_geojson(const VectorPlan& plan, const GeoAnchor& anchor) {
  Json features = Json::array();
  for (std::size_t i = 0; i < plan.rooms.size(); ++i)
    features.push_back(room_feature(anchor, plan.rooms[i], static_cast<int>(i) + 1));
  for (const PlanSegment& segment : plan.segments)
    features.push_back(segment_feature(anchor, segment));
  for (const PlanDoor& door : plan.doors) features.push_back(door_feature(anchor, door));
  std::string text = "{\"type\":\"FeatureCollection\",\"features\":[";
  for (std::size_t i = 0; i < features.size(); ++i)
    text += (i == 0 ? "\n" : ",\n") + features[i].dump();
  return text + "\n]}\n";
}

}  // namespace loopstone
