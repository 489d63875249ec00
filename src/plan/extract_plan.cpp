#include "loopstone/plan/extract_plan.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "loopstone/base/error.hpp"
#include "loopstone/base/hypotenuse.hpp"
#include "plan/door_faces.hpp"
#include "plan/floor_parts.hpp"
#include "plan/plan_layers.hpp"
#include "plan/plan_numbers.hpp"
#include "plan/room_outline.hpp"
#include "plan/wall_line.hpp"

namespace loopstone {

namespace {

/// The other face of the same doorway, if it was seen; -1 if not.
int opposite_of(const std::vector<DoorFace>& faces, std::size_t i) {
  const DoorFace& face = faces[i];
  int best = -1;
  double least = kPlanRooms.wall_most_m;
  for (std::size_t k = 0; k < faces.size(); ++k) {
    const DoorFace& other = faces[k];
    if (k == i || face.normal().dot(other.normal()) > -0.95) continue;
    const Eigen::Vector2d across = other.middle() - face.middle();
    const double depth = -across.dot(face.normal());
    const double aside = std::abs(across.dot((face.to - face.from).normalized()));
    if (depth < 0.02 || depth > least || aside > 0.3) continue;
    least = depth;
    best = static_cast<int>(k);
  }
  return best;
}

/// Faces that part nothing are gaps beside a pillar, not doors; without them the floor is whole.
FloorParts part_by_doors(const Grid<std::int8_t>& cells, const std::vector<PlanSegment>& segments,
                         std::vector<DoorFace>& faces) {
  FloorParts parts = part_floor(cells, segments, faces);
  for (int round = 0; round < 3; ++round) {
    const std::size_t before = faces.size();
    std::erase_if(faces, [&](const DoorFace& face) {
      const int here = parts.beside(face, 1.0);
      return here != FloorParts::kNone && here == parts.beside(face, -1.0);
    });
    if (faces.size() == before) break;
    parts = part_floor(cells, segments, faces);
  }
  return parts;
}

std::vector<PlanDoor> doors_of(const std::vector<DoorFace>& faces, const FloorParts& parts) {
  std::vector<PlanDoor> doors;
  for (std::size_t i = 0; i < faces.size(); ++i) {
    const DoorFace& face = faces[i];
    const int k = opposite_of(faces, i);
    if (k >= 0 && opposite_of(faces, static_cast<std::size_t>(k)) == static_cast<int>(i)) {
      if (k < static_cast<int>(i)) continue;  // told already
      const DoorFace& other = faces[static_cast<std::size_t>(k)];
      doors.push_back({.from = 0.5 * (face.from + other.to),
                       .to = 0.5 * (face.to + other.from),
                       .width_m = 0.5 * (face.width_m() + other.width_m()),
                       .width_sigma_m = 0.5 * (face.width_sigma_m + other.width_sigma_m),
                       .depth_m = std::abs((other.middle() - face.middle()).dot(face.normal())),
                       .room = parts.beside(face, 1.0),
                       .other_room = parts.beside(other, 1.0)});
    } else {
      doors.push_back({.from = face.from,
                       .to = face.to,
                       .width_m = face.width_m(),
                       .width_sigma_m = face.width_sigma_m,
                       .room = parts.beside(face, 1.0),
                       .other_room = parts.beside(face, -1.0)});
    }
  }
  std::erase_if(doors, [](const PlanDoor& door) {
    return (door.room < 0 && door.other_room < 0) || door.room == door.other_room;
  });
  return doors;
}

/// Rooms by size, doors with their numbers.
void number_rooms(VectorPlan& plan, std::vector<PlanRoom> rooms) {
  std::vector<std::size_t> order(rooms.size());
  std::iota(order.begin(), order.end(), 0U);
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return rooms[a].area_m2 > rooms[b].area_m2;
  });
  std::vector<int> number(rooms.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    number[order[i]] = static_cast<int>(i);
    plan.rooms.push_back(std::move(rooms[order[i]]));
  }
  for (std::size_t i = 0; i < plan.doors.size(); ++i) {
    for (int* room : {&plan.doors[i].room, &plan.doors[i].other_room}) {
      if (*room < 0) continue;
      *room = number[static_cast<std::size_t>(*room)];
      plan.rooms[static_cast<std::size_t>(*room)].doors.push_back(static_cast<int>(i));
    }
  }
}

}  // namespace

std::vector<NumberGroup> plan_numbers() {
  return {number_group("plan_lines", kPlan), number_group("plan_rooms", kPlanRooms)};
}

VectorPlan extract_plan(const Grid<std::int8_t>& cells, const WallSamples& samples) {
  if (samples.samples.empty())
    throw UsageError("there is no wall on this map that is seen from free space");
  VectorPlan plan{.from_scans = samples.from_scans};
  auto [lines, across_m] = grow_lines(samples);
  plan.axes = find_axes(lines);
  square_lines(plan.axes, lines);
  const double resolution_m = cells.frame().resolution;
  JoinedSegments joined =
      join_corners(lines, samples.from_scans ? kPlan.corner_m : kPlan.corner_m + resolution_m,
                   samples.from_scans ? 0.02 : resolution_m);
  joined.plane_m = 0.3 * across_m;
  find_structure(cells, joined);
  add_hidden_walls(cells, joined);
  complete_structure(joined);
  add_hidden_walls(cells, joined);
  std::vector<DoorFace> faces = find_door_faces(cells, joined);
  const FloorParts parts = part_by_doors(cells, joined.segments, faces);
  plan.doors = doors_of(faces, parts);
  std::vector<PlanRoom> rooms;
  for (std::size_t part = 0; part < parts.areas_m2.size(); ++part)
    rooms.push_back(outline_room(parts, static_cast<int>(part), joined.segments, faces));
  number_rooms(plan, std::move(rooms));
  plan.segments = std::move(joined.segments);
  return plan;
}

}  // namespace loopstone
