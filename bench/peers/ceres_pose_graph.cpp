// Solves a pose graph with Ceres, for bench/pose_graphs.py:  ceres_pose_graph GRAPH.g2o
// The residual is g2o's, L^T e with Omega = L L^T, differentiated automatically;
// SPARSE_NORMAL_CHOLESKY with Levenberg-Marquardt, one thread. Prints one JSON object: cost (sum of
// e^T Omega e), CPU seconds of Solve(), steps.

#include <ceres/ceres.h>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

namespace {

struct Pose {
  double x[3] = {0.0, 0.0, 0.0};
};

template <typename T>
T wrapped(const T& angle) {
  const double pi = 3.14159265358979323846;
  return angle - T(2.0 * pi) * ceres::floor((angle + T(pi)) / T(2.0 * pi));
}

class EdgeResidual {
 public:
  EdgeResidual(const double* measured, const Eigen::Matrix3d& information)
      : x_(measured[0]), y_(measured[1]), yaw_(measured[2]) {
    const Eigen::LLT<Eigen::Matrix3d> llt(information);
    root_ = Eigen::Matrix3d(llt.matrixL()).transpose();
  }

  template <typename T>
  bool operator()(const T* from, const T* to, T* residual) const {
    const T angle = from[2] + T(yaw_);
    const T c = ceres::cos(angle);
    const T s = ceres::sin(angle);
    const T dx = to[0] - from[0];
    const T dy = to[1] - from[1];
    const double cz = std::cos(yaw_);
    const double sz = std::sin(yaw_);
    Eigen::Matrix<T, 3, 1> error;
    error(0) = c * dx + s * dy - T(cz * x_ + sz * y_);
    error(1) = -s * dx + c * dy - T(-sz * x_ + cz * y_);
    error(2) = wrapped(to[2] - from[2] - T(yaw_));
    Eigen::Map<Eigen::Matrix<T, 3, 1>> result(residual);
    result = root_.cast<T>() * error;
    return true;
  }

 private:
  double x_;
  double y_;
  double yaw_;
  Eigen::Matrix3d root_;
};

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  google::InitGoogleLogging(argv[0]);
  std::ifstream file(argv[1]);
  std::map<long, Pose> poses;
  ceres::Problem problem;
  std::string line;
  long first = -1;
  while (std::getline(file, line)) {
    std::istringstream words(line);
    std::string tag;
    words >> tag;
    if (tag == "VERTEX_SE2") {
      long id = 0;
      words >> id;
      Pose& pose = poses[id];
      words >> pose.x[0] >> pose.x[1] >> pose.x[2];
      if (first < 0) first = id;
    } else if (tag == "EDGE_SE2") {
      long from = 0;
      long to = 0;
      double z[3];
      double u[6];
      words >> from >> to >> z[0] >> z[1] >> z[2];
      for (double& value : u) words >> value;
      Eigen::Matrix3d information;
      information << u[0], u[1], u[2], u[1], u[3], u[4], u[2], u[4], u[5];
      problem.AddResidualBlock(
          new ceres::AutoDiffCostFunction<EdgeResidual, 3, 3, 3>(new EdgeResidual(z, information)),
          nullptr, poses[from].x, poses[to].x);
    }
  }
  problem.SetParameterBlockConstant(poses[first].x);
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  options.max_num_iterations = 200;
  options.function_tolerance = 1e-9;
  options.parameter_tolerance = 1e-12;
  options.num_threads = 1;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  const std::clock_t start = std::clock();
  ceres::Solve(options, &problem, &summary);
  const double seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  std::printf("{\"cost\": %.12g, \"seconds\": %.9g, \"steps\": %d}\n", 2.0 * summary.final_cost,
              seconds, static_cast<int>(summary.iterations.size()) - 1);
  return 0;
}
