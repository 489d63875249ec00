#include "localization/field_lookup.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

// Vectors of ARM's SVE have no size to the compiler, so they cannot stand in arrays; NEON is there.
#define HWY_DISABLED_TARGETS (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "localization/field_lookup.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

// What stands between the HWY_ macros is compiled for each instruction set.
HWY_BEFORE_NAMESPACE();
namespace loopstone::detail::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Floats = hn::CappedTag<float, kLaneMultiple>;
using Ints = hn::RebindToUnsigned<Floats>;
using Doubles = hn::CappedTag<double, kLaneMultiple / 2>;
using HalfFloats = hn::Rebind<float, Doubles>;
using Words = hn::RebindToUnsigned<Doubles>;

/// By reduction to [-pi/4, pi/4] (Cody and Waite 1980) and Taylor series, errors below 3e-8. NaN
/// where the reduction fails.
HWY_INLINE void sin_cos(hn::Vec<Doubles> angle, hn::Vec<Doubles>& sin, hn::Vec<Doubles>& cos) {
  const Doubles d;
  const Words w;
  // Adding 1.5 * 2^52 leaves the nearest whole number in the low bits.
  const auto shift = hn::Set(d, 6755399441055744.0);
  const auto shifted = hn::Add(hn::Mul(angle, hn::Set(d, 0.63661977236758134308)), shift);
  const auto quarters = hn::Sub(shifted, shift);
  // pi/2 in two parts, the first of 33 bits, so that the first product is exact.
  auto r = hn::Sub(angle, hn::Mul(quarters, hn::Set(d, 1.57079632673412561417)));
  r = hn::Sub(r, hn::Mul(quarters, hn::Set(d, 6.07710050650619224932e-11)));
  r = hn::IfThenElse(hn::Le(hn::Abs(r), hn::Set(d, 1.0)), r, hn::NaN(d));
  const auto r2 = hn::Mul(r, r);
  auto s = hn::Add(hn::Mul(r2, hn::Set(d, 1.0 / 362880.0)), hn::Set(d, -1.0 / 5040.0));
  s = hn::Add(hn::Mul(r2, s), hn::Set(d, 1.0 / 120.0));
  s = hn::Add(hn::Mul(r2, s), hn::Set(d, -1.0 / 6.0));
  s = hn::Add(hn::Mul(hn::Mul(r2, s), r), r);
  auto c = hn::Add(hn::Mul(r2, hn::Set(d, 1.0 / 40320.0)), hn::Set(d, -1.0 / 720.0));
  c = hn::Add(hn::Mul(r2, c), hn::Set(d, 1.0 / 24.0));
  c = hn::Add(hn::Mul(r2, c), hn::Set(d, -0.5));
  c = hn::Add(hn::Mul(r2, c), hn::Set(d, 1.0));
  // Quarter turns q: odd ones swap the two, bit 1 of q is the sine's sign, bit 1 of q + 1 the
  // cosine's.
  const auto q = hn::BitCast(w, shifted);
  const auto swap = hn::RebindMask(d, hn::TestBit(q, hn::Set(w, 1)));
  const auto sign = hn::Set(w, std::uint64_t{1} << 63);
  const auto sin_sign = hn::And(hn::ShiftLeft<62>(q), sign);
  const auto cos_sign = hn::And(hn::ShiftLeft<62>(hn::Add(q, hn::Set(w, 1))), sign);
  sin = hn::Xor(hn::IfThenElse(swap, c, s), hn::BitCast(d, sin_sign));
  cos = hn::Xor(hn::IfThenElse(swap, s, c), hn::BitCast(d, cos_sign));
}

void prepare_poses(const ByteField& field, const Pose2* map_T_robot, std::size_t begin,
                   std::size_t end, PoseArrays& poses) {
  static_assert(sizeof(Pose2) == 3 * sizeof(double));
  const Doubles d;
  const HalfFloats h;
  const std::size_t lanes = hn::Lanes(d);
  const auto scale = hn::Set(d, field.cells_per_m);
  // A border of one cell, less the half that rounding to the nearest whole number adds.
  const auto border = hn::Set(d, 0.5);
  const auto most = hn::Set(d, kMostCoordinate);
  HWY_ALIGN double last[3 * kLaneMultiple];
  for (std::size_t i = begin; i < end; i += lanes) {
    const double* from = &map_T_robot[i].x;
    if (i + lanes > end) {  // the last ones; what is no pose is no number, hence outside the map
      std::fill_n(last, 3 * kLaneMultiple, std::numeric_limits<double>::quiet_NaN());
      for (std::size_t k = 0; k < 3 * (end - i); ++k) last[k] = (&map_T_robot[i + k / 3].x)[k % 3];
      from = last;
    }
    hn::Vec<Doubles> x;
    hn::Vec<Doubles> y;
    hn::Vec<Doubles> yaw;
    hn::LoadInterleaved3(d, from, x, y, yaw);
    x = hn::Add(hn::Mul(hn::Sub(x, hn::Set(d, field.origin_x_m)), scale), border);
    y = hn::Add(hn::Mul(hn::Sub(y, hn::Set(d, field.origin_y_m)), scale), border);
    hn::Vec<Doubles> sin;
    hn::Vec<Doubles> cos;
    sin_cos(yaw, sin, cos);
    // Comparisons with NaN are false. Such a pose has all points at one place, outside.
    const auto near = hn::And(hn::Le(hn::Abs(x), most), hn::Le(hn::Abs(y), most));
    const auto good = hn::And(near, hn::Le(hn::Abs(sin), hn::Set(d, 2.0)));
    hn::StoreU(hn::DemoteTo(h, hn::IfThenElseZero(good, hn::Mul(cos, scale))), h, &poses.cos[i]);
    hn::StoreU(hn::DemoteTo(h, hn::IfThenElseZero(good, hn::Mul(sin, scale))), h, &poses.sin[i]);
    const auto outside = hn::Set(d, -1.0);
    hn::StoreU(hn::DemoteTo(h, hn::IfThenElse(good, x, outside)), h, &poses.x[i]);
    hn::StoreU(hn::DemoteTo(h, hn::IfThenElse(good, y, outside)), h, &poses.y[i]);
  }
}

/// In whole cells above 2^23, as the bits of a float: adding 2^23 rounds to the nearest cell.
HWY_INLINE hn::Vec<Ints> cell_bits(hn::Vec<Floats> at, float last) {
  const Floats d;
  const auto within = hn::Min(hn::Max(at, hn::Zero(d)), hn::Set(d, last));
  return hn::BitCast(Ints(), hn::Add(within, hn::Set(d, 8388608.0F)));
}

/// Where the bytes below points are, one a lane. None of the inputs is NaN, nor so large that one
/// could arise.
HWY_INLINE hn::Vec<Ints> indices(const ByteField& field, hn::Vec<Floats> cos, hn::Vec<Floats> sin,
                                 hn::Vec<Floats> x, hn::Vec<Floats> y, hn::Vec<Floats> point_x,
                                 hn::Vec<Floats> point_y) {
  const Ints i;
  const auto at_x = hn::Add(hn::Sub(hn::Mul(cos, point_x), hn::Mul(sin, point_y)), x);
  const auto at_y = hn::Add(hn::Add(hn::Mul(sin, point_x), hn::Mul(cos, point_y)), y);
  const auto column = cell_bits(at_x, field.last_column);
  const auto row = cell_bits(at_y, field.last_row);
  // column / 8 * (8 * padded_rows) + row * 8 + column % 8, less what the bits of 2^23 have added,
  // modulo 2^32.
  constexpr std::uint32_t kBits = 0x4B000000;
  const std::uint32_t excess = kBits * (field.padded_rows + 8);
  const auto strip = hn::Mul(hn::AndNot(hn::Set(i, 7), column), hn::Set(i, field.padded_rows - 1));
  const auto in_strip = hn::Add(column, hn::ShiftLeft<3>(row));
  return hn::Add(hn::Sub(in_strip, hn::Set(i, excess)), strip);
}

/// Bytes are loaded one by one: a gather of words is no faster, and much slower where processors
/// guard or microcode it.
HWY_INLINE std::uint64_t sum_bytes(const std::uint8_t* cells, const std::uint32_t* at,
                                   std::size_t count) {
  const auto byte = [=](std::size_t i) { return std::uint64_t{cells[at[i]]}; };
  std::uint64_t sum = 0;
  for (std::size_t i = 0; i < count; i += 8) {
    sum += byte(i) + byte(i + 1) + byte(i + 2) + byte(i + 3) + byte(i + 4) + byte(i + 5) +
           byte(i + 6) + byte(i + 7);
  }
  return sum;
}

void sum_over_points(const ByteField& field, const PoseArrays& poses, const std::uint32_t* order,
                     std::size_t count, const PointArrays& points, std::uint64_t* sums) {
  const Floats d;
  HWY_ALIGN std::uint32_t at[kAtOnce];
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t pose = order[k];
    const auto cos = hn::Set(d, poses.cos[pose]);
    const auto sin = hn::Set(d, poses.sin[pose]);
    const auto x = hn::Set(d, poses.x[pose]);
    const auto y = hn::Set(d, poses.y[pose]);
    std::uint64_t sum = 0;
    for (std::size_t begin = 0; begin < points.x.size(); begin += kAtOnce) {
      const std::size_t size = HWY_MIN(kAtOnce, points.x.size() - begin);
      const float* const point_x = &points.x[begin];
      const float* const point_y = &points.y[begin];
      for (std::size_t i = 0; i < size; i += hn::Lanes(d)) {
        hn::Store(
            indices(field, cos, sin, x, y, hn::LoadU(d, point_x + i), hn::LoadU(d, point_y + i)),
            Ints(), at + i);
      }
      sum += sum_bytes(field.cells, at, size);
    }
    sums[pose] = sum;
  }
}

void sum_over_poses(const ByteField& field, const PoseArrays& poses, const PointArrays& points,
                    std::size_t begin, std::size_t end, std::uint64_t* sums) {
  const Floats d;
  HWY_ALIGN std::uint32_t at[kAtOnce];
  for (std::size_t point = begin; point < end; ++point) {
    const auto point_x = hn::Set(d, points.x[point]);
    const auto point_y = hn::Set(d, points.y[point]);
    std::uint64_t sum = 0;
    for (std::size_t first = 0; first < poses.x.size(); first += kAtOnce) {
      const std::size_t size = HWY_MIN(kAtOnce, poses.x.size() - first);
      for (std::size_t i = 0; i < size; i += hn::Lanes(d)) {
        const std::size_t pose = first + i;
        hn::Store(
            indices(field, hn::LoadU(d, &poses.cos[pose]), hn::LoadU(d, &poses.sin[pose]),
                    hn::LoadU(d, &poses.x[pose]), hn::LoadU(d, &poses.y[pose]), point_x, point_y),
            Ints(), at + i);
      }
      sum += sum_bytes(field.cells, at, size);
    }
    sums[point] = sum;
  }
}

}  // namespace loopstone::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace loopstone::detail {

HWY_EXPORT(prepare_poses);
HWY_EXPORT(sum_over_points);
HWY_EXPORT(sum_over_poses);

PoseArrays pose_arrays(std::size_t count) {
  PoseArrays poses;
  for (auto* values : {&poses.cos, &poses.sin}) values->assign(padded(count), 0.0F);
  for (auto* values : {&poses.x, &poses.y}) values->assign(padded(count), -1.0F);
  return poses;
}

PointArrays point_arrays(std::span<const Eigen::Vector2f> points) {
  const std::size_t size = padded(points.size());
  PointArrays arrays{.x = std::vector<float>(size, kFarPoint_m),
                     .y = std::vector<float>(size, kFarPoint_m)};
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (std::abs(points[i].x()) <= kFarthestPoint_m &&
        std::abs(points[i].y()) <= kFarthestPoint_m) {
      arrays.x[i] = points[i].x();
      arrays.y[i] = points[i].y();
    }
  }
  return arrays;
}

void prepare_poses(const ByteField& field, std::span<const Pose2> map_T_robot, std::size_t begin,
                   std::size_t end, PoseArrays& poses) {
  HWY_DYNAMIC_DISPATCH(prepare_poses)(field, map_T_robot.data(), begin, end, poses);
}

void sum_over_points(const ByteField& field, const PoseArrays& poses,
                     std::span<const std::uint32_t> order, const PointArrays& points,
                     std::uint64_t* sums) {
  HWY_DYNAMIC_DISPATCH(sum_over_points)(field, poses, order.data(), order.size(), points, sums);
}

void sum_over_poses(const ByteField& field, const PoseArrays& poses, const PointArrays& points,
                    std::size_t begin, std::size_t end, std::uint64_t* sums) {
  HWY_DYNAMIC_DISPATCH(sum_over_poses)(field, poses, points, begin, end, sums);
}

}  // namespace loopstone::detail
#endif
