#include <algorithm>
#include <cmath>
#include <optional>

#include "loopstone/base/hypotenuse.hpp"
#include "loopstone/geometry/angle.hpp"
#include "plan/plan_cells.hpp"
#include "plan/plan_layers.hpp"

namespace loopstone {

namespace {

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

/// Where wall that was seen ends, or begins, and the way it would go on or come from.
struct OpenEnd {
  Eigen::Vector2d at{0.0, 0.0};
  Eigen::Vector2d way{1.0, 0.0};  ///< unit, with free space on its left
  int segment = -1;
  double sigma_across_m = 0.0;
  double sigma_yaw_rad = 0.0;
  bool turns = false;  ///< round a corner that juts out, at the far end of a jamb
};

/// A piece of wall nobody saw that would join an end to a beginning.
struct Bridge {
  double length_m = 0.0;
  std::size_t ends = 0;
  std::size_t begins = 0;
  Eigen::Vector2d corner{0.0, 0.0};
  bool has_corner = false;
};

class HiddenWalls {
 public:
  HiddenWalls(const Grid<std::int8_t>& cells, JoinedSegments& joined)
      : cells_(cells), joined_(joined) {
    for (std::size_t i = 0; i < joined.segments.size(); ++i) add_ends(i);
  }

  void add() {
    std::vector<Bridge> bridges;
    for (std::size_t a = 0; a < ends_.size(); ++a) {
      for (std::size_t b = 0; b < begins_.size(); ++b) {
        if (ends_[a].segment == begins_[b].segment) continue;
        if (const auto bridge = bridge_between(a, b)) bridges.push_back(*bridge);
      }
    }
    std::stable_sort(bridges.begin(), bridges.end(),
                     [](const Bridge& x, const Bridge& y) { return x.length_m < y.length_m; });
    std::vector<bool> ends_used(ends_.size(), false);
    std::vector<bool> begins_used(begins_.size(), false);
    for (const Bridge& bridge : bridges) {
      if (ends_used[bridge.ends] || begins_used[bridge.begins]) continue;
      ends_used[bridge.ends] = begins_used[bridge.begins] = true;
      const std::size_t before = joined_.segments.size();
      build(bridge);
      const std::size_t after = joined_.segments.size();
      if (after == before) continue;
      // What lies at them now is the first and the last of what was added.
      const OpenEnd& end = ends_[bridge.ends];
      const OpenEnd& begin = begins_[bridge.begins];
      joined_.at_to[static_cast<std::size_t>(end.segment)] = {static_cast<int>(before), end.turns};
      joined_.at_from[static_cast<std::size_t>(begin.segment)] = {static_cast<int>(after) - 1,
                                                                  begin.turns};
    }
  }

 private:
  [[nodiscard]] const PlanSegment& segment(std::size_t i) const { return joined_.segments[i]; }

  /// No other wall begins at this end.
  [[nodiscard]] bool is_open(const EndJoint& joint) const {
    return joint.segment < 0 ||
           segment(static_cast<std::size_t>(joint.segment)).layer == PlanLayer::kMovable;
  }

  void add_ends(std::size_t i) {
    const PlanSegment& wall = segment(i);
    if (wall.layer != PlanLayer::kStructure) return;
    const Eigen::Vector2d u = wall.direction();
    const EndJoint& from = joined_.at_from[i];
    const EndJoint& to = joined_.at_to[i];
    const int number = static_cast<int>(i);
    if (is_open(to)) ends_.push_back({wall.to, u, number, wall.sigma_across_m, wall.sigma_yaw_rad});
    if (is_open(from))
      begins_.push_back({wall.from, u, number, wall.sigma_across_m, wall.sigma_yaw_rad});
    // A jamb whose far corner was not seen: from there the wall's other face goes back along the
    // one that was seen.
    if (wall.length_m() > kPlanRooms.jamb_m || wall.length_m() < 0.05) return;
    const auto back_along = [&](const EndJoint& joint) -> Eigen::Vector2d {
      return -segment(static_cast<std::size_t>(joint.segment)).direction();
    };
    constexpr double kSigmaRad = 0.005;
    if (to.segment < 0 && from.segment >= 0 && from.convex)
      ends_.push_back({wall.to, back_along(from), number, wall.sigma_to_m, kSigmaRad, true});
    if (from.segment < 0 && to.segment >= 0 && to.convex)
      begins_.push_back({wall.from, back_along(to), number, wall.sigma_from_m, kSigmaRad, true});
  }

  /// What is guessed must not be long, nor longer than what was seen.
  [[nodiscard]] double most_m(const OpenEnd& a, const OpenEnd& b) const {
    return std::max(2.5, segment(static_cast<std::size_t>(a.segment)).length_m() +
                             segment(static_cast<std::size_t>(b.segment)).length_m());
  }

  [[nodiscard]] std::optional<Bridge> bridge_between(std::size_t a, std::size_t b) const {
    const OpenEnd& end = ends_[a];
    const OpenEnd& begin = begins_[b];
    const Eigen::Vector2d gap = begin.at - end.at;
    if (gap.norm() > 1.5 * kPlanRooms.hidden_most_m) return std::nullopt;
    const double sine = cross(end.way, begin.way);
    Bridge bridge{.ends = a, .begins = b};
    if (std::abs(sine) < std::sin(radians(5.0)) && end.way.dot(begin.way) > 0.0) {
      if (std::abs(cross(end.way, gap)) > 0.05) return std::nullopt;
      bridge.length_m = gap.dot(end.way);
      if (bridge.length_m <= 0.0 || bridge.length_m > most_m(end, begin) ||
          !is_hidden(end.at, begin.at)) {
        return std::nullopt;
      }
      return bridge;
    }
    if (sine < std::sin(radians(30.0))) return std::nullopt;  // a room's corner turns left
    bridge.corner = end.at + cross(gap, begin.way) / sine * end.way;
    bridge.has_corner = true;
    const double ahead = (bridge.corner - end.at).dot(end.way);
    const double behind = (begin.at - bridge.corner).dot(begin.way);
    if (ahead < -0.1 || behind < -0.1) return std::nullopt;
    bridge.length_m = std::max(0.0, ahead) + std::max(0.0, behind);
    if (bridge.length_m > most_m(end, begin) || !is_hidden(end.at, bridge.corner) ||
        !is_hidden(bridge.corner, begin.at)) {
      return std::nullopt;
    }
    return bridge;
  }

  /// Whether wall was seen on a good part of a stretch: then it is no gap.
  [[nodiscard]] bool is_seen(const Eigen::Vector2d& from, const Eigen::Vector2d& u,
                             double length_m) const {
    const Eigen::Vector2d normal(-u.y(), u.x());
    return std::any_of(joined_.segments.begin(), joined_.segments.end(),
                       [&](const PlanSegment& wall) {
                         if (wall.layer == PlanLayer::kMovable || wall.direction().dot(u) < 0.99)
                           return false;
                         if (std::abs((wall.middle() - from).dot(normal)) > 0.05) return false;
                         const double low = std::max(0.0, (wall.from - from).dot(u));
                         const double high = std::min(length_m, (wall.to - from).dot(u));
                         return high - low > 0.12;
                       });
  }

  /// Whether a wall stands across.
  [[nodiscard]] bool is_crossed(const Eigen::Vector2d& from, const Eigen::Vector2d& u,
                                double length_m) const {
    const Eigen::Vector2d normal(-u.y(), u.x());
    return std::any_of(
        joined_.segments.begin(), joined_.segments.end(), [&](const PlanSegment& wall) {
          if (wall.layer == PlanLayer::kMovable) return false;
          const double a = (wall.from - from).dot(normal);
          const double b = (wall.to - from).dot(normal);
          if (std::max(a, b) < 0.15 || std::min(a, b) > 0.04 || std::abs(a - b) < 0.1) return false;
          const double t = (wall.from + a / (a - b) * (wall.to - wall.from) - from).dot(u);
          return t > 0.04 && t < length_m - 0.04;
        });
  }

  /// Of a stretch that would be wall, nearly all may be: there is a wall on the map, or nobody saw
  /// floor right before it.
  [[nodiscard]] bool is_hidden(const Eigen::Vector2d& from, const Eigen::Vector2d& to) const {
    const double length_m = (to - from).norm();
    if (length_m > kPlanRooms.hidden_most_m) return false;
    if (length_m < 0.05) return true;
    const double cell_m = cells_.frame().resolution;
    const Eigen::Vector2d u = (to - from) / length_m;
    const Eigen::Vector2d normal(-u.y(), u.x());
    if (is_seen(from, u, length_m) || is_crossed(from, u, length_m)) return false;
    const int count = std::max(3, static_cast<int>(length_m / (0.5 * cell_m)));
    int may_be = 0;
    for (int i = 0; i < count; ++i) {
      const Eigen::Vector2d at = from + (i + 0.5) / count * (to - from);
      const auto cell_at = [&](double front) {
        return cells_.frame().cell_of(at + front * cell_m * normal);
      };
      const bool on_map = is_occupied_cell(cells_, cell_at(0.0)) ||
                          is_occupied_cell(cells_, cell_at(0.8)) ||
                          is_occupied_cell(cells_, cell_at(-0.8));
      const bool unseen =
          !is_free_cell(cells_, cell_at(0.0)) && !is_free_cell(cells_, cell_at(1.2));
      may_be += static_cast<int>(on_map || unseen);
    }
    return may_be >= 0.85 * count;
  }

  void build(const Bridge& bridge) {
    const OpenEnd& a = ends_[bridge.ends];
    const OpenEnd& b = begins_[bridge.begins];
    if (!bridge.has_corner) {
      push(a.at, b.at, a.sigma_across_m <= b.sigma_across_m ? a : b);
      return;
    }
    push(a.at, bridge.corner, a);
    push(bridge.corner, b.at, b);
  }

  /// As uncertain as the wall that it goes on from.
  void push(const Eigen::Vector2d& from, const Eigen::Vector2d& to, const OpenEnd& of) {
    const double length_m = (to - from).norm();
    if (length_m < 0.01) return;
    const double reach_m =
        0.5 * (segment(static_cast<std::size_t>(of.segment)).length_m() + length_m);
    PlanSegment hidden{.from = from,
                       .to = to,
                       .sigma_across_m = hypotenuse(of.sigma_across_m, reach_m * of.sigma_yaw_rad),
                       .sigma_yaw_rad = of.sigma_yaw_rad,
                       .sigma_from_m = of.sigma_across_m,
                       .sigma_to_m = of.sigma_across_m,
                       .layer = PlanLayer::kHidden};
    hidden.squared = segment(static_cast<std::size_t>(of.segment)).squared;
    joined_.segments.push_back(hidden);
    joined_.at_from.emplace_back();
    joined_.at_to.emplace_back();
    joined_.stands_free.push_back(false);
  }

  const Grid<std::int8_t>& cells_;
  JoinedSegments& joined_;
  std::vector<OpenEnd> ends_{};
  std::vector<OpenEnd> begins_{};
};

}  // namespace

void add_hidden_walls(const Grid<std::int8_t>& cells, JoinedSegments& joined) {
  HiddenWalls(cells, joined).add();
}

}  // namespace loopstone
