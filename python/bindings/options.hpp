#pragma once

#include <string>
#include <utility>
#include <vector>

#include "loopstone/base/option_list.hpp"
#include "loopstone/formats/options_file.hpp"
#include "loopstone/graph/certificate.hpp"
#include "loopstone/graph/outlier_rejection.hpp"
#include "loopstone/graph/solver.hpp"

namespace loopstone::python {

/// What somebody wants to be other than by default: of a file, and beyond it.
struct OptionValues {
  std::string file{};  ///< of TOML; empty: none
  std::vector<std::pair<std::string, std::string>> values{};
};

/// Throws OptionsError with all problems at once.
void set_options(const std::vector<OptionEntry>& options, const OptionValues& given);

template <typename Options>
[[nodiscard]] Options options_of(const OptionValues& given) {
  Options options;
  set_options(list_options(options), given);
  return options;
}

/// Every option of loopstone.optimize(): those of `loopstone optimize --set`.
struct OptimizeOptions {
  SolverOptions solver{};
  GncOptions gnc{};
  CertificateOptions certificate{};
};

template <typename Visitor>
void visit_options(OptimizeOptions& options, Visitor&& visit) {
  visit.group("solver", options.solver);
  visit.group("gnc", options.gnc);
  visit.group("certificate", options.certificate);
}

}  // namespace loopstone::python
