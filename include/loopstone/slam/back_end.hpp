#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "loopstone/base/parallel_for.hpp"
#include "loopstone/graph/pose_graph.hpp"
#include "loopstone/slam/finished_submap.hpp"
#include "loopstone/slam/key_chain.hpp"
#include "loopstone/slam/loop_closer.hpp"
#include "loopstone/slam/loop_closure.hpp"
#include "loopstone/slam/map_options.hpp"
#include "loopstone/slam/map_update.hpp"
#include "loopstone/slam/submap_record.hpp"

namespace loopstone {

/// When the back end believes, waits and takes back.
struct BackEndNumbers {
  double revoke_chi2 = 26.0;
  double lone_overlap = 0.5;
  double lone_agreement = 0.9;
  double news_chi2 = 6.0;
  int final_rounds = 2;
  double apart_m = 5.0;
};
inline constexpr BackEndNumbers kBackEnd{};

template <typename Visitor>
void visit_numbers(const BackEndNumbers& n, Visitor&& visit) {
  visit("revoke_chi2", n.revoke_chi2,
        "derived: chi-square of three degrees of freedom, exceeded by 1e-5 of true closures; one "
        "whose residual is larger does not stand");
  visit("lone_overlap", n.lone_overlap,
        "chosen: at the end a closure that bends the map and is consistent with no other one "
        "needs at least this overlap");
  visit("lone_agreement", n.lone_agreement, "chosen: and this agreement");
  visit("news_chi2", n.news_chi2,
        "chosen: as long as closures say together no more than this that the map does not, "
        "solving can wait");
  visit("final_rounds", n.final_rounds,
        "chosen: rounds of looking everywhere at the end, with ever better poses");
  visit("apart_m", n.apart_m,
        "chosen: between what was seen on drives that nothing ties, so that they are drawn beside "
        "each other");
}

/// Keeps the graph: submaps with their key scans in a chain, closures across it, solved whenever a
/// closure was found. Depends only on what it is given and in which order, so it may run beside the
/// front end.
///
/// Memory: grows with the area, not with time. What older submaps cover is thinned: of such a
/// stretch the first key scan stays, some hundred bytes for metres of travel.
class BackEnd {
 public:
  /// All that it knows before finish(); plain data.
  struct State {
    KeyChain::State chain{};
    LoopCloser::State loops{};
    std::vector<LoopClosure> closures{};
    double loop_closing_s = 0.0;
    double optimisation_s = 0.0;

    template <typename Archive>
    void archive(Archive& a) {
      a(chain, loops, closures, loop_closing_s, optimisation_s);
    }
  };

  BackEnd(const MapOptions& options, Threads threads);

  void add_key(const KeyScan& key);
  /// A scan to draw the map from; belongs to the stretch of the newest key scan.
  void add_scan(std::shared_ptr<const MappedScan> scan);
  /// Submaps come in the order of the key scans that they start with.
  void add_submap(FinishedSubmap submap);
  /// Of a restored state: looks for the submaps from `first` on, which came as they were mapped by
  /// themselves, among those before them; then everywhere. Covered submaps are dropped, and nothing
  /// is thinned.
  void search_drive(SubmapId first, const std::function<bool()>& goes_on = {});
  /// Of a restored state: drops submaps of which older ones saw all, without thinning.
  void drop_covered() { (void)loops_.drop_covered(full_submaps(), false); }
  /// Of a restored state some of whose closures were turned down: lays all drives as the rest has
  /// it, and drops what older submaps cover by that.
  void lay_anew();
  /// Looks once more for closures everywhere, settles which stand, and makes the graph of all key
  /// scans. Call once, at the end.
  void finish(const std::function<bool()>& goes_on = {});

  /// What happened since the last call, in order: submaps dropped, closures, solutions.
  [[nodiscard]] std::vector<MapEvent> take_events() { return std::exchange(events_, {}); }
  [[nodiscard]] std::span<const SubmapRecord> submaps() const { return chain_.submaps(); }
  [[nodiscard]] const std::vector<LoopClosure>& closures() const { return closures_; }
  /// Of submaps that were full, dropped ones included.
  [[nodiscard]] std::size_t submap_count() const;

  /// After finish().
  [[nodiscard]] const PoseGraph& graph() const { return graph_; }
  [[nodiscard]] const KeyChain& chain() const { return chain_; }  ///< its keys: the graph's nodes
  [[nodiscard]] std::vector<KeyScan> keys() const { return chain_.keys(); }
  [[nodiscard]] double path_length_m() const { return chain_.length_m(); }
  [[nodiscard]] double loop_closing_s() const { return loop_closing_s_; }
  [[nodiscard]] double optimisation_s() const { return optimisation_s_; }

  /// Cost: that of copying some hundred bytes a key scan; scans and full submaps are shared.
  [[nodiscard]] State state() const;
  /// The state must be sound, or behaviour is undefined.
  void restore(State state);

 private:
  [[nodiscard]] std::span<SubmapRecord> full_submaps();
  void take(std::vector<LoopClosure> found);
  void ask_around(std::vector<LoopClosure>& asked) const;
  void lay_drives(std::span<const std::size_t> accepted);
  void set_apart();
  std::vector<std::size_t> settle();
  [[nodiscard]] PoseGraph outline() const;
  void thin_covered();
  void accept_lone();
  [[nodiscard]] double unsolved_chi2() const;
  void solve(PoseGraph& graph);
  void solve_outline();

  bool loop_closure_;
  LoopOptions loop_options_;
  SubmapOptions submap_options_;
  GridMatchOptions match_options_;
  Threads threads_;
  LoopCloser loops_;
  KeyChain chain_;
  PoseGraph graph_{};  ///< in the end: of all key scans, and with closures
  std::vector<LoopClosure> closures_{};
  std::vector<MapEvent> events_{};
  double loop_closing_s_ = 0.0;
  double optimisation_s_ = 0.0;
};

/// Whether a state hangs together: every index lies inside what it points into, and what only grows
/// does. For what comes from a file; a run that went on from one that does not would read what is
/// not there.
/// \param scans    of all scans so far; mapped ones are among them
/// \param reach_m  no submap reaches farther than this from its origin
[[nodiscard]] bool is_sound(const BackEnd::State& state, std::size_t scans, double reach_m);

}  // namespace loopstone
