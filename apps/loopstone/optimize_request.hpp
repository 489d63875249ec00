#pragma once

#include <string>

#include "loopstone/graph/optimize_graph.hpp"

namespace loopstone::app {

/// What --set reaches.
struct OptimizeSettings {
  SolverOptions solver{};
  GncOptions gnc{};
  CertificateOptions certificate{};
};

template <typename Visitor>
void visit_options(OptimizeSettings& options, Visitor&& visit) {
  visit.group("solver", options.solver);
  visit.group("gnc", options.gnc);
  visit.group("certificate", options.certificate);
}

/// What the user asked for, in words.
struct OptimizeRequest {
  std::string initial = "best";  ///< or file, odometry, spanning_tree, chordal
  bool gnc = false;              ///< graduated non-convexity instead of the solver's kernel
  bool certify = false;
  OptimizeSettings settings{};

  /// "none", a kernel, or "gnc".
  [[nodiscard]] std::string robust() const { return gnc ? "gnc" : settings.solver.robust_kernel; }
};

}  // namespace loopstone::app
