#pragma once

#include <initializer_list>
#include <string_view>
#include <vector>

namespace loopstone {

/// The closed interval of values that an option may take.
struct Range {
  double lowest;
  double highest;
};

/// The words that a text option may take.
struct OneOf {
  std::vector<std::string_view> words;
};

// How option structs are described, once, beside the struct:
//
//   struct IcpOptions {
//     double max_pair_distance_m = 0.5;
//     int max_iterations = 50;
//   };
//
//   template <typename Visitor>
//   void visit_options(IcpOptions& options, Visitor&& visit) {
//     visit("max_pair_distance_m", options.max_pair_distance_m, Range{0.001, 100.0},
//           "pairs farther apart are ignored");
//     visit("max_iterations", options.max_iterations, Range{1, 1000}, "stop after so many steps");
//   }
//
// Fields are bool (no rule argument: visit(name, field, help)), int, double (Range) or std::string
// (OneOf). The struct's initialisers are the only place where defaults stand; files, flags, help
// texts and the written options.toml all go through visit_options. Nested groups call
// visit.group("icp", options.icp).

}  // namespace loopstone
