#include "loopstone/graph/linearised_graph.hpp"

#include <cstddef>

#include "graph/descent.hpp"
#include "graph/gauge.hpp"
#include "graph/normal_equations.hpp"

namespace loopstone {

struct LinearisedGraph::Equations {
  NormalEquations normal;
};

LinearisedGraph::LinearisedGraph(const PoseGraph& graph, RobustKernel kernel, double kernel_width) {
  check_graph(graph);
  const Gauge gauge = gauge_of(graph, connected_components(graph));
  const RobustPolicy closures{.kernel = kernel, .width = kernel_width};
  equations_ =
      std::make_unique<Equations>(Equations{NormalEquations(graph, gauge.fixed, closures)});
}
LinearisedGraph::~LinearisedGraph() = default;
LinearisedGraph::LinearisedGraph(LinearisedGraph&&) noexcept = default;
LinearisedGraph& LinearisedGraph::operator=(LinearisedGraph&&) noexcept = default;

double LinearisedGraph::linearise(const GraphState& state) {
  return equations_->normal.linearise(state).robust;
}

const BlockMatrix& LinearisedGraph::hessian() const { return equations_->normal.hessian(); }

const std::vector<Eigen::Vector3d>& LinearisedGraph::gradient() const {
  return equations_->normal.gradient();
}

int LinearisedGraph::place_of(NodeId node) const {
  return equations_->normal.place_of(static_cast<std::size_t>(node.index));
}

int LinearisedGraph::place_of(LandmarkId landmark) const {
  return equations_->normal.place_of_landmark(static_cast<std::size_t>(landmark.index));
}

GraphState LinearisedGraph::moved(const GraphState& from,
                                  std::span<const Eigen::Vector3d> step) const {
  GraphState to = from;
  apply_step(from, equations_->normal, step, to);
  return to;
}

}  // namespace loopstone
