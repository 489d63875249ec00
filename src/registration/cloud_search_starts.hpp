#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "loopstone/geometry/rigid_motion.hpp"
#include "loopstone/registration/distance_field.hpp"

namespace loopstone {

/// About `count` rotations that cover all turns evenly, or those about the z
/// axis alone. Reversing two axes before or after any of them gives another one
/// of them, so they are the same rotations whatever the signs of principal
/// axes. In space they are the cells' centres of a grid on the faces of a cube
/// of four dimensions, blown up to the sphere of unit quaternions.
template <int kDimension>
[[nodiscard]] std::vector<typename RigidMotion<kDimension>::Matrix> even_rotations(int count,
                                                                                   bool upright);

/// A few points of a cloud, axis by axis, filled up with copies of the last one
/// so that four can be treated at once.
template <int kDimension>
struct FewPoints {
  std::array<std::vector<float>, kDimension> axes{};
  std::size_t count = 0;  ///< without the copies
};

template <int kDimension>
[[nodiscard]] FewPoints<kDimension> few_points(
    std::span<const Eigen::Matrix<float, kDimension, 1>> points,
    std::span<const std::size_t> sample);

/// A pose on its way to a minimum, in the principal frames of source and model.
template <int kDimension>
struct Start {
  Eigen::Matrix<float, kDimension, kDimension> rotation =
      Eigen::Matrix<float, kDimension, kDimension>::Identity();
  Eigen::Matrix<float, kDimension, 1> translation = Eigen::Matrix<float, kDimension, 1>::Zero();
  float rmse_m = 0.0F;
  int number = 0;
};

/// A block along the axes.
template <int kDimension>
struct PointBox {
  Eigen::Matrix<float, kDimension, 1> low;
  Eigen::Matrix<float, kDimension, 1> high;
};

/// The start, and others with its rotation: a cloud that is a part of the model
/// lies within the model's box, so along each axis the turned source is laid
/// flush with the one end of the box, or the other, or in its middle. \return 1
/// + 3^kDimension starts
template <int kDimension>
[[nodiscard]] std::vector<Start<kDimension>> placements(const PointBox<kDimension>& model,
                                                        const FewPoints<kDimension>& points,
                                                        const Start<kDimension>& start);

/// So many Gauss-Newton steps on
///
///   sum_i |r_i|^2,  r_i = R p_i + t - nearest site
///
/// over the closest `overlap` of the points. The Hessian counts motion along
/// r_i in full and motion across it by a tenth: across it the nearest site
/// changes and the distance hardly grows. \return the pose reached, with its
/// rmse
template <int kDimension>
[[nodiscard]] Start<kDimension> descend(const DistanceField<kDimension>& field,
                                        const FewPoints<kDimension>& points, double overlap,
                                        int steps, const Start<kDimension>& start);

}  // namespace loopstone
