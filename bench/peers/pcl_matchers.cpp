// PCL (https://pointclouds.org, BSD) on scans in the plane: ICP with its planar estimator, ICP with
// normals, and GICP.
//
// Points have z = 0. PCL's own covariances take the axis along which a neighbourhood is thinnest,
// which would be z, so GICP is given covariances that are thin across the wall, from the same
// neighbours.

#include <pcl/point_cloud.h>
#include <pcl/point_types.h>
#include <pcl/registration/gicp.h>
#include <pcl/registration/icp.h>
#include <pcl/registration/transformation_estimation_2D.h>
#include <pcl/search/kdtree.h>

#include <Eigen/Eigenvalues>

#include "../answers.hpp"

namespace {

using namespace loopstone::bench;
using loopstone::Pose2;
using Cloud = pcl::PointCloud<pcl::PointXYZ>;
using NormalCloud = pcl::PointCloud<pcl::PointNormal>;
using Gicp = pcl::GeneralizedIterativeClosestPoint<pcl::PointXYZ, pcl::PointXYZ>;

Cloud::Ptr cloud_of(const Points& points) {
  Cloud::Ptr cloud(new Cloud);
  for (const Eigen::Vector2d& p : points) {
    cloud->push_back({static_cast<float>(p.x()), static_cast<float>(p.y()), 0.0F});
  }
  return cloud;
}

Eigen::Matrix4f start_of(const Pose2& guess) {
  Eigen::Matrix4f start = Eigen::Matrix4f::Identity();
  start.topLeftCorner<2, 2>() = guess.rotation().cast<float>();
  start(0, 3) = static_cast<float>(guess.x);
  start(1, 3) = static_cast<float>(guess.y);
  return start;
}

template <typename Registration>
Answer answer_of(Registration& registration) {
  const Eigen::Matrix4f pose = registration.getFinalTransformation();
  return {{pose(0, 3), pose(1, 3), std::atan2(pose(1, 0), pose(0, 0))},
          registration.hasConverged()};
}

template <typename Registration>
void set_usual(Registration& registration, double max_distance_m) {
  registration.setMaxCorrespondenceDistance(max_distance_m);
  registration.setMaximumIterations(100);
  registration.setTransformationEpsilon(1e-8);  // of the squared step
}

/// The direction across the wall at each point.
std::vector<Eigen::Vector2d> normals_of(const Cloud::Ptr& cloud, int neighbours) {
  pcl::search::KdTree<pcl::PointXYZ> tree;
  tree.setInputCloud(cloud);
  std::vector<Eigen::Vector2d> normals;
  pcl::Indices indices;
  std::vector<float> squares;
  for (const pcl::PointXYZ& point : *cloud) {
    tree.nearestKSearch(point, neighbours, indices, squares);
    Eigen::Vector2d mean = Eigen::Vector2d::Zero();
    for (const auto i : indices) mean += Eigen::Vector2d((*cloud)[i].x, (*cloud)[i].y);
    mean /= static_cast<double>(indices.size());
    Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();
    for (const auto i : indices) {
      const Eigen::Vector2d offset = Eigen::Vector2d((*cloud)[i].x, (*cloud)[i].y) - mean;
      spread += offset * offset.transpose();
    }
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver;
    solver.computeDirect(spread);
    normals.emplace_back(solver.eigenvectors().col(0));
  }
  return normals;
}

Answer icp(const Points& target, const Points& source, const Pose2& guess, double max_distance_m) {
  pcl::IterativeClosestPoint<pcl::PointXYZ, pcl::PointXYZ> registration;
  registration.setTransformationEstimation(
      pcl::make_shared<
          pcl::registration::TransformationEstimation2D<pcl::PointXYZ, pcl::PointXYZ>>());
  set_usual(registration, max_distance_m);
  registration.setInputTarget(cloud_of(target));
  registration.setInputSource(cloud_of(source));
  Cloud aligned;
  registration.align(aligned, start_of(guess));
  return answer_of(registration);
}

Answer gicp(const Points& target, const Points& source, const Pose2& guess, int neighbours) {
  const auto covariances = [&](const Cloud::Ptr& cloud) {
    const Gicp::MatricesVectorPtr result(new Gicp::MatricesVector);
    for (const Eigen::Vector2d& normal : normals_of(cloud, neighbours)) {
      Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();
      covariance.topLeftCorner<2, 2>() -= (1.0 - 1e-3) * normal * normal.transpose();
      result->push_back(covariance);
    }
    return result;
  };
  const Cloud::Ptr target_cloud = cloud_of(target);
  const Cloud::Ptr source_cloud = cloud_of(source);
  Gicp registration;
  set_usual(registration, 1.0);
  registration.setTransformationEpsilon(1e-4);
  registration.setRotationEpsilon(1e-4);
  registration.setInputTarget(target_cloud);
  registration.setInputSource(source_cloud);
  registration.setTargetCovariances(covariances(target_cloud));
  registration.setSourceCovariances(covariances(source_cloud));
  Cloud aligned;
  registration.align(aligned, start_of(guess));
  return answer_of(registration);
}

}  // namespace

int main(int argc, char** argv) {
  const auto with_distance = [](double max_distance_m) {
    return [=](const PairToMatch& input) {
      return icp(input.target, input.source, input.pair.guess, max_distance_m);
    };
  };
  const auto with_neighbours = [](int neighbours) {
    return [=](const PairToMatch& input) {
      return gicp(input.target, input.source, input.pair.guess, neighbours);
    };
  };
  return answer_main(argc, argv, {{"icp_2d", with_distance(0.5)}, {"gicp", with_neighbours(10)}});
}
