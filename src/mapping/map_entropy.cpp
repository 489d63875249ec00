#include "mapping/map_entropy.hpp"

#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "loopstone/geometry/angle.hpp"
#include "mapping/cell_runs.hpp"
#include "mapping/wall_pieces.hpp"

namespace loopstone {
namespace {

constexpr auto kRadiusM = static_cast<float>(kMapEntropy.radius_m);
constexpr std::size_t kPerTask = 128;

struct EntropyPoint {
  Eigen::Vector2f position;
  Eigen::Vector2f normal;
  int stretch = 0;
};

/// Sums about a nearby origin, so that floats of a large map lose nothing.
struct Moments {
  int count = 0;
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  Eigen::Matrix2d squares = Eigen::Matrix2d::Zero();

  void add(const Eigen::Vector2d& offset) {
    ++count;
    sum += offset;
    squares += offset * offset.transpose();
  }
  [[nodiscard]] double entropy() const {
    const Eigen::Vector2d mean = sum / count;
    Eigen::Matrix2d covariance = squares / count - mean * mean.transpose();
    covariance.diagonal().array() += kMapEntropy.least_variance_m2;
    return std::log(2.0 * kPi) + 1.0 + 0.5 * std::log(covariance.determinant());
  }
};

/// Calls visit(point) for those near the query that face the same way.
template <typename Visit>
void for_each_near(const CellRuns<EntropyPoint>& cells, const EntropyPoint& query, Visit&& visit) {
  cells.for_each_around(cells.cell_of(query.position), 1, [&](const EntropyPoint& point) {
    if ((point.position - query.position).squaredNorm() <= kRadiusM * kRadiusM &&
        point.normal.dot(query.normal) >= kSameFacing) {
      visit(point);
    }
  });
}

std::vector<EntropyPoint> points_of(std::span<const JudgedScan> scans) {
  constexpr auto kMostReturns = static_cast<std::size_t>(kMapEntropy.most_returns);
  std::size_t count = 0;
  for (const JudgedScan& scan : scans) count += scan.returns.size();
  const std::size_t stride = std::max<std::size_t>(1, (count + kMostReturns - 1) / kMostReturns);
  std::vector<EntropyPoint> points;
  points.reserve(count / stride + 1);
  std::size_t index = 0;
  for (const JudgedScan& scan : scans) {
    for (const WallReturn& seen : scan.returns) {
      if (index++ % stride == 0) points.push_back({seen.measured, seen.normal, scan.stretch});
    }
  }
  return points;
}

}  // namespace

MapEntropy map_entropy(std::span<const JudgedScan> scans, Threads threads) {
  const CellRuns<EntropyPoint> cells(points_of(scans), static_cast<double>(kRadiusM));
  const auto& points = cells.items();
  const std::size_t queries =
      std::min(points.size(), static_cast<std::size_t>(kMapEntropy.most_queries));
  std::vector<MapEntropy> parts((queries + kPerTask - 1) / kPerTask);
  parallel_for(parts.size(), threads, [&](std::size_t task) {
    MapEntropy& part = parts[task];
    const std::size_t end = std::min((task + 1) * kPerTask, queries);
    for (std::size_t q = task * kPerTask; q < end; ++q) {
      const EntropyPoint& query = points[q * points.size() / queries];
      Moments all;
      Moments own;
      int others = 0;
      for_each_near(cells, query, [&](const EntropyPoint& point) {
        const Eigen::Vector2d offset = (point.position - query.position).cast<double>();
        all.add(offset);
        if (point.stretch == query.stretch) own.add(offset);
        if (are_apart(point.stretch, query.stretch)) ++others;
      });
      if (own.count < kMapEntropy.least_points || others < kMapEntropy.least_points) continue;
      ++part.points;
      part.mean_nats += all.entropy();
      part.stretch_nats += own.entropy();
    }
  });
  MapEntropy total;
  for (const MapEntropy& part : parts) {
    total.points += part.points;
    total.mean_nats += part.mean_nats;
    total.stretch_nats += part.stretch_nats;
  }
  if (total.points > 0) {
    total.mean_nats /= static_cast<double>(total.points);
    total.stretch_nats /= static_cast<double>(total.points);
  }
  return total;
}

}  // namespace loopstone
