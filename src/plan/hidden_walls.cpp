#include <algorithm>
#include <array>
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

/// A piece of wall nobody saw that would join two ends.
struct Bridge {
  double length_m = 0.0;
  int ends = 0;    ///< its `to` is where the bridge begins
  int begins = 0;  ///< its `from` is where it ends
  Eigen::Vector2d corner{0.0, 0.0};
  bool has_corner = false;
};

class HiddenWalls {
 public:
  HiddenWalls(const Grid<std::int8_t>& cells, JoinedSegments& joined)
      : cells_(cells), joined_(joined), count_(joined.segments.size()) {}

  void add() {
    std::vector<Bridge> bridges;
    for (std::size_t a = 0; a < count_; ++a) {
      if (!is_open(a, joined_.at_to[a])) continue;
      for (std::size_t b = 0; b < count_; ++b) {
        if (a == b || !is_open(b, joined_.at_from[b])) continue;
        if (const auto bridge = bridge_between(a, b)) bridges.push_back(*bridge);
      }
    }
    std::stable_sort(bridges.begin(), bridges.end(),
                     [](const Bridge& x, const Bridge& y) { return x.length_m < y.length_m; });
    std::vector<bool> ends_used(count_, false);
    std::vector<bool> begins_used(count_, false);
    for (const Bridge& bridge : bridges) {
      const auto a = static_cast<std::size_t>(bridge.ends);
      const auto b = static_cast<std::size_t>(bridge.begins);
      if (ends_used[a] || begins_used[b]) continue;
      ends_used[a] = begins_used[b] = true;
      build(bridge);
    }
  }

 private:
  [[nodiscard]] const PlanSegment& segment(std::size_t i) const { return joined_.segments[i]; }

  /// A wall's end at which no other wall begins.
  [[nodiscard]] bool is_open(std::size_t i, const EndJoint& joint) const {
    if (segment(i).layer != PlanLayer::kStructure) return false;
    return joint.segment < 0 ||
           segment(static_cast<std::size_t>(joint.segment)).layer != PlanLayer::kStructure;
  }

  [[nodiscard]] std::optional<Bridge> bridge_between(std::size_t a, std::size_t b) const {
    const Eigen::Vector2d end = segment(a).to;
    const Eigen::Vector2d begin = segment(b).from;
    if ((end - begin).norm() > 1.5 * kPlan.hidden_most_m) return std::nullopt;
    const Eigen::Vector2d u = segment(a).direction();
    const Eigen::Vector2d v = segment(b).direction();
    const double sine = cross(u, v);
    Bridge bridge{.ends = static_cast<int>(a), .begins = static_cast<int>(b)};
    if (std::abs(sine) < std::sin(radians(5.0)) && u.dot(v) > 0.0) {
      if (std::abs((begin - end).dot(segment(a).normal())) > 0.05) return std::nullopt;
      bridge.length_m = (begin - end).dot(u);
      if (bridge.length_m <= 0.0 || !is_hidden(end, begin)) return std::nullopt;
      return bridge;
    }
    if (sine < std::sin(radians(30.0))) return std::nullopt;  // a room's corner turns left
    bridge.corner = end + cross(begin - end, v) / sine * u;
    bridge.has_corner = true;
    const double ahead = (bridge.corner - end).dot(u);
    const double behind = (begin - bridge.corner).dot(v);
    if (ahead < -0.1 || behind < -0.1) return std::nullopt;
    bridge.length_m = std::max(0.0, ahead) + std::max(0.0, behind);
    if (!is_hidden(end, bridge.corner) || !is_hidden(bridge.corner, begin)) return std::nullopt;
    return bridge;
  }

  /// Nobody saw floor right before it, and there are things that explain why.
  [[nodiscard]] bool is_hidden(const Eigen::Vector2d& from, const Eigen::Vector2d& to) const {
    const double length_m = (to - from).norm();
    if (length_m > kPlan.hidden_most_m) return false;
    if (length_m < 0.05) return true;
    const Eigen::Vector2d u = (to - from) / length_m;
    const Eigen::Vector2d normal(-u.y(), u.x());
    const double before_m = 1.2 * cells_.frame().resolution;
    if (free_share(cells_, from, to) > 0.15 ||
        free_share(cells_, from + before_m * normal, to + before_m * normal) > 0.35) {
      return false;
    }
    return length_m < 0.3 || covered_share(from, u, length_m) >= 0.5;
  }

  /// Of a stretch of wall, the share before which a thing stands.
  [[nodiscard]] double covered_share(const Eigen::Vector2d& from, const Eigen::Vector2d& u,
                                     double length_m) const {
    const Eigen::Vector2d normal(-u.y(), u.x());
    constexpr int kParts = 40;
    std::array<bool, kParts> covered{};
    for (std::size_t i = 0; i < count_; ++i) {
      const PlanSegment& thing = segment(i);
      if (thing.layer != PlanLayer::kMovable) continue;
      for (int part = 0; part < kParts; ++part) {
        const double at = (part + 0.5) / kParts * length_m;
        const double t0 = (thing.from - from).dot(u) - at;
        const double t1 = (thing.to - from).dot(u) - at;
        if (t0 * t1 > 0.0 || t0 == t1) continue;
        const Eigen::Vector2d hit = thing.from + t0 / (t0 - t1) * (thing.to - thing.from);
        const double front = (hit - from).dot(normal);
        if (front >= -0.02 && front <= kPlan.hidden_front_m)
          covered[static_cast<std::size_t>(part)] = true;
      }
    }
    return static_cast<double>(std::count(covered.begin(), covered.end(), true)) / kParts;
  }

  void build(const Bridge& bridge) {
    const PlanSegment a = segment(static_cast<std::size_t>(bridge.ends));
    const PlanSegment b = segment(static_cast<std::size_t>(bridge.begins));
    if (!bridge.has_corner) {
      push(a.to, b.from, a);
      return;
    }
    push(a.to, bridge.corner, a);
    push(bridge.corner, b.from, b);
  }

  /// As uncertain as the wall that it goes on from.
  void push(const Eigen::Vector2d& from, const Eigen::Vector2d& to, const PlanSegment& of) {
    if ((to - from).norm() < 0.01) return;
    const double reach_m = 0.5 * (of.length_m() + (to - from).norm());
    PlanSegment hidden = of;
    hidden.from = from;
    hidden.to = to;
    hidden.layer = PlanLayer::kHidden;
    hidden.sigma_across_m = hypotenuse(of.sigma_across_m, reach_m * of.sigma_yaw_rad);
    joined_.segments.push_back(hidden);
    joined_.at_from.emplace_back();
    joined_.at_to.emplace_back();
  }

  const Grid<std::int8_t>& cells_;
  JoinedSegments& joined_;
  std::size_t count_;
};

}  // namespace

void add_hidden_walls(const Grid<std::int8_t>& cells, JoinedSegments& joined) {
  HiddenWalls(cells, joined).add();
}

}  // namespace loopstone
