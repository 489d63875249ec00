#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <vector>

#include "loopstone/base/parallel_for.hpp"
#include "slam/surface_patches.hpp"

namespace loopstone {

/// What patches are for.
enum class SurfaceUse {
  kAdjust,  ///< poses: patches face about as their points do, and what they leave open is taken out
  /// To tell how well they hold a path: they say nothing of open directions already
  /// (forget_open_directions), and may face anywhere, for what faces somewhere on the map is a
  /// compass.
  kHold,
};

/// The part of the normal equations that patches add, with each patch's own offset and slope
/// eliminated:
///
///   y = (A - B C^-1 B^T) x, A = sum w J^T J, B = sum w J^T (1, t), C = sum w (1, t)^T (1, t)
///
/// It couples all key scans that see a patch, so it is never formed, only multiplied with. A
/// translation that all of a key scan's surfaces leave open is taken out of its J.
class SurfaceSystem {
 public:
  /// A sight at the present poses: its distance from the patch depends on its pose as (n, turn) *
  /// step.
  struct Row {
    int place = -1;
    float turn = 0.0F;    ///< d residual / d yaw
    float along = 0.0F;   ///< t: position along the patch
    float weight = 0.0F;  ///< over sigma^2
  };
  /// \param places  of each key scan in x and y, -1 where it is held
  /// \param size    of x and y
  SurfaceSystem(const SurfacePatches& patches, std::span<const int> places, std::size_t size,
                Threads threads, SurfaceUse use = SurfaceUse::kAdjust);

  /// Residuals at the poses, weights from them (Cauchy), gradient; returns the robust cost.
  /// \param sigma_m  standard deviation of a point of weight 1
  double linearise(std::span<const PlacedKey> map_T_key, double sigma_m);

  [[nodiscard]] const std::vector<Eigen::Vector3d>& gradient() const { return gradient_; }
  /// The blocks of A - B C^-1 B^T on the diagonal.
  [[nodiscard]] const std::vector<Eigen::Matrix3d>& diagonal() const { return diagonal_; }

  [[nodiscard]] const SurfacePatches& patches() const { return patches_; }
  [[nodiscard]] const std::vector<Row>& rows() const { return rows_; }
  /// d residual / d pose of a row with a place, without what its key scan's surfaces leave open.
  [[nodiscard]] Eigen::Vector3d jacobian(const Eigen::Vector2d& normal, const Row& row) const {
    const Eigen::Vector3d all(normal.x(), normal.y(), row.turn);
    const Open& open = open_[static_cast<std::size_t>(row.place)];
    return all - all.dot(open.motion) * open.share;
  }
  /// C^-1 of a patch.
  [[nodiscard]] Eigen::Matrix2d inverse(std::size_t patch) const {
    const Inverse& c = inverses_[patch];
    return (Eigen::Matrix2d() << c.a, c.b, c.b, c.c).finished();
  }

  /// y += (A - B C^-1 B^T) x
  void multiply_add(std::span<const Eigen::Vector3d> x, std::span<Eigen::Vector3d> y);

  /// Standard deviation of sights about their patch, from the median distance.
  [[nodiscard]] double spread_m(std::span<const PlacedKey> map_T_key) const;

 private:
  /// C^-1 of a patch.
  struct Inverse {
    double a = 0.0;
    double b = 0.0;
    double c = 0.0;
  };
  /// Of a key scan whose surfaces leave a translation open: J - (J motion) share has none of it.
  struct Open {
    Eigen::Vector3d motion = Eigen::Vector3d::Zero();
    Eigen::Vector3d share = Eigen::Vector3d::Zero();
  };
  struct Chunk {
    std::size_t first = 0;
    std::size_t last = 0;
    std::vector<double> distances{};        ///< of one patch
    std::vector<Eigen::Vector3d> vector{};  ///< its share of a product or gradient
    std::vector<Eigen::Matrix3d> diagonal{};
    double cost = 0.0;
  };
  void find_open(std::span<const PlacedKey> map_T_key);
  void linearise_patch(std::size_t index, std::span<const PlacedKey> map_T_key, double sigma_m,
                       Chunk& chunk);

  const SurfacePatches& patches_;
  std::span<const int> places_;
  Threads threads_;
  SurfaceUse use_;
  std::vector<Row> rows_;
  std::vector<Open> open_;  ///< by place
  std::vector<Inverse> inverses_;
  std::vector<Chunk> chunks_;
  std::vector<Eigen::Vector3d> gradient_;
  std::vector<Eigen::Matrix3d> diagonal_;
};

}  // namespace loopstone
