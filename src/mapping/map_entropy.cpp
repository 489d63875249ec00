#include "mapping/map_entropy.hpp"

#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "loopstone/geometry/angle.hpp"
#include "loopstone/grid/block_grid.hpp"
#include "mapping/wall_pieces.hpp"

namespace loopstone {
namespace {

constexpr float kRadiusM = 0.3F;
constexpr std::size_t kMostQueries = 3000;
constexpr std::size_t kMostReturns = 400000;
/// A covariance of fewer points is none.
constexpr int kLeastPoints = 8;
/// Walls thinner than this are not told apart: (1 mm)^2, so that a perfect wall has an entropy.
constexpr double kLeastVarianceM2 = 1e-6;
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
    covariance.diagonal().array() += kLeastVarianceM2;
    return std::log(2.0 * kPi) + 1.0 + 0.5 * std::log(covariance.determinant());
  }
};

/// Points in the order of the cells that they lie in.
class PointCells {
 public:
  explicit PointCells(std::vector<EntropyPoint> points) : points_(std::move(points)) {
    const auto before = [&](const EntropyPoint& a, const EntropyPoint& b) {
      const Cell cell_a = cell_of(a);
      const Cell cell_b = cell_of(b);
      return cell_a.row != cell_b.row ? cell_a.row < cell_b.row : cell_a.column < cell_b.column;
    };
    std::stable_sort(points_.begin(), points_.end(), before);
    for (std::size_t i = 0; i < points_.size(); ++i) {
      Run& run = grid_.at(cell_of(points_[i]));
      if (run.end == 0) run.first = i;
      run.end = i + 1;
    }
  }

  [[nodiscard]] const std::vector<EntropyPoint>& points() const { return points_; }

  template <typename Visit>
  void for_each_near(const EntropyPoint& query, Visit&& visit) const {
    const Cell centre = cell_of(query);
    for (int row = centre.row - 1; row <= centre.row + 1; ++row) {
      for (int column = centre.column - 1; column <= centre.column + 1; ++column) {
        const Run* run = grid_.find({column, row});
        if (run == nullptr) continue;
        for (std::size_t i = run->first; i < run->end; ++i) {
          if ((points_[i].position - query.position).squaredNorm() <= kRadiusM * kRadiusM &&
              points_[i].normal.dot(query.normal) >= kSameFacing) {
            visit(points_[i]);
          }
        }
      }
    }
  }

 private:
  struct Run {
    std::size_t first = 0;
    std::size_t end = 0;
  };
  [[nodiscard]] Cell cell_of(const EntropyPoint& point) const {
    return grid_.cell_of(static_cast<double>(point.position.x()),
                         static_cast<double>(point.position.y()));
  }
  std::vector<EntropyPoint> points_;
  BlockGrid<Run> grid_{static_cast<double>(kRadiusM)};
};

std::vector<EntropyPoint> points_of(std::span<const JudgedScan> scans) {
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
  const PointCells cells(points_of(scans));
  const auto& points = cells.points();
  const std::size_t queries = std::min(points.size(), kMostQueries);
  std::vector<MapEntropy> parts((queries + kPerTask - 1) / kPerTask);
  parallel_for(parts.size(), threads, [&](std::size_t task) {
    MapEntropy& part = parts[task];
    const std::size_t end = std::min((task + 1) * kPerTask, queries);
    for (std::size_t q = task * kPerTask; q < end; ++q) {
      const EntropyPoint& query = points[q * points.size() / queries];
      Moments all;
      Moments own;
      int others = 0;
      cells.for_each_near(query, [&](const EntropyPoint& point) {
        const Eigen::Vector2d offset = (point.position - query.position).cast<double>();
        all.add(offset);
        if (point.stretch == query.stretch) own.add(offset);
        if (are_apart(point.stretch, query.stretch)) ++others;
      });
      if (own.count < kLeastPoints || others < kLeastPoints) continue;
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
