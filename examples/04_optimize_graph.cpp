// A pose graph by hand: a robot drives round a square, its odometry drifts, one loop closure puts
// it right. What `loopstone optimize --certify` does is one call.
#include <cmath>
#include <cstdio>

#include "loopstone/geometry/angle.hpp"
#include "loopstone/graph/optimize_graph.hpp"

using namespace loopstone;

int main() {
  // The truth: 40 steps of 1 m, a left turn after every ten.
  const auto true_step = [](int i) { return Pose2{1.0, 0.0, i % 10 == 9 ? kPi / 2 : 0.0}; };
  // What odometry says: 2 % too far, and half a degree to the left each step.
  const Pose2 drift{0.02, 0.0, radians(0.5)};

  PoseGraph graph;
  graph.poses.push_back(Pose2{});
  for (int i = 0; i < 40; ++i) {
    RelativePoseEdge edge{NodeId{i}, NodeId{i + 1}, true_step(i) * drift};
    edge.information = Eigen::Vector3d(0.03, 0.03, 0.01).cwiseAbs2().cwiseInverse().asDiagonal();
    edge.kind = EdgeKind::kOdometry;
    graph.poses.push_back(graph.poses.back() * edge.from_T_to);
    graph.edges.push_back(edge);
  }
  const Pose2 before = graph.poses.back();

  // The last pose is the first again, says the laser: to 1 cm and half a degree.
  RelativePoseEdge closure{NodeId{0}, NodeId{40}, Pose2{}};
  closure.information = Eigen::Vector3d(0.01, 0.01, 0.01).cwiseAbs2().cwiseInverse().asDiagonal();
  closure.kind = EdgeKind::kLoopClosure;
  graph.edges.push_back(closure);

  GraphOptimisationOptions options;
  options.start = Initialisation::kAsGiven;            // without it: the cheapest of several
  options.certificate = CertificateOptions{};          // prove that the minimum is the global one
  options.solver.robust_kernel = RobustKernel::kNone;  // options.gnc finds false closures
  const GraphOptimisation found = optimize_graph(graph, options);
  const SolveResult& solved = found.solved;
  const Pose2& after = solved.poses.back();
  const Pose2& corner = solved.poses[20];

  std::printf("status               %s in %d iterations, %s\n", to_string(solved.status).data(),
              found.iterations(), to_string(found.certified->certificate.status).data());
  std::printf("cost                 %.1f -> %.2f (sum of e^T Omega e)\n", solved.cost_initial,
              solved.cost);
  std::printf("gap at the start     %.3f m -> %.3f m\n", std::hypot(before.x, before.y),
              std::hypot(after.x, after.y));
  std::printf("corner, true (10,10) (%.2f, %.2f) -> (%.2f, %.2f)\n", graph.poses[20].x,
              graph.poses[20].y, corner.x, corner.y);
  const bool closed = std::hypot(after.x, after.y) < 0.02;
  const bool proven = found.certified->certificate.certified();
  return solved.status == SolveStatus::kConverged && closed && proven ? 0 : 1;
}
