#pragma once

#include <cstddef>

#include "loopstone/formats/g2o.hpp"
#include "loopstone/graph/certificate.hpp"
#include "loopstone/graph/initial_poses.hpp"
#include "loopstone/graph/outlier_rejection.hpp"
#include "loopstone/graph/solver.hpp"
#include "refusal.hpp"

// What every target does with a pose graph that could be read.
namespace loopstone::fuzz {

/// Solves it in the ways of `loopstone optimize`, in few steps, when it is small.
inline void solve_graph(GraphFile file) {
  constexpr std::size_t kMostNodes = 100;
  constexpr std::size_t kMostEdges = 300;
  constexpr int kSteps = 10;
  if (!goes_on()) return;
  PoseGraph& graph = file.graph;
  require_connected(file, "graph");
  if (graph.poses.size() > kMostNodes || graph.edges.size() > kMostEdges) return;
  SolverOptions solver;
  solver.max_iterations = kSteps;
  (void)optimize(graph, solver);  // from where the file has the poses
  GraphStart start = best_start(graph, file.has_poses);
  graph.poses = std::move(start.poses);
  graph.landmarks = std::move(start.landmarks);
  (void)optimize(graph, solver);
  GncOptions gnc;
  gnc.max_rounds = kSteps;
  (void)optimize_gnc(graph, gnc, solver);
  CertificateOptions certificate;
  certificate.max_iterations = kSteps;
  (void)optimize_certified(graph, certificate);
}

}  // namespace loopstone::fuzz
