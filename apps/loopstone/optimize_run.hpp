#pragma once

#include <string>

#include "loopstone/formats/g2o.hpp"
#include "loopstone/graph/certificate.hpp"
#include "loopstone/graph/solver.hpp"
#include "loopstone/report/graph_report.hpp"

namespace loopstone::app {

/// Options of `loopstone optimize`.
struct OptimizeSettings {
  SolverOptions solver{};
  CertificateOptions certificate{};
};

template <typename Visitor>
void visit_options(OptimizeSettings& options, Visitor&& visit) {
  visit.group("solver", options.solver);
  visit.group("certificate", options.certificate);
}

struct OptimizeRequest {
  std::string initial = "best";  ///< or file, odometry, spanning_tree, chordal
  bool certify = false;
  OptimizeSettings settings{};
};

/// Start, certified minimum when it is asked for, solution. Throws UsageError for a start that the file does not have.
[[nodiscard]] GraphRun optimize_file(GraphFile file, const OptimizeRequest& request);

}  // namespace loopstone::app
