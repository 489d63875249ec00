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
    const std::size_t count = joined_.segments.size();
    for (std::size_t a = 0; a < count; ++a) {
      for (std::size_t b = 0; b < count; ++b)
        if (a != b) between_ends(a, b);
    }
    for (std::size_t a = 0; a < count; ++a) {
      from_end(a, true);
      from_end(a, false);
    }
    return std::move(faces_);
  }

 private:
  [[nodiscard]] const PlanSegment& segment(std::size_t i) const { return joined_.segments[i]; }
  [[nodiscard]] bool is_wall(std::size_t i) const {
    return segment(i).layer == PlanLayer::kStructure;
  }
  /// Nothing goes on from there into the room.
  static bool juts_out(const EndJoint& joint) { return joint.segment < 0 || joint.convex; }
  /// Of something as thin as a wall, as far as was seen.
  [[nodiscard]] bool is_thin(const EndJoint& joint) const {
    return juts_out(joint) &&
           (joint.segment < 0 ||
            segment(static_cast<std::size_t>(joint.segment)).length_m() <= kPlan.wall_most_m);
  }
  /// One can go through.
  [[nodiscard]] bool is_passable(const Eigen::Vector2d& from, const Eigen::Vector2d& to) const {
    const double length_m = (to - from).norm();
    if (length_m < kPlan.door_least_m || length_m > kPlan.door_most_m) return false;
    const Eigen::Vector2d inset = 1.6 * cells_.frame().resolution / length_m * (to - from);
    return free_share(cells_, from + inset, to - inset) >= 0.75;
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
    add(ends.to, begins.from, hypotenuse(ends.sigma_across_m, begins.sigma_across_m),
        hypotenuse(ends.sigma_to_m, begins.sigma_from_m));
  }

  /// The wall's other side of the gap is one that it runs against.
  void from_end(std::size_t a, bool at_to) {
    if (!is_wall(a) || !is_thin(at_to ? joined_.at_to[a] : joined_.at_from[a])) return;
    const PlanSegment& wall = segment(a);
    const Eigen::Vector2d start = at_to ? wall.to : wall.from;
    const Eigen::Vector2d u = at_to ? wall.direction() : Eigen::Vector2d(-wall.direction());
    double nearest_m = kPlan.door_most_m + 1.0;
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
    if (at_to)
      add(start, hit, wall.sigma_across_m, sigma);
    else
      add(hit, start, wall.sigma_across_m, sigma);
  }

  void add(const Eigen::Vector2d& from, const Eigen::Vector2d& to, double sigma_across_m,
           double width_sigma_m) {
    if (!is_passable(from, to)) return;
    const DoorFace face{from, to, sigma_across_m, width_sigma_m};
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
