#pragma once

#include <string_view>

#include "loopstone/base/words.hpp"

namespace loopstone {

/// The closed interval of values that an option may take.
struct Range {
  double lowest;
  double highest;
};

// How option structs are described, once, beside the struct:
//
//   struct IcpOptions {
//     IcpMetric metric = IcpMetric::kPlane;
//     double max_pair_distance_m = 0.5;
//     int max_iterations = 50;
//   };
//
//   template <typename Visitor>
//   void visit_options(IcpOptions& options, Visitor&& visit) {
//     visit("metric", options.metric, "what is made small");
//     visit("max_pair_distance_m", options.max_pair_distance_m, Range{0.001, 100.0},
//           "pairs farther apart are ignored");
//     visit("max_iterations", options.max_iterations, Range{1, 1000}, "stop after so many steps");
//   }
//
// Fields are int or double with their Range, or without a rule bool, std::string, or an enum, whose
// words (base/words.hpp) are its rule: visit(name, field, help). The struct's initialisers are the
// only place where defaults stand, and the help text is the only place that says what a field
// means; files, flags, help texts and the written options.toml all go through visit_options. Nested
// groups call visit.group("icp", options.icp).

}  // namespace loopstone
