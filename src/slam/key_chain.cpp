#include "loopstone/slam/key_chain.hpp"

#include <algorithm>
#include <cmath>

#include "slam/scan_edges.hpp"

namespace loopstone {

namespace {

/// What matching against a submap leaves uncertain between consecutive key scans, however good the
/// match: its slow drift.
constexpr double kChainRestM = 0.004;
constexpr double kChainShare = 0.006;
constexpr double kChainRestRad = 0.0012;
constexpr double kChainTurnShare = 0.004;
/// What loop closing searches across a break, in standard deviations.
constexpr double kWindowSigmas = 2.0;
constexpr double kLeastDrift = 1e-3;

/// From one key scan to the next.
PoseWithCovariance2 motion_between(const KeyScan& previous, const KeyScan& next) {
  const Pose2 motion = previous.local_T_robot.inverse() * next.local_T_robot;
  // What the laser did not follow is known as well as the break says.
  const double distance = next.across ? 0.0 : std::hypot(motion.x, motion.y);
  const double sigma = kChainRestM + kChainShare * distance;
  const double sigma_yaw = kChainRestRad + kChainTurnShare * std::abs(motion.yaw);
  // From the local frame to that of the previous key scan, in which the motion is told.
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  turn.topLeftCorner<2, 2>() = previous.local_T_robot.rotation().transpose();
  Eigen::Matrix3d covariance = previous.covariance + next.covariance;
  if (next.across) covariance += *next.across;
  covariance = turn * covariance * turn.transpose();
  covariance.diagonal() += Eigen::Vector3d(sigma * sigma, sigma * sigma, sigma_yaw * sigma_yaw);
  return {motion, covariance};
}

}  // namespace

void KeyChain::add(const KeyScan& key) {
  if (!stretches_.empty()) {
    Stretch& open = stretches_.back();
    const PoseWithCovariance2 motion = motion_between(newest_, key);
    open.across = compound(open.across, motion);
    length_m_ += std::hypot(motion.pose.x, motion.pose.y);
    if (key.across) {
      const double sigma_m = std::sqrt(std::max((*key.across)(0, 0), (*key.across)(1, 1)));
      breaks_m_ += kWindowSigmas * sigma_m / std::max(drift_per_m_, kLeastDrift);
    }
  }
  if (stretches_.empty() || key.starts_submap) {
    stretches_.emplace_back();
    travelled_m_.push_back(length_m_ + breaks_m_);
  }
  stretches_.back().keys.push_back(key);
  newest_ = key;
}

void KeyChain::thin(std::size_t stretch) {
  auto& keys = stretches_[stretch].keys;
  keys.resize(1);
  keys.shrink_to_fit();
}

std::vector<KeyScan> KeyChain::keys() const {
  std::vector<KeyScan> all;
  for (const Stretch& stretch : stretches_)
    all.insert(all.end(), stretch.keys.begin(), stretch.keys.end());
  return all;
}

std::vector<NodeId> KeyChain::first_nodes() const {
  std::vector<NodeId> nodes;
  int next = 0;
  for (const Stretch& stretch : stretches_) {
    nodes.push_back({next});
    next += static_cast<int>(stretch.keys.size());
  }
  return nodes;
}

PoseGraph KeyChain::expand(std::span<const Pose2> map_T_stretch) const {
  PoseGraph graph;
  const auto add_edge = [&](const PoseWithCovariance2& motion) {
    const int from = static_cast<int>(graph.poses.size()) - 1;
    graph.edges.push_back(edge_between(from, from + 1, motion, EdgeKind::kOdometry));
  };
  for (std::size_t s = 0; s < stretches_.size(); ++s) {
    const auto& [keys, across] = stretches_[s];
    const bool has_next = s + 1 < stretches_.size();
    for (std::size_t k = 0; k < keys.size(); ++k) {
      if (k > 0) add_edge(motion_between(keys[k - 1], keys[k]));
      const Pose2 motion = keys.front().local_T_robot.inverse() * keys[k].local_T_robot;
      Pose2 pose = map_T_stretch[s] * motion;
      if (has_next) {
        // What the next stretch's pose adds to the motions is shared out along the way.
        const double ratio = static_cast<double>(k) / static_cast<double>(keys.size());
        const Pose2 from_next = map_T_stretch[s + 1] * across.pose.inverse() * motion;
        pose = interpolate(pose, from_next, ratio);
      }
      graph.poses.push_back(pose);
    }
    if (!has_next) break;
    const KeyScan& next = stretches_[s + 1].keys.front();
    add_edge(keys.size() == 1 ? across : motion_between(keys.back(), next));
  }
  return graph;
}

}  // namespace loopstone
