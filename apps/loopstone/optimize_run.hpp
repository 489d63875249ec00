#pragma once

#include <string>

#include "loopstone/formats/g2o.hpp"
#include "loopstone/graph/certificate.hpp"
#include "loopstone/graph/outlier_rejection.hpp"
#include "loopstone/graph/solver.hpp"
#include "loopstone/report/graph_report.hpp"

namespace loopstone::app {

/// Options of `loopstone optimize`.
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

struct OptimizeRequest {
  std::string initial = "best";  ///< or file, odometry, spanning_tree, chordal
  bool gnc = false;              ///< graduated non-convexity instead of the solver's kernel
  bool certify = false;
  OptimizeSettings settings{};

  /// "none", a kernel, or "gnc".
  [[nodiscard]] std::string robust() const { return gnc ? "gnc" : settings.solver.robust_kernel; }
};

/// Start, certified minimum when it is asked for, solution. Throws UsageError for a start that the file does not have.
[[nodiscard]] GraphRun optimize_file(GraphFile file, const OptimizeRequest& request);

}  // namespace loopstone::app
