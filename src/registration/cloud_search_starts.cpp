#include "registration/cloud_search_starts.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "geometry/symmetric_matrix.hpp"
#include "loopstone/geometry/angle.hpp"

namespace loopstone {

namespace {

constexpr std::size_t kLanes = 4;
using Lanes = Eigen::Array<float, 4, 1>;

/// How much motion across a residual counts in the Hessian, beside motion along
/// it.
constexpr float kAcross = 0.1F;
constexpr float kDamping = 1e-4F;
constexpr float kLongestTurnRad = 0.5F;

Eigen::Matrix3d turn_about_z(double angle) {
  return Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()).toRotationMatrix();
}

/// n^T J: how the distance along n changes with the small motion, lane by lane.
std::array<Lanes, 3> project(const std::array<Lanes, 2>& n, const std::array<Lanes, 2>& arm) {
  return {n[0], n[1], arm[0] * n[1] - arm[1] * n[0]};
}
std::array<Lanes, 6> project(const std::array<Lanes, 3>& n, const std::array<Lanes, 3>& arm) {
  return {n[0],
          n[1],
          n[2],
          arm[1] * n[2] - arm[2] * n[1],
          arm[2] * n[0] - arm[0] * n[2],
          arm[0] * n[1] - arm[1] * n[0]};
}

Eigen::Matrix2f small_turn(const Eigen::Matrix<float, 1, 1>& angle) {
  return Eigen::Rotation2Df(angle(0)).toRotationMatrix();
}
Eigen::Matrix3f small_turn(const Eigen::Vector3f& vector) {
  const float angle = vector.norm();
  if (!(angle > 0.0F)) return Eigen::Matrix3f::Identity();
  return Eigen::AngleAxisf(angle, vector / angle).toRotationMatrix();
}

/// J^T J summed over points, whose first and second moments about the source's
/// origin are on the target's axes.
Eigen::Matrix3f motion_of_all(float count, const Eigen::Vector2f& sum,
                              const Eigen::Matrix2f& squares) {
  Eigen::Matrix3f result;
  result << count, 0.0F, -sum.y(),  //
      0.0F, count, sum.x(),         //
      -sum.y(), sum.x(), squares.trace();
  return result;
}
Eigen::Matrix<float, 6, 6> motion_of_all(float count, const Eigen::Vector3f& sum,
                                         const Eigen::Matrix3f& squares) {
  Eigen::Matrix3f cross;  // [sum]x
  cross << 0.0F, -sum.z(), sum.y(), sum.z(), 0.0F, -sum.x(), -sum.y(), sum.x(), 0.0F;
  Eigen::Matrix<float, 6, 6> result;
  result.topLeftCorner<3, 3>() = count * Eigen::Matrix3f::Identity();
  result.topRightCorner<3, 3>() = -cross;
  result.bottomLeftCorner<3, 3>() = cross;
  result.bottomRightCorner<3, 3>() = squares.trace() * Eigen::Matrix3f::Identity() - squares;
  return result;
}

template <int kDimension>
struct Descent {
  static constexpr int kDof = RigidMotion<kDimension>::kDof;
  static constexpr std::size_t kAxes = kDimension;
  using Vector = Eigen::Matrix<float, kDimension, 1>;
  using Matrix = Eigen::Matrix<float, kDimension, kDimension>;
  using Tangent = Eigen::Matrix<float, kDof, 1>;
  using Information = Eigen::Matrix<float, kDof, kDof>;
  using Vectors = std::array<Lanes, kAxes>;

  struct Normal {
    Information hessian = Information::Zero();
    Tangent gradient = Tangent::Zero();
    float rmse_m = 0.0F;
  };

  const DistanceField<kDimension>& field;
  const FewPoints<kDimension>& points;
  std::size_t kept;  ///< points that count
  Vector sum = Vector::Zero();
  Matrix squares = Matrix::Zero();
  std::vector<float> distances{};  ///< scratch

  Descent(const DistanceField<kDimension>& the_field, const FewPoints<kDimension>& the_points,
          double overlap)
      : field(the_field),
        points(the_points),
        kept(std::clamp<std::size_t>(
            static_cast<std::size_t>(std::ceil(overlap * static_cast<double>(the_points.count))), 1,
            the_points.count)) {
    for (std::size_t i = 0; i < points.count; ++i) {
      Vector p;
      for (std::size_t a = 0; a < kAxes; ++a) p(static_cast<Eigen::Index>(a)) = points.axes[a][i];
      sum += p;
      squares += p * p.transpose();
    }
    const float share = static_cast<float>(kept) / static_cast<float>(points.count);
    sum *= share;
    squares *= share;
  }

  /// Four points: from the source's origin to each, and from the nearest site
  /// to each.
  struct Block {
    Vectors arm;
    Vectors residual;
    Lanes squared;
  };

  [[nodiscard]] Block block_at(std::size_t first, const Start<kDimension>& pose) const {
    Block block;
    for (std::size_t a = 0; a < kAxes; ++a) block.arm[a].setZero();
    for (std::size_t k = 0; k < kAxes; ++k) {
      const Lanes along = Eigen::Map<const Lanes>(points.axes[k].data() + first);
      for (std::size_t a = 0; a < kAxes; ++a) {
        block.arm[a] +=
            pose.rotation(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(k)) * along;
      }
    }
    const VoxelFrame<kDimension>& frame = field.frame();
    const float per_m = 1.0F / frame.resolution_m;
    Eigen::Array<std::int32_t, 4, 1> voxel = Eigen::Array<std::int32_t, 4, 1>::Zero();
    Vectors moved;
    for (std::size_t a = kAxes; a-- > 0;) {
      const auto axis = static_cast<Eigen::Index>(a);
      moved[a] = block.arm[a] + pose.translation(axis);
      const Lanes along = (moved[a] - frame.low(axis)) * per_m;
      const auto last = static_cast<float>(frame.counts[a] - 1);
      // Written so that NaN is in the first voxel.
      const Lanes inside = (along > 0.0F).select(along.min(last), Lanes::Zero());
      voxel = voxel * frame.counts[a] + inside.template cast<std::int32_t>();
    }
    for (std::size_t lane = 0; lane < kLanes; ++lane) {
      const auto l = static_cast<Eigen::Index>(lane);
      const Vector& site = field.sites()[static_cast<std::size_t>(
          field.nearest()[static_cast<std::size_t>(voxel(l))])];
      for (std::size_t a = 0; a < kAxes; ++a) {
        block.residual[a](l) = moved[a](l) - site(static_cast<Eigen::Index>(a));
      }
    }
    block.squared = block.residual[0] * block.residual[0];
    for (std::size_t a = 1; a < kAxes; ++a) block.squared += block.residual[a] * block.residual[a];
    return block;
  }

  /// The squared distance that separates the points that count from the others.
  [[nodiscard]] float limit_at(const Start<kDimension>& pose) {
    if (kept == points.count) return std::numeric_limits<float>::infinity();
    distances.resize(points.axes[0].size());
    for (std::size_t i = 0; i < distances.size(); i += kLanes) {
      Eigen::Map<Lanes>(distances.data() + i) = block_at(i, pose).squared;
    }
    const auto limit = distances.begin() + static_cast<std::ptrdiff_t>(kept - 1);
    std::nth_element(distances.begin(), limit,
                     distances.begin() + static_cast<std::ptrdiff_t>(points.count));
    return *limit;
  }

  [[nodiscard]] Normal linearise(const Start<kDimension>& pose) {
    constexpr std::size_t kRows = kDof;
    const float limit = limit_at(pose);
    std::array<Lanes, kRows*(kRows + 1) / 2> hessian;
    std::array<Lanes, kRows> gradient;
    for (Lanes& lanes : hessian) lanes.setZero();
    for (Lanes& lanes : gradient) lanes.setZero();
    Lanes squared_sum = Lanes::Zero();
    Lanes used = Lanes::Zero();
    const std::size_t size = points.axes[0].size();
    for (std::size_t i = 0; i < size; i += kLanes) {
      const Block block = block_at(i, pose);
      Lanes weight = (block.squared <= limit).select(Lanes::Ones(), Lanes::Zero());
      for (std::size_t lane = 0; lane < kLanes; ++lane) {
        if (i + lane >= points.count) weight(static_cast<Eigen::Index>(lane)) = 0.0F;
      }
      const Lanes distance = block.squared.max(1e-30F).sqrt();
      Vectors normal;
      for (std::size_t a = 0; a < kAxes; ++a) normal[a] = block.residual[a] / distance;
      const std::array<Lanes, kRows> row = project(normal, block.arm);
      std::size_t entry = 0;
      for (std::size_t a = 0; a < kRows; ++a) {
        const Lanes weighted = weight * row[a];
        gradient[a] += weighted * distance;
        for (std::size_t b = a; b < kRows; ++b) hessian[entry++] += weighted * row[b];
      }
      squared_sum += weight * block.squared;
      used += weight;
    }
    Normal sums;
    std::size_t entry = 0;
    for (int a = 0; a < kDof; ++a) {
      sums.gradient(a) = gradient[static_cast<std::size_t>(a)].sum();
      for (int b = a; b < kDof; ++b) {
        sums.hessian(a, b) = (1.0F - kAcross) * hessian[entry++].sum();
        sums.hessian(b, a) = sums.hessian(a, b);
      }
    }
    const Vector turned = pose.rotation * sum;
    const Matrix spread = pose.rotation * squares * pose.rotation.transpose();
    sums.hessian += kAcross * motion_of_all(static_cast<float>(kept), turned, spread);
    sums.rmse_m = std::sqrt(squared_sum.sum() / std::max(used.sum(), 1.0F));
    return sums;
  }

  static Start<kDimension> moved(const Start<kDimension>& pose, const Normal& sums) {
    constexpr int kTurns = kDof - kDimension;
    Information damped = sums.hessian;
    damped.diagonal() *= 1.0F + kDamping;
    Tangent motion = -solve_symmetric(damped, sums.gradient);
    if (!motion.allFinite()) return pose;
    const float angle = motion.template tail<kTurns>().norm();
    if (angle > kLongestTurnRad) motion *= kLongestTurnRad / angle;
    Start<kDimension> next = pose;
    next.translation += motion.template head<kDimension>();
    next.rotation =
        small_turn(Eigen::Matrix<float, kTurns, 1>(motion.template tail<kTurns>())) * pose.rotation;
    return next;
  }
};

}  // namespace

template <int kDimension>
std::vector<typename RigidMotion<kDimension>::Matrix> even_rotations(int count, bool upright) {
  std::vector<typename RigidMotion<kDimension>::Matrix> rotations;
  if (kDimension == 2 || upright) {
    const int even = std::max(2, count + count % 2);
    for (int i = 0; i < even; ++i) {
      rotations.push_back(turn_about_z((i + 0.5) * 2.0 * std::numbers::pi / even)
                              .template topLeftCorner<kDimension, kDimension>());
    }
    return rotations;
  }
  // A unit quaternion and its negative are the same turn, so four of the eight
  // faces are enough. The tangent evens out the angles between neighbours.
  const int cells = std::max(1, static_cast<int>(std::lround(std::cbrt(count / 4.0))));
  const auto coordinate = [cells](int i) {
    return std::tan(0.25 * std::numbers::pi * ((2.0 * i + 1.0) / cells - 1.0));
  };
  for (int face = 0; face < 4; ++face) {
    for (int i = 0; i < cells * cells * cells; ++i) {
      const std::array<double, 3> on_face{coordinate(i % cells), coordinate(i / cells % cells),
                                          coordinate(i / cells / cells)};
      Eigen::Vector4d q;
      for (int k = 0; k < 4; ++k) {
        q(k) = k == face ? 1.0 : on_face[static_cast<std::size_t>(k < face ? k : k - 1)];
      }
      rotations.push_back(Eigen::Quaterniond(q)
                              .normalized()
                              .toRotationMatrix()
                              .template topLeftCorner<kDimension, kDimension>());
    }
  }
  return rotations;
}

template <int kDimension>
FewPoints<kDimension> few_points(std::span<const Eigen::Matrix<float, kDimension, 1>> points,
                                 std::span<const std::size_t> sample) {
  FewPoints<kDimension> few;
  few.count = sample.size();
  const std::size_t padded = (sample.size() + kLanes - 1) / kLanes * kLanes;
  for (std::size_t a = 0; a < few.axes.size(); ++a) {
    for (std::size_t i = 0; i < padded; ++i) {
      few.axes[a].push_back(
          points[sample[std::min(i, sample.size() - 1)]](static_cast<Eigen::Index>(a)));
    }
  }
  return few;
}

template <int kDimension>
std::vector<Start<kDimension>> placements(const PointBox<kDimension>& model,
                                          const FewPoints<kDimension>& points,
                                          const Start<kDimension>& start) {
  using Vector = Eigen::Matrix<float, kDimension, 1>;
  PointBox<kDimension> source;
  for (std::size_t i = 0; i < points.count; ++i) {
    Vector point;
    for (std::size_t a = 0; a < points.axes.size(); ++a) {
      point(static_cast<Eigen::Index>(a)) = points.axes[a][i];
    }
    const Vector turned = start.rotation * point;
    source.low = i == 0 ? turned : Vector(source.low.cwiseMin(turned));
    source.high = i == 0 ? turned : Vector(source.high.cwiseMax(turned));
  }
  const std::array<Vector, 3> flush{model.low - source.low, model.high - source.high,
                                    0.5F * (model.low + model.high - source.low - source.high)};
  std::vector<Start<kDimension>> starts{start};
  int count = 1;
  for (int axis = 0; axis < kDimension; ++axis) count *= 3;
  for (int k = 0; k < count; ++k) {
    Start<kDimension> placed = start;
    for (int axis = 0, rest = k; axis < kDimension; ++axis, rest /= 3) {
      placed.translation(axis) = flush[static_cast<std::size_t>(rest % 3)](axis);
    }
    starts.push_back(placed);
  }
  return starts;
}

template <int kDimension>
Start<kDimension> descend(const DistanceField<kDimension>& field,
                          const FewPoints<kDimension>& points, double overlap, int steps,
                          const Start<kDimension>& start) {
  Descent<kDimension> descent(field, points, overlap);
  Start<kDimension> pose = start;
  for (int step = 0; step < steps; ++step) {
    pose = Descent<kDimension>::moved(pose, descent.linearise(pose));
  }
  pose.rmse_m = descent.linearise(pose).rmse_m;
  return pose;
}

template std::vector<Eigen::Matrix2d> even_rotations<2>(int, bool);
template std::vector<Eigen::Matrix3d> even_rotations<3>(int, bool);
template FewPoints<2> few_points<2>(std::span<const Eigen::Vector2f>, std::span<const std::size_t>);
template FewPoints<3> few_points<3>(std::span<const Eigen::Vector3f>, std::span<const std::size_t>);
template std::vector<Start<2>> placements<2>(const PointBox<2>&, const FewPoints<2>&,
                                             const Start<2>&);
template std::vector<Start<3>> placements<3>(const PointBox<3>&, const FewPoints<3>&,
                                             const Start<3>&);
template Start<2> descend<2>(const DistanceField<2>&, const FewPoints<2>&, double, int,
                             const Start<2>&);
template Start<3> descend<3>(const DistanceField<3>&, const FewPoints<3>&, double, int,
                             const Start<3>&);

}  // namespace loopstone
