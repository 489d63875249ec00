#include "plan/room_outline.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "loopstone/base/hypotenuse.hpp"
#include "plan/plan_numbers.hpp"

namespace loopstone {

namespace {

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

double signed_area(const std::vector<Eigen::Vector2d>& corners) {
  double sum = 0.0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Eigen::Vector2d& origin = corners.front();
    sum += cross(corners[i] - origin, corners[(i + 1) % corners.size()] - origin);
  }
  return 0.5 * sum;
}

/// What an outline may run along.
struct Bound {
  Eigen::Vector2d from;
  Eigen::Vector2d to;
  double sigma_across_m = 0.0;
  double sigma_yaw_rad = 0.0;
  PlanSide side = PlanSide::kWall;

  [[nodiscard]] Eigen::Vector2d along() const { return (to - from).normalized(); }
  [[nodiscard]] Eigen::Vector2d normal() const {
    const Eigen::Vector2d u = along();
    return {-u.y(), u.x()};
  }
  [[nodiscard]] Eigen::Vector2d foot(const Eigen::Vector2d& point) const {
    const Eigen::Vector2d u = along();
    return from + (point - from).dot(u) * u;
  }
};

/// A side of a cell on the border of a part; the part is on its left.
struct Side {
  Eigen::Vector2d middle;
  Eigen::Vector2d end;  ///< where the next one begins
  Eigen::Vector2d inward;
};

/// The borders of a part, each closed: counter-clockwise around it, clockwise around its holes.
std::vector<std::vector<Side>> borders_of(const FloorParts& parts, int part) {
  const GridFrame& frame = parts.part_of.frame();
  const auto inside = [&](int column, int row) {
    return parts.part_of.value_or({column, row}, FloorParts::kNone) == part;
  };
  // Corners of cells, by number; from each, where sides of the border lead.
  using Corner = std::pair<int, int>;  // row, column
  std::multimap<Corner, Corner> leads;
  for (int row = 0; row < frame.rows; ++row) {
    for (int column = 0; column < frame.columns; ++column) {
      if (!inside(column, row)) continue;
      if (!inside(column, row - 1)) leads.insert({{row, column}, {row, column + 1}});
      if (!inside(column + 1, row)) leads.insert({{row, column + 1}, {row + 1, column + 1}});
      if (!inside(column, row + 1)) leads.insert({{row + 1, column + 1}, {row + 1, column}});
      if (!inside(column - 1, row)) leads.insert({{row + 1, column}, {row, column}});
    }
  }
  const auto place = [&](const Corner& corner) {
    return Eigen::Vector2d(frame.origin.x() + corner.second * frame.resolution,
                           frame.origin.y() + corner.first * frame.resolution);
  };
  std::vector<std::vector<Side>> borders;
  while (!leads.empty()) {
    std::vector<Side> border;
    const Corner start = leads.begin()->first;
    Corner at = start;
    Eigen::Vector2d came(0.0, 0.0);
    do {
      const auto [first, last] = leads.equal_range(at);
      auto next =
          first;  // where cells touch by a corner: to the right, so that no ring touches itself
      for (auto it = first; it != last; ++it)
        if (cross(came, place(it->second) - place(at)) < 0.0) next = it;
      const Eigen::Vector2d a = place(at);
      const Eigen::Vector2d b = place(next->second);
      came = b - a;
      border.push_back({.middle = 0.5 * (a + b),
                        .end = b,
                        .inward = Eigen::Vector2d(-came.y(), came.x()).normalized()});
      at = next->second;
      leads.erase(next);
    } while (at != start);
    borders.push_back(std::move(border));
  }
  return borders;
}

/// A stretch of border along one bound, or along none.
struct Run {
  int bound = -1;
  std::vector<Eigen::Vector2d> ends{};  ///< of its sides
};

struct Segment2 {
  Eigen::Vector2d from;
  Eigen::Vector2d to;
};

double distance_to(const Segment2& segment, const Eigen::Vector2d& point) {
  const Eigen::Vector2d side = segment.to - segment.from;
  const double length2 = side.squaredNorm();
  const double t =
      length2 > 0.0 ? std::clamp((point - segment.from).dot(side) / length2, 0.0, 1.0) : 0.0;
  return (point - segment.from - t * side).norm();
}

/// A corner of an outline, and what it goes on along.
struct Turn {
  Eigen::Vector2d at;
  int along = -1;  ///< place among the bounds; -1: nothing
  bool drawn_through = false;
};

class OutlineFitter {
 public:
  OutlineFitter(std::span<const Bound> bounds, double resolution_m)
      : bounds_(bounds), resolution_m_(resolution_m) {}

  struct Fitted {
    PlanOutline outline{};
    double variance_m4 = 0.0;  ///< of its area
    double open_m = 0.0;
    double hidden_m = 0.0;
    double length_m = 0.0;
  };

  /// Where lines would cross one another: along the cells alone.
  [[nodiscard]] Fitted along_cells(const std::vector<Side>& border, double tolerance_m) const {
    std::vector<Eigen::Vector2d> points;
    for (const Side& side : border) points.push_back(side.end);
    std::vector<Eigen::Vector2d> simple;
    simplify(points, 0, points.size() / 2, tolerance_m, simple);
    simplify(points, points.size() / 2, points.size() - 1, tolerance_m, simple);
    simple.push_back(points.back());
    std::vector<Turn> turns;
    for (const Eigen::Vector2d& point : simple) turns.push_back({point, -1});
    return judged(turns);
  }

  [[nodiscard]] Fitted fit(const std::vector<Side>& border) const {
    const std::vector<Run> runs = runs_of(border);
    std::vector<Turn> turns;
    for (std::size_t i = 0; i < runs.size(); ++i) {
      if (runs[i].bound < 0) add_open(runs, i, turns);
      if (runs.size() > 1) add_joint(runs[i], runs[(i + 1) % runs.size()], turns);
    }
    return judged(cleaned(std::move(turns)));
  }

 private:
  [[nodiscard]] const Bound& bound(int i) const { return bounds_[static_cast<std::size_t>(i)]; }

  [[nodiscard]] double distance_of(const Bound& b, const Side& side) const {
    constexpr double kFar = std::numeric_limits<double>::infinity();
    if (b.normal().dot(side.inward) < -0.3) return kFar;
    const Eigen::Vector2d u = b.along();
    const double t = (side.middle - b.from).dot(u);
    const double beyond = std::max({0.0, -t, t - (b.to - b.from).norm()});
    if (beyond > resolution_m_) return kFar;
    const double across = (side.middle - b.from).dot(b.normal());
    // Sides that face another way belong to what they face, if that is near, too.
    return std::abs(across) + beyond + 0.5 * resolution_m_ * (1.0 - b.normal().dot(side.inward));
  }

  [[nodiscard]] int nearest(const Side& side) const {
    int best = -1;
    double least = kPlanRooms.outline_m;
    for (std::size_t i = 0; i < bounds_.size(); ++i) {
      const Bound& b = bounds_[i];
      const double reach = kPlanRooms.outline_m + resolution_m_;
      if (side.middle.x() < std::min(b.from.x(), b.to.x()) - reach ||
          side.middle.x() > std::max(b.from.x(), b.to.x()) + reach ||
          side.middle.y() < std::min(b.from.y(), b.to.y()) - reach ||
          side.middle.y() > std::max(b.from.y(), b.to.y()) + reach) {
        continue;
      }
      const double distance = distance_of(b, side);
      if (distance >= least) continue;
      least = distance;
      best = static_cast<int>(i);
    }
    return best;
  }

  static void join_alike(std::vector<Run>& runs) {
    std::vector<Run> joined;
    for (Run& run : runs) {
      if (!joined.empty() && joined.back().bound == run.bound) {
        joined.back().ends.insert(joined.back().ends.end(), run.ends.begin(), run.ends.end());
      } else {
        joined.push_back(std::move(run));
      }
    }
    if (joined.size() > 1 && joined.front().bound == joined.back().bound) {
      Run& last = joined.back();
      last.ends.insert(last.ends.end(), joined.front().ends.begin(), joined.front().ends.end());
      joined.front() = std::move(last);
      joined.pop_back();
    }
    runs = std::move(joined);
  }

  [[nodiscard]] std::vector<Run> runs_of(const std::vector<Side>& border) const {
    std::vector<Run> runs;
    for (const Side& side : border) runs.push_back({nearest(side), {side.end}});
    join_alike(runs);
    // Short pieces along nothing are corners that cells cut off; single sides are noise.
    const auto open_sides = static_cast<std::size_t>(std::ceil(0.35 / resolution_m_));
    for (const std::size_t least : {std::size_t{2}, open_sides}) {
      if (runs.size() < 3) break;
      std::erase_if(runs, [&](const Run& run) {
        return run.ends.size() < (run.bound < 0 ? least : std::size_t{2});
      });
      join_alike(runs);
    }
    return runs;
  }

  /// Douglas and Peucker 1973.
  void simplify(const std::vector<Eigen::Vector2d>& points, std::size_t first, std::size_t last,
                double tolerance_m, std::vector<Eigen::Vector2d>& out) const {
    double most = 0.0;
    std::size_t at = first;
    const Eigen::Vector2d base = points[last] - points[first];
    for (std::size_t i = first + 1; i < last; ++i) {
      const Eigen::Vector2d offset = points[i] - points[first];
      const double off =
          base.norm() > 1e-9 ? std::abs(cross(base, offset)) / base.norm() : offset.norm();
      if (off <= most) continue;
      most = off;
      at = i;
    }
    if (most > tolerance_m) {
      simplify(points, first, at, tolerance_m, out);
      simplify(points, at, last, tolerance_m, out);
    } else {
      out.push_back(points[first]);
    }
  }

  /// Where the lines before and after a stretch along nothing meet, if it is a short one that does
  /// not lead far from them: something stands there before a wall, or in a corner.
  [[nodiscard]] std::optional<std::vector<Turn>> drawn_through(const Run& before, const Run& run,
                                                               const Run& after) const {
    if (before.bound < 0 || after.bound < 0) return std::nullopt;
    const Bound& a = bound(before.bound);
    const Bound& b = bound(after.bound);
    const Eigen::Vector2d start = a.foot(before.ends.back());
    const Eigen::Vector2d end = b.foot(run.ends.back());
    const double sine = cross(a.along(), b.along());
    std::vector<Eigen::Vector2d> line{start};
    if (std::abs(sine) > 0.5)
      line.emplace_back(a.from + cross(b.from - a.from, b.along()) / sine * a.along());
    else if (std::abs((end - start).dot(a.normal())) > 0.06)
      return std::nullopt;
    line.push_back(end);
    double length = 0.0;
    for (std::size_t i = 1; i < line.size(); ++i) {
      if (before.bound == after.bound && line.size() > 2) return std::nullopt;
      length += (line[i] - line[i - 1]).norm();
    }
    if (length > kPlanRooms.hidden_most_m) return std::nullopt;
    const auto is_far = [&](const Eigen::Vector2d& point) {
      double least = std::numeric_limits<double>::infinity();
      for (std::size_t i = 1; i < line.size(); ++i)
        least = std::min(least, distance_to(Segment2{line[i - 1], line[i]}, point));
      return least > kPlanRooms.thing_deep_m;
    };
    if (std::any_of(run.ends.begin(), run.ends.end(), is_far)) return std::nullopt;
    std::vector<Turn> turns{{start, before.bound, true}};
    if (line.size() > 2) turns.push_back({line[1], after.bound, true});
    return turns;
  }

  void add_open(const std::vector<Run>& runs, std::size_t i, std::vector<Turn>& turns) const {
    const Run& run = runs[i];
    const Run& before = runs[(i + runs.size() - 1) % runs.size()];
    if (const auto through = drawn_through(before, run, runs[(i + 1) % runs.size()])) {
      // The foot on the line before is there already, as the beginning of the open stretch.
      if (!turns.empty() && turns.back().along < 0) turns.pop_back();
      turns.insert(turns.end(), through->begin(), through->end());
      return;
    }
    if (run.ends.size() < 2) return;
    std::vector<Eigen::Vector2d> simple;
    simplify(run.ends, 0, run.ends.size() - 1, 1.3 * resolution_m_, simple);
    simple.push_back(run.ends.back());
    for (const Eigen::Vector2d& point : simple) turns.push_back({point, -1});
  }

  /// The corner between two runs, or a step from one to the other.
  void add_joint(const Run& run, const Run& next, std::vector<Turn>& turns) const {
    const Eigen::Vector2d at = run.ends.back();
    if (run.bound >= 0 && next.bound >= 0) {
      const Bound& a = bound(run.bound);
      const Bound& b = bound(next.bound);
      const double sine = cross(a.along(), b.along());
      if (std::abs(sine) > 0.2) {
        const Eigen::Vector2d corner =
            a.from + cross(b.from - a.from, b.along()) / sine * a.along();
        if ((corner - at).norm() <= 0.4) {
          turns.push_back({corner, next.bound});
          return;
        }
      }
    }
    const bool is_step = run.bound >= 0 && next.bound >= 0;
    if (run.bound >= 0) {
      const Eigen::Vector2d foot = bound(run.bound).foot(at);
      const bool is_small =
          is_step && (foot - bound(next.bound).foot(at)).norm() <= 2.0 * kPlanRooms.outline_m;
      turns.push_back({foot, is_small ? run.bound : -1});
    }
    if (next.bound >= 0) turns.push_back({bound(next.bound).foot(at), next.bound});
  }

  [[nodiscard]] PlanSide side_of(const Turn& turn) const {
    if (turn.along < 0) return PlanSide::kOpen;
    return turn.drawn_through ? PlanSide::kHidden : bound(turn.along).side;
  }

  /// Without corners that lie on each other, or in a line between sides of one kind.
  [[nodiscard]] std::vector<Turn> cleaned(std::vector<Turn> turns) const {
    constexpr double kSameM = 0.005;
    for (std::size_t i = 0; i < turns.size() && turns.size() > 3;) {
      const Turn& before = turns[(i + turns.size() - 1) % turns.size()];
      const Turn& next = turns[(i + 1) % turns.size()];
      const Eigen::Vector2d chord = next.at - before.at;
      const double off = chord.norm() > kSameM
                             ? std::abs(cross(chord, turns[i].at - before.at)) / chord.norm()
                             : 1.0;
      const bool lies_between = (turns[i].at - before.at).dot(next.at - turns[i].at) >= 0.0;
      const bool is_needless = off < kSameM && lies_between && side_of(before) == side_of(turns[i]);
      const Eigen::Vector2d come = turns[i].at - before.at;
      const Eigen::Vector2d go = next.at - turns[i].at;
      const bool is_spike =
          come.dot(go) < 0.0 && std::abs(cross(come, go)) < 0.1 * come.norm() * go.norm();
      if (go.norm() < kSameM || is_needless || is_spike)
        turns.erase(turns.begin() + static_cast<std::ptrdiff_t>(i));
      else
        ++i;
    }
    return turns;
  }

  [[nodiscard]] Fitted judged(const std::vector<Turn>& turns) const {
    Fitted fitted;
    for (std::size_t i = 0; i < turns.size(); ++i) {
      const double length = (turns[(i + 1) % turns.size()].at - turns[i].at).norm();
      const int along = turns[i].along;
      const PlanSide side = side_of(turns[i]);
      double sigma = resolution_m_;
      if (along >= 0)
        sigma = hypotenuse(bound(along).sigma_across_m,
                           length * bound(along).sigma_yaw_rad / std::sqrt(12.0));
      fitted.variance_m4 += length * length * sigma * sigma;
      fitted.length_m += length;
      if (side == PlanSide::kOpen) fitted.open_m += length;
      if (side == PlanSide::kHidden) fitted.hidden_m += length;
      fitted.outline.polygon.corners.push_back(turns[i].at);
      fitted.outline.sides.push_back(side);
    }
    return fitted;
  }

  std::span<const Bound> bounds_;
  double resolution_m_;
};

std::vector<Bound> bounds_of(std::span<const PlanSegment> segments,
                             std::span<const DoorFace> faces) {
  std::vector<Bound> bounds;
  for (const PlanSegment& segment : segments) {
    if (segment.layer == PlanLayer::kMovable) continue;
    bounds.push_back({segment.from, segment.to, segment.sigma_across_m, segment.sigma_yaw_rad,
                      segment.layer == PlanLayer::kHidden ? PlanSide::kHidden : PlanSide::kWall});
  }
  for (const DoorFace& face : faces)
    bounds.push_back({face.from, face.to, face.sigma_across_m, 0.0, PlanSide::kDoor});
  return bounds;
}

}  // namespace

PlanRoom outline_room(const FloorParts& parts, int part, std::span<const PlanSegment> segments,
                      std::span<const DoorFace> faces) {
  const std::vector<Bound> bounds = bounds_of(segments, faces);
  const double resolution_m = parts.part_of.frame().resolution;
  const OutlineFitter fitter(bounds, resolution_m);
  PlanRoom room;
  double variance_m4 = 0.0;
  for (const std::vector<Side>& border : borders_of(parts, part)) {
    std::vector<Eigen::Vector2d> cells;
    for (const Side& side : border) cells.push_back(side.end);
    const double cell_area = signed_area(cells);
    const bool is_hole = cell_area < 0.0;
    if (is_hole && -cell_area < 0.25) continue;
    const auto is_faulty = [&](const PlanOutline& outline) {
      // To look for sides that cross takes the square of the corners.
      constexpr std::size_t kMost = 4000;
      return signed_area(outline.polygon.corners) * cell_area <= 0.0 ||
             outline.polygon.corners.size() > kMost || fault_of(outline.polygon);
    };
    auto fitted = fitter.fit(border);
    if (is_faulty(fitted.outline)) fitted = fitter.along_cells(border, 1.3 * resolution_m);
    if (is_faulty(fitted.outline)) fitted = fitter.along_cells(border, 0.01 * resolution_m);
    room.area_m2 += signed_area(fitted.outline.polygon.corners);
    room.open_m += fitted.open_m;
    room.hidden_m += fitted.hidden_m;
    room.perimeter_m += fitted.length_m;
    variance_m4 += fitted.variance_m4;
    if (is_hole)
      room.holes.push_back(std::move(fitted.outline));
    else
      room.outline = std::move(fitted.outline);
  }
  room.area_sigma_m2 = std::sqrt(variance_m4);
  return room;
}

}  // namespace loopstone
