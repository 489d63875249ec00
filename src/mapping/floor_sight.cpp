#include "mapping/floor_sight.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <initializer_list>

#include "loopstone/geometry/pose3.hpp"
#include "loopstone/sensor/camera_geometry.hpp"

namespace loopstone {
namespace {

constexpr int kEvery = 2;      ///< obstacle pixels looked at, in both directions
constexpr int kTiltEvery = 8;  ///< pixels that tell the tilt

}  // namespace

FloorSight::FloorSight(const CameraModel& camera, const FloorPlane& plane, double noise_per_m,
                       double height_tolerance_m)
    : width_(camera.depth.width_px),
      height_(camera.depth.height_px),
      noise_gate_per_m_(static_cast<float>(3.0 * noise_per_m)),
      height_gate_(static_cast<float>(height_tolerance_m / plane.height_m())),
      plane_height_m_(plane.height_m()) {
  const Pose3 colour_T_depth =
      robot_T_colour_optical(camera).inverse() * robot_T_depth_optical(camera);
  const Eigen::Matrix3d colour_R_depth = colour_T_depth.rotation.toRotationMatrix();
  depth_in_colour_m_ = colour_T_depth.translation.cast<float>();
  const LensModel& lens = colour_lens(camera);
  // So far apart that the marks of one hole leave no block between them.
  const double baseline_m = std::max(1e-3, colour_T_depth.translation.head<2>().norm());
  void_step_per_m_ = static_cast<float>(kBlock / (lens.focal_x_px * baseline_m));
  most_per_m_ = static_cast<float>(1.5 / std::max(0.1, camera.encoding.range_min_m));
  focal_x_px_ = static_cast<float>(lens.focal_x_px);
  focal_y_px_ = static_cast<float>(lens.focal_y_px);
  centre_x_px_ = static_cast<float>(lens.centre_x_px);
  centre_y_px_ = static_cast<float>(lens.centre_y_px);
  block_columns_ = (lens.width_px + kBlock - 1) / kBlock;
  block_rows_ = (lens.height_px + kBlock - 1) / kBlock;
  for (int row = 0; row < height_; ++row) {
    for (int column = 0; column < width_; ++column) {
      const Eigen::Vector3d ray = ray_through(camera.depth, Eigen::Vector2d(column, row));
      expected_.push_back(static_cast<float>(plane.slope.dot(ray)));
      if (row % kTiltEvery == 0 && column % kTiltEvery == 0) {
        tilt_rays_.emplace_back(ray.cast<float>());
      }
      if (row % kEvery != 0 || column % kEvery != 0) continue;
      // Where the colour lens bends rays, the ray is bent with them, so that what follows is a
      // plain pinhole.
      Eigen::Vector3d turned = colour_R_depth * ray;
      if (is_distorted(lens) && turned.z() > 0.1) {
        const Eigen::Vector2d pixel = project(lens, turned);
        turned =
            turned.z() * Eigen::Vector3d((pixel.x() - lens.centre_x_px) / lens.focal_x_px,
                                         (pixel.y() - lens.centre_y_px) / lens.focal_y_px, 1.0);
      }
      colour_rays_.emplace_back(turned.cast<float>());
    }
  }
}

void FloorSight::assign(const InverseDepthImage& depth) {
  const std::size_t pixels = expected_.size();
  floor_.resize(pixels);
  const float* measured = depth.per_m.data();
  // The height of what was measured is height * (1 - expected / measured); times measured / height
  // that is their difference.
  for (std::size_t i = 0; i < pixels; ++i) {
    const float gate = noise_gate_per_m_ + height_gate_ * measured[i];
    const bool near = std::abs(measured[i] - expected_[i]) <= gate;
    const std::uint8_t seen = near ? kFloor : kOther;
    floor_[i] = measured[i] > 0.0F ? seen : kNothing;
  }
  measure_tilt(depth);
  mark_obstacles(depth);
}

void FloorSight::measure_tilt(const InverseDepthImage& depth) {
  // Least squares of (measured - expected) = change . ray over the floor's pixels.
  constexpr int kFewest = 200;
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  int points = 0;
  std::size_t ray = 0;
  for (int row = 0; row < height_; row += kTiltEvery) {
    const std::size_t first = static_cast<std::size_t>(row) * static_cast<std::size_t>(width_);
    for (int column = 0; column < width_; column += kTiltEvery, ++ray) {
      const std::size_t i = first + static_cast<std::size_t>(column);
      if (floor_[i] != kFloor) continue;
      const Eigen::Vector3d r = tilt_rays_[ray].cast<double>();
      normal.noalias() += r * r.transpose();
      right += static_cast<double>(depth.per_m[i] - expected_[i]) * r;
      ++points;
    }
  }
  tilt_rad_ = 0.0;
  if (points < kFewest) return;
  const Eigen::LDLT<Eigen::Matrix3d> factor(normal);
  if (factor.vectorD().minCoeff() < 1e-3 * points) return;
  tilt_rad_ = plane_height_m_ * factor.solve(right).head<2>().norm();
}

bool FloorSight::is_void(int column, int row) const {
  constexpr int kReach_px = 4;
  for (const int v : {row - kReach_px, row, row + kReach_px}) {
    for (const int u : {column - kReach_px, column, column + kReach_px}) {
      if (u < 0 || v < 0 || u >= width_ || v >= height_) continue;
      if (floor_[static_cast<std::size_t>(v) * static_cast<std::size_t>(width_) +
                 static_cast<std::size_t>(u)] != kNothing) {
        return false;
      }
    }
  }
  return true;
}

void FloorSight::mark_obstacles(const InverseDepthImage& depth) {
  marked_.assign(static_cast<std::size_t>(block_columns_) * static_cast<std::size_t>(block_rows_),
                 0);
  blocks_.assign(marked_.size(), 0);
  const auto mark = [&](const Eigen::Vector3f& ray, float per_m) {
    const Eigen::Vector3f p = ray + per_m * depth_in_colour_m_;
    if (p.z() < 0.1F) return;
    const float scale = 1.0F / p.z();
    const int u = static_cast<int>(focal_x_px_ * p.x() * scale + centre_x_px_) / kBlock;
    const int v = static_cast<int>(focal_y_px_ * p.y() * scale + centre_y_px_) / kBlock;
    if (u < 0 || v < 0 || u >= block_columns_ || v >= block_rows_) return;
    marked_[static_cast<std::size_t>(v) * static_cast<std::size_t>(block_columns_) +
            static_cast<std::size_t>(u)] = 1;
  };
  std::size_t ray = 0;
  for (int row = 0; row < height_; row += kEvery) {
    const std::size_t first = static_cast<std::size_t>(row) * static_cast<std::size_t>(width_);
    for (int column = 0; column < width_; column += kEvery, ++ray) {
      const std::size_t i = first + static_cast<std::size_t>(column);
      const float per_m = depth.per_m[i];
      // Only what is nearer than the floor can hide it; where no floor is expected (above the
      // horizon) all is.
      if (per_m > expected_[i] + noise_gate_per_m_ + height_gate_ * per_m) {
        mark(colour_rays_[ray], per_m);
      } else if (per_m == 0.0F && is_void(column, row)) {
        // Things nearer than the camera measures leave a hole. How near is unknown: all that they
        // may hide is hidden.
        for (float assumed = std::max(0.0F, expected_[i]); assumed < most_per_m_;
             assumed += void_step_per_m_) {
          mark(colour_rays_[ray], assumed);
        }
      }
    }
  }
  // The edges of things are uncertain by a few pixels: their neighbours are not trusted either.
  for (int v = 0; v < block_rows_; ++v) {
    for (int u = 0; u < block_columns_; ++u) {
      if (marked_[static_cast<std::size_t>(v) * static_cast<std::size_t>(block_columns_) +
                  static_cast<std::size_t>(u)] == 0) {
        continue;
      }
      for (int y = std::max(0, v - 1); y <= std::min(block_rows_ - 1, v + 1); ++y) {
        for (int x = std::max(0, u - 1); x <= std::min(block_columns_ - 1, u + 1); ++x) {
          blocks_[static_cast<std::size_t>(y) * static_cast<std::size_t>(block_columns_) +
                  static_cast<std::size_t>(x)] = 1;
        }
      }
    }
  }
}

}  // namespace loopstone
