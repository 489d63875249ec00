#include "loopstone/simulation/floor_pattern.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "loopstone/base/error.hpp"

namespace loopstone {
namespace {

constexpr float kMostSamples = 12.0F;

bool is_power_of_two(int value) { return value > 0 && (value & (value - 1)) == 0; }

int wrapped(std::int64_t index, int count) {
  return static_cast<int>(index & (count - 1));  // also for negative ones, as count is a power of 2
}

int floored(float value) {
  const auto whole = static_cast<int>(value);
  return whole - static_cast<int>(static_cast<float>(whole) > value);
}

/// Share of each of the texels that an interval covers, times their size.
template <typename Visitor>
void for_each_share(double low, double high, Visitor&& visit) {
  const auto first = static_cast<std::int64_t>(std::floor(low));
  for (std::int64_t i = first; static_cast<double>(i) < high; ++i) {
    const double from = std::max(low, static_cast<double>(i));
    const double to = std::min(high, static_cast<double>(i + 1));
    if (to > from) visit(i, to - from);
  }
}

}  // namespace

FloorPattern::FloorPattern(int columns, int rows, const Eigen::Vector2d& texel_m,
                           const std::vector<LinearColour>& texels,
                           std::vector<FloorLetter> letters)
    : texel_m_(texel_m), letters_(std::move(letters)) {
  if (!is_power_of_two(columns) || !is_power_of_two(rows) || !(texel_m.minCoeff() > 0.0) ||
      texels.size() != static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows)) {
    throw UsageError("a floor pattern needs 2^m x 2^n texels of positive size");
  }
  Level finest{columns, rows, {}};
  finest.texels.reserve(texels.size());
  for (const LinearColour& c : texels) finest.texels.emplace_back(c.x(), c.y(), c.z(), 0.0F);
  levels_.push_back(std::move(finest));
  while (levels_.back().columns > 1 || levels_.back().rows > 1) {
    const Level& fine = levels_.back();
    const int step_x = fine.columns > 1 ? 2 : 1;
    const int step_y = fine.rows > 1 ? 2 : 1;
    Level coarse{fine.columns / step_x, fine.rows / step_y, {}};
    coarse.texels.reserve(static_cast<std::size_t>(coarse.columns) *
                          static_cast<std::size_t>(coarse.rows));
    for (int row = 0; row < coarse.rows; ++row) {
      for (int column = 0; column < coarse.columns; ++column) {
        Texel sum = Texel::Zero();
        for (int y = 0; y < step_y; ++y) {
          for (int x = 0; x < step_x; ++x) {
            sum += fine.texels[static_cast<std::size_t>(row * step_y + y) *
                                   static_cast<std::size_t>(fine.columns) +
                               static_cast<std::size_t>(column * step_x + x)];
          }
        }
        coarse.texels.push_back(sum / static_cast<float>(step_x * step_y));
      }
    }
    levels_.push_back(std::move(coarse));
  }
}

Eigen::Vector2d FloorPattern::period_m() const {
  return {levels_.front().columns * texel_m_.x(), levels_.front().rows * texel_m_.y()};
}

LinearColour FloorPattern::mean() const { return levels_.back().texels.front().head<3>(); }

LinearColour FloorPattern::mean_over(const Extent& rectangle) const {
  const Level& finest = levels_.front();
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double area = 0.0;
  for_each_share(
      rectangle.low.y() / texel_m_.y(), rectangle.high.y() / texel_m_.y(),
      [&](std::int64_t y, double height) {
        const Texel* row = &finest.texels[static_cast<std::size_t>(wrapped(y, finest.rows)) *
                                          static_cast<std::size_t>(finest.columns)];
        for_each_share(rectangle.low.x() / texel_m_.x(), rectangle.high.x() / texel_m_.x(),
                       [&](std::int64_t x, double width) {
                         const Texel& texel = row[wrapped(x, finest.columns)];
                         sum += width * height * texel.head<3>().cast<double>();
                         area += width * height;
                       });
      });
  return (sum / area).cast<float>();
}

LinearColour FloorPattern::mean_over(const Pose2& map_T_centre, double side_m) const {
  const auto count = std::max(1, static_cast<int>(std::ceil(2.0 * side_m / texel_m_.minCoeff())));
  const double step = side_m / count;
  const Level& finest = levels_.front();
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int i = 0; i < count; ++i) {
    for (int j = 0; j < count; ++j) {
      const Eigen::Vector2d p = map_T_centre * Eigen::Vector2d((i + 0.5) * step - 0.5 * side_m,
                                                               (j + 0.5) * step - 0.5 * side_m);
      const auto x = static_cast<std::int64_t>(std::floor(p.x() / texel_m_.x()));
      const auto y = static_cast<std::int64_t>(std::floor(p.y() / texel_m_.y()));
      const Texel& texel = finest.texels[static_cast<std::size_t>(wrapped(y, finest.rows)) *
                                             static_cast<std::size_t>(finest.columns) +
                                         static_cast<std::size_t>(wrapped(x, finest.columns))];
      sum += texel.head<3>().cast<double>();
    }
  }
  return (sum / (static_cast<double>(count) * count)).cast<float>();
}

Eigen::Vector2f FloorPattern::to_texels(const Eigen::Vector2d& point) const {
  const Level& finest = levels_.front();
  double u = point.x() / texel_m_.x();
  double v = point.y() / texel_m_.y();
  u -= std::floor(u / finest.columns) * finest.columns;
  v -= std::floor(v / finest.rows) * finest.rows;
  return {static_cast<float>(u), static_cast<float>(v)};
}

FloorPattern::Texel FloorPattern::bilinear(const Level& level, float u, float v) {
  const int column = floored(u);
  const int row = floored(v);
  const float right = u - static_cast<float>(column);
  const float up = v - static_cast<float>(row);
  const int c0 = column & (level.columns - 1);
  const int c1 = (column + 1) & (level.columns - 1);
  const auto columns = static_cast<std::size_t>(level.columns);
  const Texel* r0 = &level.texels[static_cast<std::size_t>(row & (level.rows - 1)) * columns];
  const Texel* r1 = &level.texels[static_cast<std::size_t>((row + 1) & (level.rows - 1)) * columns];
  const Texel low = r0[c0] + right * (r0[c1] - r0[c0]);
  const Texel high = r1[c0] + right * (r1[c1] - r1[c0]);
  return low + up * (high - low);
}

LinearColour FloorPattern::seen_over(const Eigen::Vector2d& point,
                                     const FloorFootprint& footprint) const {
  // Axes of the covariance; a box of width w has the variance w^2 / 12.
  const float middle = 0.5F * (footprint.xx + footprint.yy);
  const float half = 0.5F * (footprint.xx - footprint.yy);
  const float root = std::sqrt(half * half + footprint.xy * footprint.xy);
  const float major = std::sqrt(12.0F * (middle + root));
  const auto texel = static_cast<float>(texel_m_.minCoeff());
  const float minor =
      std::max({std::sqrt(12.0F * std::max(middle - root, 0.0F)), texel, major / kMostSamples});
  const int samples = std::max(1, static_cast<int>(std::ceil(major / minor - 0.01F)));
  // Eigenvector of the larger eigenvalue, from the row of the matrix that cancels least.
  Eigen::Vector2f axis = half >= 0.0F ? Eigen::Vector2f(half + root, footprint.xy)
                                      : Eigen::Vector2f(footprint.xy, root - half);
  const float norm = axis.norm();
  axis = norm > 0.0F ? Eigen::Vector2f(axis * (major / norm)) : Eigen::Vector2f(0.0F, 0.0F);
  const Eigen::Vector2f step(axis.x() / static_cast<float>(texel_m_.x()),
                             axis.y() / static_cast<float>(texel_m_.y()));

  // Level whose texels are as wide as the minor axis: log2 by its binary exponent, straight in
  // between.
  const float ratio = minor / texel;
  const auto bits = std::bit_cast<std::uint32_t>(ratio);
  auto level = static_cast<std::size_t>((bits >> 23U) - 127U);
  float blend = std::bit_cast<float>((bits & 0x7fffffU) | 0x3f800000U) - 1.0F;
  if (level + 1 >= levels_.size()) {
    level = levels_.size() - 1;
    blend = 0.0F;
  }
  const Level& fine = levels_[level];
  const float fine_scale = 1.0F / static_cast<float>(std::uint32_t{1} << level);
  const Eigen::Vector2f at = to_texels(point);
  Texel fine_sum = Texel::Zero();
  Texel coarse_sum = Texel::Zero();
  const float share = 1.0F / static_cast<float>(samples);
  for (int i = 0; i < samples; ++i) {
    const float along = (static_cast<float>(i) + 0.5F) * share - 0.5F;
    const float u = (at.x() + along * step.x()) * fine_scale;
    const float v = (at.y() + along * step.y()) * fine_scale;
    fine_sum += bilinear(fine, u - 0.5F, v - 0.5F);
    if (blend > 0.0F) {
      coarse_sum += bilinear(levels_[level + 1], 0.5F * u - 0.5F, 0.5F * v - 0.5F);
    }
  }
  return share * ((1.0F - blend) * fine_sum + blend * coarse_sum).head<3>();
}

std::vector<FloorLetter> FloorPattern::letters_in(const Extent& rectangle) const {
  std::vector<FloorLetter> found;
  const Eigen::Vector2d period = period_m();
  const auto from = [&](int axis) {
    return static_cast<std::int64_t>(std::floor(rectangle.low[axis] / period[axis]));
  };
  for (std::int64_t j = from(1); static_cast<double>(j) * period.y() < rectangle.high.y(); ++j) {
    for (std::int64_t i = from(0); static_cast<double>(i) * period.x() < rectangle.high.x(); ++i) {
      for (FloorLetter letter : letters_) {
        letter.map_T_letter.x += static_cast<double>(i) * period.x();
        letter.map_T_letter.y += static_cast<double>(j) * period.y();
        const Eigen::Vector2d low = letter.map_T_letter.translation();
        const Eigen::Vector2d high =
            letter.map_T_letter * Eigen::Vector2d(letter.height_m * 5.0 / 7.0, letter.height_m);
        const bool inside = (low.cwiseMin(high).array() >= rectangle.low.array()).all() &&
                            (low.cwiseMax(high).array() <= rectangle.high.array()).all();
        if (inside) found.push_back(letter);
      }
    }
  }
  return found;
}

}  // namespace loopstone
