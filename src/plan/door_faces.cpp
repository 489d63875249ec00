#include "plan/door_faces.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "loopstone/base/hypotenuse.hpp"
#include "loopstone/geometry/angle.hpp"
#include "plan/plan_cells.hpp"

namespace loopstone {

namespace {

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

class FaceFinder {
 public:
  FaceFinder(const Grid<std::int8_t>& cells, const JoinedSegments& joined)
      : cells_(cells), joined_(joined) {}

  std::vector<DoorFace> find() {
    find_all();
    choose();
    return std::move(faces_);
  }

 private:
  void find_all() {
    const std::size_t count = joined_.segments.size();
    for (std::size_t a = 0; a < count; ++a) {
      for (std::size_t b = 0; b < count; ++b)
        if (a != b) between_ends(a, b);
    }
    for (std::size_t a = 0; a < count; ++a) {
      from_end(a, true);
      from_end(a, false);
    }
  }

  [[nodiscard]] const PlanSegment& segment(std::size_t i) const { return joined_.segments[i]; }
  [[nodiscard]] bool is_wall(std::size_t i) const {
    return segment(i).layer != PlanLayer::kMovable;
  }
  /// Nothing goes on from there into the room.
  static bool juts_out(const EndJoint& joint) { return joint.segment < 0 || joint.convex; }
  /// Of something as thin as a wall, as far as was seen.
  [[nodiscard]] bool is_thin(const EndJoint& joint) const {
    return juts_out(joint) &&
           (joint.segment < 0 ||
            segment(static_cast<std::size_t>(joint.segment)).length_m() <= kPlanRooms.wall_most_m);
  }
  /// One can go through.
  [[nodiscard]] bool is_passable(const Eigen::Vector2d& from, const Eigen::Vector2d& to,
                                 double most_m) const {
    const double length_m = (to - from).norm();
    if (length_m < kPlanRooms.door_least_m || length_m > most_m) return false;
    const Eigen::Vector2d inset = 1.6 * cells_.frame().resolution / length_m * (to - from);
    const double needed = length_m > PlanDoor::kWidestDoorM ? 0.9 : 0.75;
    return free_share(cells_, from + inset, to - inset) >= needed;
  }

  void between_ends(std::size_t a, std::size_t b) {
    const PlanSegment& ends = segment(a);
    const PlanSegment& begins = segment(b);
    if (!is_wall(a) || !is_wall(b)) return;
    const EndJoint& at_a = joined_.at_to[a];
    const EndJoint& at_b = joined_.at_from[b];
    if (!juts_out(at_a) || !juts_out(at_b) || (!is_thin(at_a) && !is_thin(at_b))) return;
    const Eigen::Vector2d u = ends.direction();
    if (u.dot(begins.direction()) < 0.99) return;
    const Eigen::Vector2d gap = begins.from - ends.to;
    if (gap.dot(u) <= 0.0 || std::abs(gap.dot(ends.normal())) > 0.06) return;
    const bool both_thin = is_thin(at_a) && is_thin(at_b);
    add({ends.to, begins.from, hypotenuse(ends.sigma_across_m, begins.sigma_across_m),
         hypotenuse(ends.sigma_to_m, begins.sigma_from_m)},
        both_thin ? kPlanRooms.opening_most_m : PlanDoor::kWidestDoorM);
  }

  /// The wall's other side of the gap is one that it runs against.
  void from_end(std::size_t a, bool at_to) {
    if (!is_wall(a) || !is_thin(at_to ? joined_.at_to[a] : joined_.at_from[a])) return;
    const PlanSegment& wall = segment(a);
    const Eigen::Vector2d start = at_to ? wall.to : wall.from;
    const Eigen::Vector2d u = at_to ? wall.direction() : Eigen::Vector2d(-wall.direction());
    double nearest_m = PlanDoor::kWidestDoorM + 1.0;
    const PlanSegment* against = nullptr;
    for (const PlanSegment& other : joined_.segments) {
      if (&other == &wall || other.layer == PlanLayer::kMovable) continue;
      const Eigen::Vector2d v = other.direction();
      const double sine = cross(u, v);
      if (std::abs(sine) < 0.85) continue;
      const double t = cross(other.from - start, v) / sine;
      const double along = cross(other.from - start, u) / sine;
      if (t <= 0.03 || t >= nearest_m || along < -0.05 || along > other.length_m() + 0.05) continue;
      nearest_m = t;
      against = &other;
    }
    if (against == nullptr || against->normal().dot(u) > -0.85) return;
    // A jamb of a gap that has two ends is no wall to run against: it is taken by its ends.
    const Eigen::Vector2d hit = start + nearest_m * u;
    const double sigma =
        hypotenuse(at_to ? wall.sigma_to_m : wall.sigma_from_m, against->sigma_across_m);
    add({at_to ? start : hit, at_to ? hit : start, wall.sigma_across_m, sigma},
        PlanDoor::kWidestDoorM);
  }

  /// Of gaps that lie in each other the narrow one is the door.
  void choose() {
    std::stable_sort(faces_.begin(), faces_.end(), [](const DoorFace& a, const DoorFace& b) {
      return a.width_m() < b.width_m();
    });
    std::vector<DoorFace> kept;
    for (const DoorFace& face : faces_) {
      const auto lies_in = [&](const DoorFace& other) {
        const Eigen::Vector2d u = (face.to - face.from).normalized();
        const Eigen::Vector2d off = other.middle() - face.middle();
        return std::abs(off.dot(face.normal())) < 0.08 &&
               std::abs(off.dot(u)) < 0.5 * (face.width_m() + other.width_m()) - 0.1 &&
               other.normal().dot(face.normal()) > 0.9;
      };
      if (std::none_of(kept.begin(), kept.end(), lies_in)) kept.push_back(face);
    }
    faces_ = std::move(kept);
  }

  /// Whether a piece of the same face stands in the gap.
  [[nodiscard]] bool is_interrupted(const DoorFace& face) const {
    const Eigen::Vector2d u = (face.to - face.from).normalized();
    return std::any_of(
        joined_.segments.begin(), joined_.segments.end(), [&](const PlanSegment& segment) {
          if (segment.layer == PlanLayer::kMovable) return false;
          const Eigen::Vector2d off = segment.middle() - face.from;
          const double along = off.dot(u);
          return std::abs(off.dot(face.normal())) < 0.08 && along > 0.0 && along < face.width_m() &&
                 std::abs(segment.direction().dot(u)) > 0.9;
        });
  }

  void add(const DoorFace& face, double most_m) {
    if (!is_passable(face.from, face.to, most_m) || is_interrupted(face)) return;
    for (const DoorFace& other : faces_) {
      if ((other.middle() - face.middle()).norm() < 0.12 &&
          other.normal().dot(face.normal()) > 0.9) {
        return;
      }
    }
    faces_.push_back(face);
  }

  const Grid<std::int8_t>& cells_;
  const JoinedSegments& joined_;
  std::vector<DoorFace> faces_{};
};

}  // namespace

std::vector<DoorFace> find_door_faces(const Grid<std::int8_t>& cells,
                                      const JoinedSegments& joined) {
  return FaceFinder(cells, joined).find();
}

}  // namespace loopstone
