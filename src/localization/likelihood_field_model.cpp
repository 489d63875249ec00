#include "loopstone/localization/likelihood_field_model.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "localization/field_lookup.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/geometry/angle.hpp"
#include "loopstone/grid/distance_transform.hpp"
#include "loopstone/registration/likelihood_field.hpp"

namespace loopstone {
namespace {

constexpr int kWorstCost = 255;
// Of one task of parallel_for.
constexpr std::size_t kPosesPrepared = 4096;
constexpr std::size_t kPosesAtOnce = 256;
constexpr std::size_t kPointsAtOnce = 16;
// Smaller maps stay in a processor's second cache, whatever the order.
constexpr std::size_t kBytesInCache = 256 * 1024;
constexpr std::size_t kPosesToOrder = 512;

/// Log-likelihoods of a distance as whole steps below the best. Thrun 2005, table 6.3.
class DistanceCosts {
 public:
  explicit DistanceCosts(const LikelihoodFieldOptions& options)
      : options_(options),
        peak_((1.0 - options.random_share) / (std::sqrt(2.0 * kPi) * options.hit_sigma_m)),
        floor_(options.random_share / options.max_range_m),
        best_log_(std::log(peak_ + floor_)) {
    const double unknown_log = std::log(1.0 / options.max_range_m);
    const double worst_log = std::min(log_likelihood(options.max_distance_m), unknown_log);
    step_ = std::max(best_log_ - worst_log, 1e-9) / kWorstCost;
    unknown_cost_ = cost_of(unknown_log);
    // From here on every distance costs the same, so the logarithm can be saved.
    constant_from_m_ = options.max_distance_m;
    constant_cost_ = cost_of(log_likelihood(constant_from_m_));
    for (double nearer = 0.0, half = 0.0; constant_from_m_ - nearer > 1e-6;) {
      half = 0.5 * (nearer + constant_from_m_);
      (cost_of(log_likelihood(half)) == constant_cost_ ? constant_from_m_ : nearer) = half;
    }
  }

  [[nodiscard]] std::uint8_t cost(double distance_m) const {
    if (!(distance_m < constant_from_m_)) return constant_cost_;
    return cost_of(log_likelihood(distance_m));
  }
  [[nodiscard]] std::uint8_t unknown_cost() const { return unknown_cost_; }
  [[nodiscard]] double step() const { return step_; }

 private:
  [[nodiscard]] double log_likelihood(double distance_m) const {
    const double deviation = distance_m / options_.hit_sigma_m;
    return std::log(peak_ * std::exp(-0.5 * deviation * deviation) + floor_);
  }
  [[nodiscard]] std::uint8_t cost_of(double log_likelihood) const {
    const double steps = std::round((best_log_ - log_likelihood) / step_);
    return static_cast<std::uint8_t>(std::clamp(steps, 0.0, static_cast<double>(kWorstCost)));
  }

  LikelihoodFieldOptions options_;
  double peak_;
  double floor_;
  double best_log_;
  double step_ = 0.0;
  double constant_from_m_ = 0.0;
  std::uint8_t constant_cost_ = 0;
  std::uint8_t unknown_cost_ = 0;
};

std::vector<std::uint8_t> unknown_cells(const std::vector<std::int8_t>& occupancy) {
  std::vector<std::uint8_t> unknown(occupancy.size());
  std::transform(occupancy.begin(), occupancy.end(), unknown.begin(),
                 [](std::int8_t percent) { return static_cast<std::uint8_t>(percent < 0); });
  return unknown;
}

detail::ByteField field_of(const GridFrame& frame, int padded_rows,
                           const std::vector<std::uint8_t>& cells) {
  return {.cells = cells.data(),
          .padded_rows = static_cast<std::uint32_t>(padded_rows),
          .last_column = static_cast<float>(frame.columns + 1),
          .last_row = static_cast<float>(frame.rows + 1),
          .origin_x_m = frame.origin.x(),
          .origin_y_m = frame.origin.y(),
          .cells_per_m = 1.0 / frame.resolution};
}

void check_sizes(std::size_t poses, std::size_t out) {
  if (poses != out) throw UsageError("log-likelihoods of poses need one place for each pose");
}

detail::PoseArrays prepared(const detail::ByteField& field, std::span<const Pose2> map_T_robot,
                            Threads threads) {
  detail::PoseArrays poses = detail::pose_arrays(map_T_robot.size());
  const std::size_t tasks = (map_T_robot.size() + kPosesPrepared - 1) / kPosesPrepared;
  parallel_for(tasks, threads, [&](std::size_t task) {
    const std::size_t first = task * kPosesPrepared;
    const std::size_t end = std::min(first + kPosesPrepared, map_T_robot.size());
    detail::prepare_poses(field, map_T_robot, first, end, poses);
  });
  return poses;
}

/// The low 8 bits of a number, each followed by a zero.
std::uint32_t spread_bits(std::uint32_t bits) {
  bits = (bits | bits << 4) & 0x0F0FU;
  bits = (bits | bits << 2) & 0x3333U;
  return (bits | bits << 1) & 0x5555U;
}

/// Poses in an order in which those that follow each other look at the same part of a large map:
/// along a Z-curve (Morton 1966) over squares of it.
std::vector<std::uint32_t> local_order(const detail::ByteField& field,
                                       const detail::PoseArrays& poses, std::size_t count,
                                       std::size_t map_bytes) {
  std::vector<std::uint32_t> order(count);
  std::iota(order.begin(), order.end(), 0U);
  if (map_bytes < kBytesInCache || count < kPosesToOrder) return order;
  constexpr int kSquares = 64;  // a side
  const float last = std::max(field.last_column, field.last_row);
  const auto square = [=](float coordinate) {
    return static_cast<std::uint32_t>(std::clamp(coordinate / last, 0.0F, 1.0F) * (kSquares - 1));
  };
  std::vector<std::uint16_t> keys(count);
  std::array<std::uint32_t, kSquares * kSquares + 1> starts{};
  for (std::size_t i = 0; i < count; ++i) {
    keys[i] = static_cast<std::uint16_t>(spread_bits(square(poses.x[i])) |
                                         spread_bits(square(poses.y[i])) << 1);
    ++starts[keys[i] + 1U];
  }
  std::partial_sum(starts.begin(), starts.end(), starts.begin());
  for (std::size_t i = 0; i < count; ++i) order[starts[keys[i]]++] = static_cast<std::uint32_t>(i);
  return order;
}

}  // namespace

LikelihoodFieldModel::LikelihoodFieldModel(const Grid<std::int8_t>& occupancy,
                                           const LikelihoodFieldOptions& options, Threads threads) {
  build(distance_transform(visible_walls(occupancy, options.occupied_percent), threads),
        unknown_cells(occupancy.cells()), options, threads);
}

LikelihoodFieldModel::LikelihoodFieldModel(const Grid<float>& distances_m,
                                           const LikelihoodFieldOptions& options, Threads threads) {
  std::vector<std::uint8_t> unknown(distances_m.cells().size());
  std::transform(distances_m.cells().begin(), distances_m.cells().end(), unknown.begin(),
                 [](float distance) { return static_cast<std::uint8_t>(std::isnan(distance)); });
  build(distances_m, unknown, options, threads);
}

void LikelihoodFieldModel::build(const Grid<float>& distances_m,
                                 const std::vector<std::uint8_t>& unknown,
                                 const LikelihoodFieldOptions& options, Threads threads) {
  frame_ = distances_m.frame();
  if (!(frame_.resolution >= 1e-5 && frame_.resolution <= 1e3)) {
    throw UsageError("a likelihood field needs cells between 1e-5 m and 1 km");
  }
  constexpr int kMostCells = 1 << 22;  // whole in a float, with room for fractions
  if (frame_.columns > kMostCells || frame_.rows > kMostCells) {
    throw UsageError("a likelihood field has at most 2^22 cells a side; use a coarser map");
  }
  const std::size_t strips = (static_cast<std::size_t>(frame_.columns) + 2 + 7) / 8;
  padded_rows_ = (frame_.rows + 2 + 7) / 8 * 8;
  const std::size_t size = strips * 8 * static_cast<std::size_t>(padded_rows_);
  if (size > static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max())) {
    throw UsageError("a likelihood field has at most 2^31 cells; use a coarser map");
  }
  const DistanceCosts costs(options);
  step_ = costs.step();
  costs_.assign(size, costs.unknown_cost());
  disagreements_.assign(size, 0);
  parallel_for(strips, threads, [&](std::size_t strip) {
    const int first = std::max(0, static_cast<int>(strip) * 8 - 1);
    const int end = std::min(frame_.columns, static_cast<int>(strip) * 8 + 7);
    for (int row = 0; row < frame_.rows; ++row) {
      for (int column = first; column < end; ++column) {
        const std::size_t from = frame_.index_of({column, row});
        const std::size_t to = index_of({column, row});
        const double distance_m = static_cast<double>(distances_m.cells()[from]);
        const bool is_unknown = unknown[from] != 0;
        const std::uint8_t cost =
            std::isnan(distance_m) ? costs.unknown_cost() : costs.cost(distance_m);
        costs_[to] = is_unknown ? std::min(cost, costs.unknown_cost()) : cost;
        disagreements_[to] =
            static_cast<std::uint8_t>(!is_unknown && distance_m > options.agree_distance_m);
      }
    }
  });
}

std::size_t LikelihoodFieldModel::index_of(Cell cell) const {
  if (!frame_.contains(cell)) return 0;  // the border's corner
  const auto column = static_cast<std::size_t>(cell.column) + 1;
  const auto row = static_cast<std::size_t>(cell.row) + 1;
  return column / 8 * 8 * static_cast<std::size_t>(padded_rows_) + row * 8 + column % 8;
}

int LikelihoodFieldModel::cost(Cell cell) const { return costs_[index_of(cell)]; }

bool LikelihoodFieldModel::disagrees(Cell cell) const {
  return disagreements_[index_of(cell)] != 0;
}

void LikelihoodFieldModel::log_likelihoods(std::span<const Pose2> map_T_robot,
                                           std::span<const Eigen::Vector2f> points_robot,
                                           std::span<double> out, Threads threads) const {
  check_sizes(map_T_robot.size(), out.size());
  const detail::ByteField field = field_of(frame_, padded_rows_, costs_);
  const detail::PointArrays points = detail::point_arrays(points_robot);
  const detail::PoseArrays poses = prepared(field, map_T_robot, threads);
  const std::vector<std::uint32_t> order =
      local_order(field, poses, map_T_robot.size(), costs_.size());
  const std::uint64_t padding = (points.x.size() - points_robot.size()) * costs_[0];
  std::vector<std::uint64_t> sums(map_T_robot.size());
  const std::size_t tasks = (order.size() + kPosesAtOnce - 1) / kPosesAtOnce;
  parallel_for(tasks, threads, [&](std::size_t task) {
    const std::size_t first = task * kPosesAtOnce;
    const std::size_t count = std::min(kPosesAtOnce, order.size() - first);
    const auto part = std::span<const std::uint32_t>(order).subspan(first, count);
    detail::sum_over_points(field, poses, part, points, sums.data());
  });
  for (std::size_t i = 0; i < out.size(); ++i) {
    out[i] = 0.0 - step_ * static_cast<double>(sums[i] - padding);
  }
}

BeamSkipResult LikelihoodFieldModel::log_likelihoods_skipping(
    std::span<const Pose2> map_T_robot, std::span<const Eigen::Vector2f> points_robot,
    std::span<double> out, const BeamSkipOptions& skip, Threads threads) const {
  check_sizes(map_T_robot.size(), out.size());
  const detail::ByteField field = field_of(frame_, padded_rows_, disagreements_);
  const detail::PointArrays points = detail::point_arrays(points_robot);
  const detail::PoseArrays poses = prepared(field, map_T_robot, threads);
  std::vector<std::uint64_t> disagreeing(points_robot.size(), 0);
  // Point by point: poses close together look at the same few cache lines. Padding falls on the
  // border, which agrees.
  const std::size_t tasks = (points_robot.size() + kPointsAtOnce - 1) / kPointsAtOnce;
  parallel_for(tasks, threads, [&](std::size_t task) {
    const std::size_t first = task * kPointsAtOnce;
    const std::size_t end = std::min(first + kPointsAtOnce, points_robot.size());
    detail::sum_over_poses(field, poses, points, first, end, disagreeing.data());
  });

  BeamSkipResult result{.kept = std::vector<std::uint8_t>(points_robot.size(), 1)};
  std::vector<Eigen::Vector2f> kept;
  kept.reserve(points_robot.size());
  const double most = skip.max_disagreeing_share * static_cast<double>(map_T_robot.size());
  for (std::size_t i = 0; i < points_robot.size(); ++i) {
    if (static_cast<double>(disagreeing[i]) > most) {
      result.kept[i] = 0;
      ++result.skipped;
    } else {
      kept.push_back(points_robot[i]);
    }
  }
  if (static_cast<double>(result.skipped) >
      skip.max_skipped_share * static_cast<double>(points_robot.size())) {
    result.kept.assign(points_robot.size(), 1);
    result.skipped = 0;
    result.gave_up = true;
    kept.assign(points_robot.begin(), points_robot.end());
  }
  log_likelihoods(map_T_robot, kept, out, threads);
  return result;
}

}  // namespace loopstone
