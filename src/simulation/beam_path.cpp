#include "simulation/beam_path.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "loopstone/base/hypotenuse.hpp"

namespace loopstone {
namespace {

constexpr double kPaneM = 1.0;
constexpr double kPaneShiftM = 0.37;     ///< walls stand on whole metres, borders of panes do not
constexpr double kBareThicknessM = 0.2;  ///< of a surface without an inside
constexpr int kMostBends = 4;            ///< of one beam
constexpr double kTurn = 1e-4;           ///< by which a beam is turned to feel a surface [rad]
constexpr double kJustOffM = 1e-6;
constexpr double kMostThroughM = 3.0;  ///< of a pane met at a grazing angle

Eigen::Vector2d turned(const Eigen::Vector2d& direction, double angle) {
  const double c = std::cos(angle);
  const double s = std::sin(angle);
  return {c * direction.x() - s * direction.y(), s * direction.x() + c * direction.y()};
}

double uniform_of_place(const Rng& rng, const Eigen::Vector2d& point) {
  const auto index = [](double at) {
    return static_cast<std::int64_t>(std::floor((at + kPaneShiftM) / kPaneM));
  };
  const std::int64_t place = index(point.x()) * 1'000'003 + index(point.y());
  return rng.fork(static_cast<std::uint64_t>(place)).uniform();
}

}  // namespace

BeamPath::BeamPath(const FloorPlan& plan, const Realism& realism, std::uint64_t seed)
    : glass_(realism.glass),
      mirrors_(realism.mirrors),
      glass_rng_(realism_stream(seed, "glass")),
      mirror_rng_(realism_stream(seed, "mirrors")) {
  for (const Box& box : plan.boxes) {
    is_wall_.insert(is_wall_.end(), 4, box.is_wall);
    thickness_m_.insert(thickness_m_.end(), 4, std::min(box.length_m, box.width_m));
  }
  is_wall_.insert(is_wall_.end(), plan.surfaces.size(), true);
  thickness_m_.insert(thickness_m_.end(), plan.surfaces.size(), kBareThicknessM);
}

double BeamPath::thickness_m(std::uint32_t surface) const { return thickness_m_[surface]; }

BeamPath::Pane BeamPath::pane_at(std::uint32_t surface, const Eigen::Vector2d& point) const {
  if (surface >= is_wall_.size() || !is_wall_[surface]) return Pane::kSolid;
  if (glass_.on && uniform_of_place(glass_rng_, point) < glass_.share) return Pane::kGlass;
  if (mirrors_.on && uniform_of_place(mirror_rng_, point) < mirrors_.share) return Pane::kMirror;
  return Pane::kSolid;
}

BeamEcho BeamPath::follow(const SurfaceIndex& surfaces, const Eigen::Vector2d& origin,
                          const Eigen::Vector2d& direction, double max_range_m,
                          const std::vector<Circle>& people) const {
  constexpr double kNever = std::numeric_limits<double>::infinity();
  Eigen::Vector2d from = origin;
  Eigen::Vector2d along = direction;
  double so_far = 0.0;
  for (int bend = 0;; ++bend) {
    const SurfaceHit hit = surfaces.hit(from, along, max_range_m);
    double person = kNever;
    for (const Circle& leg : people) person = std::min(person, range_to(leg, from, along));
    const double range = so_far + std::min(hit.range_m, person);
    if (!(range <= max_range_m)) return {kNever, 0.0, SurfaceHit::kNothing};
    if (person <= hit.range_m) return {range, 0.0, SurfaceHit::kNothing};

    // The surface next to the point that is met tells the incidence and the way of the surface.
    const Eigen::Vector2d point = from + hit.range_m * along;
    const Eigen::Vector2d beside = turned(along, kTurn);
    const double beside_m = surfaces.range_to_surface(hit.surface, from, beside);
    const bool is_felt = std::isfinite(beside_m) && hit.range_m > 0.0;
    const double tangent = is_felt ? std::abs(beside_m - hit.range_m) / (hit.range_m * kTurn) : 0.0;
    const Pane pane = pane_at(hit.surface, point);
    const bool returns = pane == Pane::kSolid || bend == kMostBends || !is_felt ||
                         (pane == Pane::kGlass && tangent <= std::tan(glass_.returns_within_rad));
    if (returns) return {range, tangent, hit.surface};
    so_far = range;
    if (pane == Pane::kGlass) {
      const double through =
          std::min(kMostThroughM, thickness_m(hit.surface) * hypotenuse(1.0, tangent)) + 0.01;
      so_far += through;
      from = point + through * along;
    } else {
      const Eigen::Vector2d wall = (from + beside_m * beside - point).normalized();
      const Eigen::Vector2d kept = along.dot(wall) * wall;
      from = point - kJustOffM * along;
      along = (2.0 * kept - along).normalized();
    }
  }
}

}  // namespace loopstone
