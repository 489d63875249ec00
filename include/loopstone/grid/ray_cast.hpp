#pragma once

#include <cstddef>
#include <span>
#include <utility>
#include <variant>

#include "loopstone/grid/ray.hpp"
#include "loopstone/grid/sphere_caster.hpp"
#include "loopstone/grid/table_caster.hpp"
#include "loopstone/grid/walk_caster.hpp"

namespace loopstone {

/// Any of the three ways to cast rays on a map (docs/ray_casting.md says which when). Immutable and
/// thread-safe; copies share what was built.
class RayCaster {
 public:
  using Method = std::variant<WalkCaster, SphereCaster, TableCaster>;

  // NOLINTBEGIN(google-explicit-constructor): a caster of any kind is a RayCaster
  RayCaster(WalkCaster caster) : method_(std::move(caster)) {}
  RayCaster(SphereCaster caster) : method_(std::move(caster)) {}
  RayCaster(TableCaster caster) : method_(std::move(caster)) {}
  // NOLINTEND(google-explicit-constructor)

  /// Range of one ray [m]; +inf: nothing within the greatest range.
  [[nodiscard]] double range(const Ray& ray) const {
    return std::visit([&](const auto& caster) { return caster.range(ray); }, method_);
  }
  /// Ranges of many rays [m], several times faster than one by one. Throws UsageError, as the call
  /// below, when `ranges_m` has another size than the rays.
  void ranges(std::span<const Ray> rays, std::span<float> ranges_m) const {
    std::visit([&](const auto& caster) { caster.ranges(rays, ranges_m); }, method_);
  }
  /// Ranges of the beams of many scans [m].
  void ranges(const ScanRays& rays, std::span<float> ranges_m) const {
    std::visit([&](const auto& caster) { caster.ranges(rays, ranges_m); }, method_);
  }

  [[nodiscard]] double max_range_m() const {
    return std::visit([](const auto& caster) { return caster.max_range_m(); }, method_);
  }
  [[nodiscard]] std::size_t memory_bytes() const {
    return std::visit([](const auto& caster) { return caster.memory_bytes(); }, method_);
  }
  [[nodiscard]] const Method& method() const { return method_; }

 private:
  Method method_;
};

}  // namespace loopstone
