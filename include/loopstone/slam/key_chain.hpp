#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "loopstone/base/stamp.hpp"
#include "loopstone/geometry/pose2.hpp"
#include "loopstone/graph/pose_graph.hpp"

namespace loopstone {

/// A scan that is a node of the graph.
struct KeyScan {
  Stamp stamp{};
  Pose2 local_T_robot{};  ///< where the front end put it
  Eigen::Matrix3d covariance =
      Eigen::Matrix3d::Zero();  ///< of that match, (x, y, yaw), local frame
  std::size_t scan = 0;         ///< its place among all scans
  bool starts_submap = false;
  /// Of the motion from the key scan before, where the laser did not hold it: (x, y, yaw), local
  /// frame.
  std::optional<Eigen::Matrix3d> across{};

  template <typename Archive>
  void archive(Archive& a) {
    a(stamp, local_T_robot, covariance, scan, starts_submap, across);
  }
};

/// Whether the lengths of a path at places along it are what they can be: finite, and nowhere less
/// than before. For what comes from a file.
[[nodiscard]] bool only_grows(std::span<const double> travelled_m);

/// The path as key scans, cut into stretches: a stretch begins with the key scan that a submap
/// begins with.
///
/// Loop closing needs the stretches' first poses alone, so that is what it solves for: some hundred
/// nodes instead of some thousand. What happened between them is one edge, compounded from the
/// motions, until expand() spells it out.
class KeyChain {
 public:
  /// \param drift_per_m  position uncertainty gained by a metre of travel: what is uncertain across
  ///                     a break of the path counts as the travel that would have made it so
  explicit KeyChain(double drift_per_m) : drift_per_m_(drift_per_m) {}

  /// The first key scan begins a stretch in any case.
  void add(const KeyScan& key);
  /// Forgets all key scans of a stretch but the first. It must not be the newest.
  void thin(std::size_t stretch);

  [[nodiscard]] std::size_t stretch_count() const { return stretches_.size(); }
  /// Motion from the first key scan of a stretch to that of the next one, or to its own last.
  [[nodiscard]] const PoseWithCovariance2& across(std::size_t stretch) const {
    return stretches_[stretch].across;
  }
  /// From the first key scan to the newest [m]: between key scans a robot only trembles.
  [[nodiscard]] double length_m() const { return length_m_; }
  /// Length of the path up to each stretch [m], and what breaks count for.
  [[nodiscard]] std::span<const double> travelled_m() const { return travelled_m_; }

  /// The key scans that are kept, in order.
  [[nodiscard]] std::vector<KeyScan> keys() const;
  /// Of each stretch, the place of its first key scan among them.
  [[nodiscard]] std::vector<NodeId> first_nodes() const;
  /// Their graph, edges along the path only. \param map_T_stretch pose of each stretch's first key
  /// scan
  [[nodiscard]] PoseGraph expand(std::span<const Pose2> map_T_stretch) const;

  template <typename Archive>
  void archive(Archive& a) {
    a(stretches_, travelled_m_, newest_, length_m_, breaks_m_);
    if constexpr (Archive::kReads)
      a.check(is_sound(), "a chain of key scans that contradicts itself");
  }

 private:
  [[nodiscard]] bool is_sound() const;

  struct Stretch {
    std::vector<KeyScan> keys{};
    PoseWithCovariance2 across{};

    template <typename Archive>
    void archive(Archive& a) {
      a(keys, across);
    }
  };
  double drift_per_m_;
  std::vector<Stretch> stretches_{};
  std::vector<double> travelled_m_{};
  KeyScan newest_{};
  double length_m_ = 0.0;
  double breaks_m_ = 0.0;  ///< what breaks count for
};

}  // namespace loopstone
