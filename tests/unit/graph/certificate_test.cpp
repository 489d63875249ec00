#include "loopstone/graph/certificate.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <complex>
#include <cstddef>
#include <utility>
#include <vector>

#include "graph/certificate_matrix.hpp"
#include "graph/certificate_verifier.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/graph/initial_poses.hpp"
#include "support/manhattan_graph.hpp"

namespace loopstone {
namespace {

using test::manhattan_graph;
using test::SimulatedGraph;

PoseGraph from_chordal(PoseGraph graph) {
  graph.poses = initial_poses(graph, Initialisation::kChordal);
  return graph;
}

/// A robot that drove a circle and came back, and a start in which it went round `turns` times.
PoseGraph ring(int nodes, int turns, double noise = 0.0) {
  PoseGraph graph;
  Rng rng(3);
  const double turn = 2.0 * kPi / nodes;
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  information.diagonal() << 100.0, 100.0, 400.0;
  for (int i = 0; i < nodes; ++i) {
    const Pose2 step{1.0 + rng.normal(0.0, noise), rng.normal(0.0, noise),
                     wrap_angle(turn + rng.normal(0.0, noise))};
    graph.edges.push_back({{i}, {(i + 1) % nodes}, step, information});
    const double heading = turns * turn * i;
    graph.poses.push_back({0.2 * std::cos(heading), 0.2 * std::sin(heading), wrap_angle(heading)});
  }
  return graph;
}

/// S of the definition, without any sparsity: the whole quadratic form over positions and headings,
/// the positions eliminated by a pseudoinverse.
Eigen::MatrixXcd dense_certificate(const PoseGraph& graph) {
  using Complex = std::complex<double>;
  const auto n = static_cast<Eigen::Index>(graph.poses.size());
  Eigen::MatrixXcd form = Eigen::MatrixXcd::Zero(2 * n, 2 * n);
  for (const RelativePoseEdge& edge : graph.edges) {
    const Eigen::Index i = edge.from.index;
    const Eigen::Index j = edge.to.index;
    const Eigen::Matrix2d covariance =
        edge.information.topLeftCorner<2, 2>().llt().solve(Eigen::Matrix2d::Identity());
    Eigen::RowVectorXcd row = Eigen::RowVectorXcd::Zero(2 * n);
    row(j) = 1.0;
    row(i) = -1.0;
    row(n + i) = -Complex(edge.from_T_to.x, edge.from_T_to.y);
    form += 2.0 / covariance.trace() * row.adjoint() * row;
    row.setZero();
    row(n + j) = 1.0;
    row(n + i) = -std::polar(1.0, edge.from_T_to.yaw);
    form += 2.0 * edge.information(2, 2) * row.adjoint() * row;
  }
  const Eigen::MatrixXcd positions = form.topLeftCorner(n, n);
  const Eigen::MatrixXcd across = form.topRightCorner(n, n);
  const Eigen::MatrixXcd q =
      form.bottomRightCorner(n, n) -
      across.adjoint() * positions.completeOrthogonalDecomposition().pseudoInverse() * across;
  Eigen::VectorXcd z(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    z(i) = std::polar(1.0, graph.poses[static_cast<std::size_t>(i)].yaw);
  }
  const Eigen::VectorXcd qz = q * z;
  Eigen::MatrixXcd s = q;
  for (Eigen::Index i = 0; i < n; ++i) s(i, i) -= (std::conj(z(i)) * qz(i)).real();
  return s;
}

double smallest_dense_eigenvalue(const PoseGraph& graph) {
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXcd>(dense_certificate(graph)).eigenvalues()(0);
}

TEST(Certificate, EigenvalueIsThatOfTheDenseMatrix) {
  // At a point that is no minimum, at a local one, and at the optimum.
  const SimulatedGraph world = manhattan_graph({.nodes = 60, .blocks = 2}, Rng(1));
  const Certificate rough = verify_optimality(world.graph);
  const double wanted = smallest_dense_eigenvalue(world.graph);
  EXPECT_EQ(rough.status, CertificateStatus::kNotOptimal);
  EXPECT_LT(wanted, -1e-3);
  EXPECT_NEAR(rough.min_eigenvalue, wanted, 1e-5 * std::abs(wanted));

  PoseGraph wound = ring(24, 2, 0.02);
  wound.poses = optimize_certified(wound, {.max_rank = 1}).poses;
  const Certificate local = verify_optimality(wound);
  EXPECT_EQ(local.status, CertificateStatus::kNotOptimal);
  EXPECT_NEAR(local.min_eigenvalue, smallest_dense_eigenvalue(wound),
              1e-5 * std::abs(local.min_eigenvalue));

  PoseGraph solved = from_chordal(world.graph);
  solved.poses = optimize_certified(solved).poses;
  EXPECT_NEAR(verify_optimality(solved).min_eigenvalue, smallest_dense_eigenvalue(solved), 1e-6);
}

TEST(Certificate, CostIsThatOfTheDefinition) {
  const SimulatedGraph world = manhattan_graph({.nodes = 60, .blocks = 2}, Rng(2));
  double cost = 0.0;
  for (const RelativePoseEdge& edge : world.graph.edges) {
    const Pose2& from = world.graph.poses[static_cast<std::size_t>(edge.from.index)];
    const Pose2& to = world.graph.poses[static_cast<std::size_t>(edge.to.index)];
    const auto rotation = [](double yaw) { return Eigen::Rotation2Dd(yaw).toRotationMatrix(); };
    const Eigen::Matrix2d covariance =
        edge.information.topLeftCorner<2, 2>().llt().solve(Eigen::Matrix2d::Identity());
    cost +=
        edge.information(2, 2) *
            (rotation(to.yaw) - rotation(from.yaw) * rotation(edge.from_T_to.yaw)).squaredNorm() +
        2.0 / covariance.trace() *
            (to.translation() - from.translation() -
             rotation(from.yaw) * edge.from_T_to.translation())
                .squaredNorm();
  }
  EXPECT_NEAR(isotropic_cost(world.graph), cost, 1e-9 * cost);
}

TEST(Certificate, AcceptsTheOptimumAndBoundsEveryOtherSolution) {
  const SimulatedGraph world = manhattan_graph({.nodes = 400, .blocks = 3}, Rng(3));
  const CertifiedSolution solution = optimize_certified(from_chordal(world.graph));
  const Certificate& certificate = solution.certificate;
  ASSERT_EQ(certificate.status, CertificateStatus::kCertified);
  EXPECT_EQ(solution.rank, 1);
  EXPECT_LE(certificate.optimality_gap, 1e-7 * certificate.cost);
  EXPECT_GT(certificate.min_eigenvalue, -certificate.eigenvalue_tolerance);
  PoseGraph truth = world.graph;
  truth.poses = world.truth;
  EXPECT_LT(certificate.lower_bound, isotropic_cost(truth));
  PoseGraph solved = world.graph;
  solved.poses = solution.poses;
  EXPECT_NEAR(isotropic_cost(solved), certificate.cost, 1e-12 * certificate.cost);
  EXPECT_EQ(solution.poses.front(), world.graph.poses.front());
}

TEST(Certificate, RejectsARingWoundOnceTooOftenAndUnwindsIt) {
  for (const double noise : {0.0, 0.02}) {
    const PoseGraph wound = ring(30, 2, noise);
    const CertifiedSolution stuck = optimize_certified(wound, {.max_rank = 1});
    EXPECT_EQ(stuck.certificate.status, CertificateStatus::kNotOptimal);
    EXPECT_LT(stuck.certificate.min_eigenvalue, -1.0);
    EXPECT_GT(stuck.certificate.cost, 100.0);
    const CertifiedSolution free = optimize_certified(wound);
    EXPECT_EQ(free.certificate.status, CertificateStatus::kCertified);
    EXPECT_GE(free.escapes, 1);
    EXPECT_GE(free.rank, 2);
    EXPECT_LT(free.certificate.cost, noise == 0.0 ? 1e-9 : 20.0);
    const CertifiedSolution direct = optimize_certified(from_chordal(wound));
    EXPECT_NEAR(free.certificate.cost, direct.certificate.cost,
                1e-6 * direct.certificate.cost + 1e-9);
    // The bound of the local minimum is a bound, if a poor one.
    EXPECT_LE(stuck.certificate.lower_bound, free.certificate.cost + 1e-9);
  }
}

TEST(Certificate, FindsTheOptimumFromRandomHeadings) {
  const SimulatedGraph world = manhattan_graph({.nodes = 120, .blocks = 2}, Rng(4));
  const double optimum = optimize_certified(from_chordal(world.graph)).certificate.cost;
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    Rng rng(seed);
    PoseGraph graph = world.graph;
    for (std::size_t i = 1; i < graph.poses.size(); ++i)
      graph.poses[i].yaw = rng.uniform(-kPi, kPi);
    const CertifiedSolution solution = optimize_certified(graph);
    EXPECT_EQ(solution.certificate.status, CertificateStatus::kCertified) << seed;
    EXPECT_NEAR(solution.certificate.cost, optimum, 1e-6 * optimum) << seed;
  }
}

TEST(Certificate, VerdictDoesNotDependOnTheFrameOrTheOrderOfEdges) {
  const SimulatedGraph world = manhattan_graph({.nodes = 150, .blocks = 2}, Rng(5));
  const PoseGraph start = from_chordal(world.graph);
  const CertifiedSolution here = optimize_certified(start);
  PoseGraph moved = start;
  const Pose2 other_T_map{30.0, -20.0, 2.5};
  for (Pose2& pose : moved.poses) pose = other_T_map * pose;
  std::reverse(moved.edges.begin(), moved.edges.end());
  const CertifiedSolution there = optimize_certified(moved);
  EXPECT_EQ(here.certificate.status, CertificateStatus::kCertified);
  EXPECT_EQ(there.certificate.status, CertificateStatus::kCertified);
  EXPECT_NEAR(there.certificate.cost, here.certificate.cost, 1e-9 * here.certificate.cost);
  for (std::size_t i = 0; i < here.poses.size(); ++i) {
    const Pose2 expected = other_T_map * here.poses[i];
    EXPECT_NEAR((there.poses[i].translation() - expected.translation()).norm(), 0.0, 1e-6);
  }
  // The same for a verdict of no.
  PoseGraph wound = ring(30, 2, 0.02);
  wound.poses = optimize_certified(wound, {.max_rank = 1}).poses;
  PoseGraph wound_moved = wound;
  for (Pose2& pose : wound_moved.poses) pose = other_T_map * pose;
  std::reverse(wound_moved.edges.begin(), wound_moved.edges.end());
  const double eigenvalue = verify_optimality(wound).min_eigenvalue;
  EXPECT_NEAR(verify_optimality(wound_moved).min_eigenvalue, eigenvalue,
              1e-5 * std::abs(eigenvalue));
}

TEST(Certificate, LandmarksAndPriorsArePartOfTheProblem) {
  SimulatedGraph world = manhattan_graph({.nodes = 100, .blocks = 2}, Rng(6));
  Rng rng(7);
  PoseGraph graph = world.graph;
  for (int k = 0; k < 6; ++k) {
    const Eigen::Vector2d landmark(rng.uniform(-6.0, 6.0), rng.uniform(-6.0, 6.0));
    graph.landmarks.emplace_back(0.0, 0.0);
    for (int i = k; i < 100; i += 7) {
      const Eigen::Vector2d seen = world.truth[static_cast<std::size_t>(i)].inverse() * landmark;
      graph.landmark_edges.push_back(
          {{i},
           {k},
           seen + Eigen::Vector2d(rng.normal(0.0, 0.01), rng.normal(0.0, 0.01)),
           1e4 * Eigen::Matrix2d::Identity()});
    }
  }
  const CertifiedSolution floating = optimize_certified(from_chordal(graph));
  EXPECT_EQ(floating.certificate.status, CertificateStatus::kCertified);
  EXPECT_GT(floating.certificate.cost,
            optimize_certified(from_chordal(world.graph)).certificate.cost);

  for (const int node : {20, 80}) {
    graph.priors.push_back(
        {{node}, world.truth[static_cast<std::size_t>(node)], 1e3 * Eigen::Matrix3d::Identity()});
  }
  const CertifiedSolution placed = optimize_certified(from_chordal(graph));
  EXPECT_EQ(placed.certificate.status, CertificateStatus::kCertified);
  EXPECT_GE(placed.certificate.cost, floating.certificate.cost);
  for (std::size_t i = 0; i < placed.poses.size(); ++i) {
    EXPECT_LT((placed.poses[i].translation() - world.truth[i].translation()).norm(), 0.2) << i;
  }
  EXPECT_EQ(placed.landmarks.size(), 6U);
}

TEST(Certificate, ComponentsAreProvenTogether) {
  PoseGraph graph = ring(30, 2, 0.02);
  const PoseGraph second = ring(20, 1, 0.02);
  for (const Pose2& pose : second.poses) graph.poses.push_back(pose);
  for (RelativePoseEdge edge : second.edges) {
    edge.from.index += 30;
    edge.to.index += 30;
    graph.edges.push_back(edge);
  }
  graph.poses.push_back({5.0, 5.0, 1.0});  // without any edge
  const CertifiedSolution solution = optimize_certified(graph);
  EXPECT_EQ(solution.certificate.status, CertificateStatus::kCertified);
  const double apart = optimize_certified(from_chordal(ring(30, 1, 0.02))).certificate.cost +
                       optimize_certified(from_chordal(second)).certificate.cost;
  EXPECT_NEAR(solution.certificate.cost, apart, 1e-6 * apart);
  EXPECT_NEAR(solution.poses.back().yaw, 1.0, 1e-12);
}

TEST(Certificate, SaysWhatItCannotProve) {
  PoseGraph graph = ring(10, 1);
  graph.fixed = {{0}, {5}};
  EXPECT_EQ(verify_optimality(graph).status, CertificateStatus::kUnsupported);
  EXPECT_EQ(optimize_certified(graph).certificate.status, CertificateStatus::kUnsupported);
  EXPECT_EQ(optimize_certified(graph).poses, graph.poses);
  graph.fixed = {{5}};
  EXPECT_TRUE(optimize_certified(graph).certificate.certified());
  EXPECT_EQ(optimize_certified(graph).poses[5], graph.poses[5]);
  EXPECT_TRUE(optimize_certified({}).certificate.certified());
  graph.edges.front().information.setZero();
  EXPECT_THROW((void)optimize_certified(graph), UsageError);
}

TEST(Certificate, GivesTheSameBytesAgain) {
  const SimulatedGraph world = manhattan_graph({.nodes = 100, .blocks = 2}, Rng(8));
  const CertifiedSolution first = optimize_certified(world.graph);
  const CertifiedSolution second = optimize_certified(world.graph);
  EXPECT_EQ(first.poses, second.poses);
  EXPECT_EQ(first.certificate.min_eigenvalue, second.certificate.min_eigenvalue);
}

}  // namespace
}  // namespace loopstone
