#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "loopstone/registration/align.hpp"

namespace loopstone::app {

/// The flags of `loopstone match`, as they were typed.
struct MatchArguments {
  std::string source;
  std::string target;
  AlignMethod method = AlignMethod::kAuto;
  std::string initial;
  std::string target_pose;
  std::optional<double> search_xy_m;
  std::optional<double> search_yaw_rad;
  bool global = false;
  int sweep_yaw = 0;
  double source_scale = 1.0;
  double target_scale = 1.0;
  std::string png;
  std::string aligned;
  std::vector<std::string> require;
  bool force = false;
};

/// All but those that several commands have, and what the help ends with.
void add_match_flags(CLI::App& command, MatchArguments& arguments);

/// Throws UsageError for what can't be meant, before anything is read.
void check_match_usage(const MatchArguments& arguments);

/// In words of the library. Throws UsageError for a guess that is no pose of the plane or of space.
template <int kDimension>
[[nodiscard]] AlignRequest<kDimension> match_request(const MatchArguments& arguments,
                                                     Threads threads);

extern template AlignRequest<2> match_request<2>(const MatchArguments&, Threads);
extern template AlignRequest<3> match_request<3>(const MatchArguments&, Threads);

}  // namespace loopstone::app
