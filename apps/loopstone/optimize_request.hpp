#pragma once

#include <optional>
#include <string_view>

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

/// What the user asked for.
struct OptimizeRequest {
  std::optional<Initialisation> initial{};  ///< none: the cheapest
  bool gnc = false;  ///< graduated non-convexity instead of the solver's kernel
  bool certify = false;
  OptimizeSettings settings{};

  /// "none", a kernel, or "gnc".
  [[nodiscard]] std::string_view robust() const {
    return gnc ? "gnc" : to_string(settings.solver.robust_kernel);
  }
};

}  // namespace loopstone::app
