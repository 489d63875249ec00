#include "loopstone/slam/key_chain.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "loopstone/base/hypotenuse.hpp"
#include "loopstone/geometry/covariance.hpp"
#include "slam/path_drift.hpp"
#include "slam/scan_edges.hpp"

namespace loopstone {

namespace {

/// From one key scan to the next.
PoseWithCovariance2 motion_between(const KeyScan& previous, const KeyScan& next) {
  const Pose2 motion = previous.local_T_robot.inverse() * next.local_T_robot;
  // What the laser did not follow is known as well as the break says.
  const double distance = next.across ? 0.0 : hypotenuse(motion.x, motion.y);
  const double sigma = kKeyChain.rest_m + kKeyChain.travel_share * distance;
  const double sigma_yaw = kKeyChain.rest_rad + kKeyChain.turn_share * std::abs(motion.yaw);
  // From the local frame to that of the previous key scan, in which the motion is told.
  Eigen::Matrix3d covariance = previous.covariance + next.covariance;
  if (next.across) covariance += *next.across;
  covariance = rotated(covariance, previous.local_T_robot.rotation().transpose());
  covariance.diagonal() += Eigen::Vector3d(sigma * sigma, sigma * sigma, sigma_yaw * sigma_yaw);
  return {motion, covariance};
}

}  // namespace

/// The newest stretch reaches to this key scan; what is uncertain on the way counts. Returns the
/// motion.
PoseWithCovariance2 KeyChain::lead_to(const KeyScan& key) {
  PoseWithCovariance2 motion = motion_between(state_.newest, key);
  state_.submaps.back().across = compound(state_.submaps.back().across, motion);
  if (key.across) {
    double sigma_m = std::sqrt(std::max((*key.across)(0, 0), (*key.across)(1, 1)));
    // What may face anywhere is found by appearance, which is asked where places may be far off.
    if (std::sqrt((*key.across)(2, 2)) > kKeyChain.lost_rad)
      sigma_m = std::max(sigma_m, kKeyChain.lost_m);
    state_.breaks_m +=
        kKeyChain.window_sigmas * sigma_m / std::max(drift_per_m_, kKeyChain.least_drift);
  }
  return motion;
}

void KeyChain::add(const KeyScan& key) {
  auto& [submaps, newest, length_m, breaks_m] = state_;
  if (!submaps.empty()) {
    const PoseWithCovariance2 motion = lead_to(key);
    if (!key.starts_drive) length_m += hypotenuse(motion.pose.x, motion.pose.y);
  }
  if (submaps.empty() || key.starts_submap) {
    SubmapRecord submap;
    submap.travelled_m = length_m + breaks_m;
    submap.map_T_submap = submaps.empty()
                              ? key.local_T_robot
                              : submaps.back().map_T_submap * submaps.back().across.pose;
    submaps.push_back(std::move(submap));
  }
  submaps.back().keys.push_back(key);
  newest = key;
}

void KeyChain::append(State drive) {
  auto& [submaps, newest, length_m, breaks_m] = state_;
  if (submaps.empty()) {
    state_ = std::move(drive);
    return;
  }
  lead_to(drive.submaps.front().keys.front());
  const Pose2 map_T_drive = submaps.back().map_T_submap * submaps.back().across.pose *
                            drive.submaps.front().map_T_submap.inverse();
  const double before_m = length_m + breaks_m;
  for (SubmapRecord& submap : drive.submaps) {
    submap.travelled_m += before_m;
    submap.map_T_submap = map_T_drive * submap.map_T_submap;
    submaps.push_back(std::move(submap));
  }
  newest = drive.newest;
  length_m += drive.length_m;
  breaks_m += drive.breaks_m;
}

void KeyChain::thin(SubmapId stretch) {
  SubmapRecord& submap = state_.submaps[stretch.index];
  // What is lost across a break is not shared out among the scans before it.
  const bool goes_on = stretch.index + 1 < state_.submaps.size() &&
                       !state_.submaps[stretch.index + 1].keys.front().across;
  if (goes_on || submap.keys.size() == 1) {
    submap.keys.resize(1);
    submap.keys.shrink_to_fit();
    submap.scans.thin();
    return;
  }
  submap.keys = {submap.keys.front(), submap.keys.back()};
  const auto scans = submap.scans.share();
  submap.scans = {};
  for (const auto& scan : *scans) {
    const auto is_of = [&](const KeyScan& key) { return key.scan == scan->index; };
    if (std::ranges::any_of(submap.keys, is_of)) submap.scans.add(scan);
  }
}

std::vector<KeyScan> KeyChain::keys() const {
  std::vector<KeyScan> all;
  for (const SubmapRecord& submap : submaps())
    all.insert(all.end(), submap.keys.begin(), submap.keys.end());
  return all;
}

std::vector<NodeId> KeyChain::first_nodes() const {
  std::vector<NodeId> nodes;
  int next = 0;
  for (const SubmapRecord& submap : submaps()) {
    nodes.push_back({next});
    next += static_cast<int>(submap.keys.size());
  }
  return nodes;
}

std::vector<StepDrift> KeyChain::drifts(const ToldPath& path) const {
  std::vector<StepDrift> drifts;
  const auto add = [&](const KeyScan& previous, const KeyScan& next) {
    drifts.push_back(drift_between(previous, next, told_between(previous, next, path)));
  };
  for (std::size_t s = 0; s < submaps().size(); ++s) {
    const auto& keys = submaps()[s].keys;
    for (std::size_t k = 1; k < keys.size(); ++k) add(keys[k - 1], keys[k]);
    if (s + 1 == submaps().size()) break;
    const PoseWithCovariance2& across = submaps()[s].across;
    if (keys.size() == 1) {  // thinned: the robot was there many times
      drifts.push_back(
          {.covariance = kPathDrift.thinned_share *
                         rotated(across.covariance, across.pose.rotation().transpose())});
    } else {
      add(keys.back(), submaps()[s + 1].keys.front());
    }
  }
  return drifts;
}

PoseGraph KeyChain::outline() const {
  PoseGraph graph;
  graph.poses = poses_of(submaps());
  for (int from = 0; from + 1 < static_cast<int>(graph.poses.size()); ++from) {
    const auto& motion = submaps()[static_cast<std::size_t>(from)].across;
    graph.edges.push_back(edge_between(from, from + 1, motion, EdgeKind::kOdometry));
  }
  return graph;
}

PoseGraph KeyChain::expand() const {
  PoseGraph graph;
  const auto add_edge = [&](const PoseWithCovariance2& motion) {
    const int from = static_cast<int>(graph.poses.size()) - 1;
    graph.edges.push_back(edge_between(from, from + 1, motion, EdgeKind::kOdometry));
  };
  for (std::size_t s = 0; s < submaps().size(); ++s) {
    const SubmapRecord& submap = submaps()[s];
    const SubmapRecord* const next = s + 1 < submaps().size() ? &submaps()[s + 1] : nullptr;
    const auto& keys = submap.keys;
    for (std::size_t k = 0; k < keys.size(); ++k) {
      if (k > 0) add_edge(motion_between(keys[k - 1], keys[k]));
      const Pose2 motion = keys.front().local_T_robot.inverse() * keys[k].local_T_robot;
      Pose2 pose = submap.map_T_submap * motion;
      if (next != nullptr && !next->keys.front().across) {
        // What the next stretch's pose adds to the motions is shared out along the way; where the
        // path breaks it was lost there.
        const double ratio = static_cast<double>(k) / static_cast<double>(keys.size());
        const Pose2 from_next = next->map_T_submap * submap.across.pose.inverse() * motion;
        pose = interpolate(pose, from_next, ratio);
      }
      graph.poses.push_back(pose);
    }
    if (next == nullptr) break;
    add_edge(keys.size() == 1 ? submap.across : motion_between(keys.back(), next->keys.front()));
  }
  return graph;
}

}  // namespace loopstone
