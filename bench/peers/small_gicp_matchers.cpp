// small_gicp (https://github.com/koide3/small_gicp, MIT) on scans in the plane.
//
// Points have z = 0, and roll, pitch and z are held by its own RestrictDoFFactor. Its estimate of
// normals takes the axis along which a neighbourhood is thinnest, which would be z; here it is the
// thinnest within the plane.

#include <small_gicp/ann/kdtree.hpp>
#include <small_gicp/factors/gicp_factor.hpp>
#include <small_gicp/factors/icp_factor.hpp>
#include <small_gicp/factors/plane_icp_factor.hpp>
#include <small_gicp/points/point_cloud.hpp>
#include <small_gicp/registration/reduction.hpp>
#include <small_gicp/registration/registration.hpp>
#include <small_gicp/util/normal_estimation.hpp>

#include "../answers.hpp"

namespace {

using namespace loopstone::bench;
using loopstone::Pose2;
using small_gicp::PointCloud;
using Tree = small_gicp::UnsafeKdTree<PointCloud>;

/// Eigenvectors come in the order of their eigenvalues: z, across the wall, along it.
struct PlanarSetter {
  static void set_invalid(PointCloud& cloud, std::size_t i) {
    small_gicp::NormalCovarianceSetter<PointCloud>::set_invalid(cloud, i);
  }
  static void set(PointCloud& cloud, std::size_t i, const Eigen::Matrix3d& eigenvectors) {
    Eigen::Matrix3d reordered = eigenvectors;
    reordered.col(0) = eigenvectors.col(1);
    reordered.col(1) = eigenvectors.col(0);
    small_gicp::NormalCovarianceSetter<PointCloud>::set(cloud, i, reordered);
  }
};

PointCloud cloud_of(const Points& points) {
  PointCloud cloud;
  cloud.resize(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    cloud.point(i) = {points[i].x(), points[i].y(), 0.0, 1.0};
  }
  return cloud;
}

template <typename Factor>
Answer align(const Points& target_points, const Points& source_points, const Pose2& guess,
             int neighbours, bool source_features, double max_distance_m) {
  PointCloud target = cloud_of(target_points);
  PointCloud source = cloud_of(source_points);
  const Tree target_tree(target);
  if (neighbours > 0) {
    small_gicp::estimate_local_features<PlanarSetter>(target, target_tree, neighbours);
  }
  if (source_features) {
    const Tree source_tree(source);
    small_gicp::estimate_local_features<PlanarSetter>(source, source_tree, neighbours);
  }
  small_gicp::Registration<Factor, small_gicp::SerialReduction, small_gicp::RestrictDoFFactor>
      registration;
  registration.general_factor.set_rotation_mask({0.0, 0.0, 1.0});
  registration.general_factor.set_translation_mask({1.0, 1.0, 0.0});
  registration.rejector.max_dist_sq = max_distance_m * max_distance_m;
  registration.optimizer.max_iterations = 100;
  Eigen::Isometry3d start = Eigen::Isometry3d::Identity();
  start.translation() = Eigen::Vector3d(guess.x, guess.y, 0.0);
  start.rotate(Eigen::AngleAxisd(guess.yaw, Eigen::Vector3d::UnitZ()));
  const auto result = registration.align(target, source, target_tree, start);
  const Eigen::Isometry3d& pose = result.T_target_source;
  return {{pose.translation().x(), pose.translation().y(),
           std::atan2(pose.linear()(1, 0), pose.linear()(0, 0))},
          result.converged};
}

template <typename Factor>
Matcher matcher(int neighbours, bool source_features, double max_distance_m) {
  return [=](const PairToMatch& input) {
    return align<Factor>(input.target, input.source, input.pair.guess, neighbours, source_features,
                         max_distance_m);
  };
}

}  // namespace

int main(int argc, char** argv) {
  using small_gicp::GICPFactor;
  using small_gicp::ICPFactor;
  using small_gicp::PointToPlaneICPFactor;
  return answer_main(argc, argv,
                     {{"gicp_k5", matcher<GICPFactor>(5, true, 1.0)},
                      {"gicp_k10", matcher<GICPFactor>(10, true, 1.0)},
                      {"plane_icp", matcher<PointToPlaneICPFactor>(5, false, 1.0)},
                      {"icp", matcher<ICPFactor>(0, false, 0.5)}});
}
