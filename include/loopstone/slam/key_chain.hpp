#pragma once

#include <span>
#include <utility>
#include <vector>

#include "loopstone/graph/pose_graph.hpp"
#include "loopstone/slam/key_scan.hpp"
#include "loopstone/slam/step_drift.hpp"
#include "loopstone/slam/submap_record.hpp"

namespace loopstone {

/// The noise model of the motion from one key scan to the next.
struct KeyChainNumbers {
  double rest_m = 0.004;
  double travel_share = 0.006;
  double rest_rad = 0.0012;
  double turn_share = 0.004;
  double window_sigmas = 2.0;
  double least_drift = 1e-3;
  double lost_rad = 0.4;
  double lost_m = 10.0;
};
inline constexpr KeyChainNumbers kKeyChain{};

template <typename Visitor>
void visit_numbers(const KeyChainNumbers& n, Visitor&& visit) {
  visit("rest_m", n.rest_m,
        "chosen: what matching against a submap leaves uncertain between key scans, however good "
        "the match: its slow drift");
  visit("travel_share", n.travel_share, "chosen: the same, of the distance between them");
  visit("rest_rad", n.rest_rad, "chosen: as rest_m, of the heading");
  visit("turn_share", n.turn_share, "chosen: the same, of the turn between them");
  visit("window_sigmas", n.window_sigmas,
        "chosen: what loop closing searches across a break, in standard deviations");
  visit("least_drift", n.least_drift,
        "chosen: drift per metre that a break is compared with, at the least: no division by 0");
  visit("lost_rad", n.lost_rad,
        "derived: half of half_yaw_most_rad of the candidates: in no window of headings lies what "
        "is less certain across a break");
  visit("lost_m", n.lost_m, "chosen: for what such a break counts: a place nowhere near");
}

struct ToldPath;

/// The path as key scans, cut into stretches: a stretch begins with the key scan that a submap
/// begins with.
///
/// Loop closing needs the stretches' first poses alone, so that is what it solves for: some hundred
/// nodes instead of some thousand. What happened between them is one edge, compounded from the
/// motions, until expand() spells it out.
class KeyChain {
 public:
  /// All that it knows; plain data.
  struct State {
    std::vector<SubmapRecord> submaps{};
    KeyScan newest{};
    double length_m = 0.0;  ///< from the first key scan to the newest
    double breaks_m = 0.0;  ///< what breaks count for

    template <typename Archive>
    void archive(Archive& a) {
      a(submaps, newest, length_m, breaks_m);
    }
  };

  /// \param drift_per_m  position uncertainty gained by a metre of travel: what is uncertain across
  ///                     a break of the path counts as the travel that would have made it so
  explicit KeyChain(double drift_per_m) : drift_per_m_(drift_per_m) {}

  /// The first key scan begins a stretch in any case. A new stretch lies where the motions put it.
  void add(const KeyScan& key);
  /// A chain of its own follows: its first key scan starts a drive. It lies where that says.
  void append(State drive);
  /// Forgets all scans of a stretch but the first, and the last where the path breaks behind it, or
  /// may.
  void thin(SubmapId stretch);

  [[nodiscard]] std::vector<SubmapRecord>& submaps() { return state_.submaps; }
  [[nodiscard]] std::span<const SubmapRecord> submaps() const { return state_.submaps; }
  /// From the first key scan to the newest [m]: between key scans a robot only trembles.
  [[nodiscard]] double length_m() const { return state_.length_m; }

  /// The key scans that are kept, in order.
  [[nodiscard]] std::vector<KeyScan> keys() const;
  /// How far the path may drift from each of them to the next. Odometry tells the way where the
  /// laser leaves it open.
  [[nodiscard]] std::vector<StepDrift> drifts(const ToldPath& path) const;
  /// Of each stretch, the place of its first key scan among them.
  [[nodiscard]] std::vector<NodeId> first_nodes() const;
  /// The graph of the stretches' first key scans, edges along the path only.
  [[nodiscard]] PoseGraph outline() const;
  /// The graph of all key scans, likewise.
  [[nodiscard]] PoseGraph expand() const;

  [[nodiscard]] const State& state() const { return state_; }
  void restore(State state) { state_ = std::move(state); }

 private:
  PoseWithCovariance2 lead_to(const KeyScan& key);

  double drift_per_m_;
  State state_{};
};

}  // namespace loopstone
