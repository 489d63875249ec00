#pragma once

#include <optional>
#include <string>

#include "app.hpp"
#include "loopstone/registration/cloud_search.hpp"
#include "loopstone/registration/field_match.hpp"
#include "loopstone/registration/grid_matcher.hpp"
#include "loopstone/registration/icp.hpp"
#include "loopstone/registration/icp_guess.hpp"
#include "loopstone/registration/map_match.hpp"
#include "loopstone/registration/match_sweep.hpp"
#include "loopstone/registration/scan_matcher.hpp"

namespace loopstone::app {

/// Options of every matcher that the command can call.
template <int kDimension>
struct MatchSettings {
  IcpOptions icp{};
  IcpCloudOptions<kDimension> icp_cloud{};
  CloudSearchOptions cloud_search{};
  ScanMatchOptions scans{};
  MapSearchOptions map{};
  MapMatchOptions map_match{};
  FieldMatchOptions field{};
  GridMatchOptions grid{};
};

template <int kDimension, typename Visitor>
void visit_options(MatchSettings<kDimension>& options, Visitor&& visit) {
  visit.group("icp", options.icp);
  visit.group("icp_cloud", options.icp_cloud);
  visit.group("cloud_search", options.cloud_search);
  visit.group("scans", options.scans);
  visit.group("map", options.map);
  visit.group("map_match", options.map_match);
  visit.group("field", options.field);
  visit.group("grid", options.grid);
}

/// What the user asked for, in words of the library.
template <int kDimension>
struct MatchRequest {
  using Pose = typename RigidMotion<kDimension>::Pose;

  std::string method = "auto";
  std::string target_name{};      ///< for messages
  std::optional<Pose> initial{};  ///< of target_T_source
  bool from_centroids = false;    ///< --initial centroids
  std::optional<double> search_xy_m{};
  std::optional<double> search_yaw_rad{};
  bool global = false;
  int sweep_yaw = 0;
  Threads threads{1};

  [[nodiscard]] bool searches() const { return search_xy_m || search_yaw_rad; }
};

/// What came of it.
template <int kDimension>
struct MatchOutcome {
  using Pose = typename RigidMotion<kDimension>::Pose;

  BasicMatchResult<kDimension> match{};
  Pose guess{};        ///< that the match began at
  std::string method;  ///< that gave the answer
  CloudExtent<kDimension> source{};
  std::optional<SweepResult<kDimension>> sweep{};
  std::optional<CloudSearchResult<kDimension>> search{};
  std::optional<MapMatch> map_match{};  ///< poses of the robot
  double wall_time_s = 0.0;             ///< preparation of the target included, reading not
};

}  // namespace loopstone::app
