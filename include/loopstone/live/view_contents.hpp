#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "loopstone/base/stamp.hpp"
#include "loopstone/geometry/pose2.hpp"
#include "loopstone/slam/loop_closure.hpp"
#include "loopstone/slam/mapped_scan.hpp"
#include "loopstone/slam/submap_record.hpp"

// What a view shows, as values. All poses are on the map.

namespace loopstone {

/// A key scan on the path.
struct ViewNode {
  Stamp stamp{};
  Pose2 map_T_robot{};
  double sigma_m = 0.0;  ///< larger half-axis of the position's covariance
  std::uint32_t submap = 0;
  std::uint32_t drive = 0;
  friend bool operator==(const ViewNode&, const ViewNode&) = default;
};

/// A closure, what it joins and what it was measured by. Its id is its place in the list.
struct ViewClosure {
  LoopClosure closure{};
  std::size_t from_node = 0;  ///< among the ViewNodes
  std::size_t to_node = 0;
  Stamp from{};
  Stamp to{};
  Pose2 from_T_to{};  ///< as the graph has it now
  /// Null where a scan is not at hand.
  std::shared_ptr<const MappedScan> from_scan{};
  std::shared_ptr<const MappedScan> to_scan{};
};

struct ViewSubmap {
  std::size_t id = 0;
  SubmapState state = SubmapState::kOpen;
  Pose2 map_T_submap{};
  std::vector<Eigen::Vector2f> outline{};  ///< about what was seen from near by; closed, map frame
};

struct ViewStatus {
  Stamp stamp{};
  std::string status{};
  std::int64_t scans = 0;
  double travelled_m = 0.0;
  std::size_t submaps = 0;
  std::size_t closures = 0;  ///< that stand
  std::size_t rejected = 0;
  double map_m2 = 0.0;
  double realtime = 0.0;  ///< so many times the recording's own pace
  double memory_mb = 0.0;
  std::map<std::string, double> figures{};  ///< to be plotted, by name with unit
};

struct ViewPlace {
  Eigen::Vector2d where = Eigen::Vector2d::Zero();
  std::string text{};
};
struct ViewVerdict {
  std::string verdict{};  ///< empty: not judged
  std::string sentence{};
  std::vector<std::string> reasons{};
  bool complete = false;
  std::vector<ViewPlace> places{};
};

struct ViewWarning {
  std::optional<Stamp> when{};
  std::string text{};
};

/// A picture on the map.
struct ViewLayer {
  Eigen::Vector2d corner = Eigen::Vector2d::Zero();  ///< lower left
  double resolution_m = 0.0;                         ///< side of a pixel
  std::string png{};
};

}  // namespace loopstone
