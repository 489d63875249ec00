#pragma once

#include <cstdint>
#include <vector>

#include "loopstone/simulation/floor_plan.hpp"
#include "loopstone/simulation/realism.hpp"
#include "loopstone/simulation/surface_index.hpp"

namespace loopstone {

/// What a beam meets.
struct BeamEcho {
  double range_m = 0.0;        ///< +inf: nothing
  double tan_incidence = 0.0;  ///< from the surface's normal
  std::uint32_t surface = SurfaceHit::kNothing;
};

/// Follows a beam through panes of glass and by way of mirrors. Which panes are which is a matter
/// of the place, the same at every visit.
class BeamPath {
 public:
  /// \param seed  of the world: all drives in it meet the same panes
  BeamPath(const FloorPlan& plan, const Realism& realism, std::uint64_t seed);

  /// \param direction  of unit length
  /// \param people     who stand in the way
  [[nodiscard]] BeamEcho follow(const SurfaceIndex& surfaces, const Eigen::Vector2d& origin,
                                const Eigen::Vector2d& direction, double max_range_m,
                                const std::vector<Circle>& people) const;

 private:
  enum class Pane { kSolid, kGlass, kMirror };
  [[nodiscard]] Pane pane_at(std::uint32_t surface, const Eigen::Vector2d& point) const;
  [[nodiscard]] double thickness_m(std::uint32_t surface) const;

  std::vector<bool> is_wall_{};        ///< of each flat surface
  std::vector<double> thickness_m_{};  ///< likewise
  RealismGlass glass_;
  RealismMirrors mirrors_;
  Rng glass_rng_;
  Rng mirror_rng_;
};

}  // namespace loopstone
