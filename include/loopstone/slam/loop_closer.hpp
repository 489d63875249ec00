#pragma once

#include <compare>
#include <cstddef>
#include <functional>
#include <map>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "loopstone/base/options.hpp"
#include "loopstone/base/parallel_for.hpp"
#include "loopstone/mapping/submap.hpp"
#include "loopstone/registration/grid_matcher.hpp"
#include "loopstone/slam/loop_closure.hpp"
#include "loopstone/slam/submap_record.hpp"

namespace loopstone {

struct LoopOptions {
  double min_score = 0.30;
  double min_overlap = 0.30;
  double min_agreement = 0.75;
  double max_ambiguity = 0.85;
  double drift_per_m = 0.03;
  double drift_rad_per_m = 0.006;
  double max_half_xy_m = 10.0;
  int candidates_max = 5;
  int places_max = 3;
};

template <typename Visitor>
void visit_options(LoopOptions& options, Visitor&& visit) {
  visit("min_score", options.min_score, Range{0.0, 1.0},
        "a closure's share of points on surfaces less share in free space, by the search");
  visit("min_overlap", options.min_overlap, Range{0.0, 1.0},
        "share of a submap that the other one must have observed");
  visit("min_agreement", options.min_agreement, Range{0.0, 1.0},
        "share of the overlap that must lie on surfaces facing the same way");
  visit("max_ambiguity", options.max_ambiguity, Range{0.0, 1.0},
        "a second pose elsewhere may reach this share of the best score");
  visit("drift_per_m", options.drift_per_m, Range{0.0, 1.0},
        "position uncertainty gained per metre of travel since the places were connected");
  visit("drift_rad_per_m", options.drift_rad_per_m, Range{0.0, 1.0},
        "heading uncertainty gained per metre of travel");
  visit("max_half_xy_m", options.max_half_xy_m, Range{0.1, 100.0},
        "half side of the largest search window");
  visit("candidates_max", options.candidates_max, Range{1, 1000},
        "older submaps that a new one is compared with");
  visit("places_max", options.places_max, Range{0, 1000},
        "where the drift may exceed max_half_xy_m: older submaps tried because they look alike; 0: "
        "none");
}

/// What is compared again, and what is not compared any more.
struct LoopCloserNumbers {
  double same_try_m = 0.25;
  double same_try_rad = 0.03;
  double elsewhere_m = 1.0;
  double covered = 0.9;
  std::size_t beside = 2;
  std::size_t at_once = 64;
};
inline constexpr LoopCloserNumbers kLoopCloser{};

template <typename Visitor>
void visit_numbers(const LoopCloserNumbers& n, Visitor&& visit) {
  visit("same_try_m", n.same_try_m,
        "chosen: a pair that failed is tried again once its poses have changed by this much");
  visit("same_try_rad", n.same_try_rad, "chosen: or turned by so much");
  visit("elsewhere_m", n.elsewhere_m,
        "chosen: two closures of one submap that put it this far apart speak of two places");
  visit("covered", n.covered, "chosen: a submap of which older ones saw such a share adds nothing");
  visit("beside", n.beside,
        "chosen: so many are compared beside each other, whatever the number of threads; the "
        "nearest first, until the submap is covered");
  visit("at_once", n.at_once,
        "chosen: in the end so many, some tenths of a second, before somebody is asked whether to "
        "go on");
}

struct LoopCandidate;

/// Two submaps, in the order in which maps of pairs keep them.
struct SubmapPair {
  SubmapId newer{};
  SubmapId older{};
  friend constexpr auto operator<=>(const SubmapPair&, const SubmapPair&) = default;

  template <typename Archive>
  void archive(Archive& a) {
    a(newer, older);
  }
};

/// Recognises places: compares whole submaps, which are far more distinctive than single scans. The
/// submaps that it is given are always the same ones in order, with more of them at the end: those
/// that are full or were dropped.
class LoopCloser {
 public:
  /// What it remembers of its attempts; plain data.
  struct State {
    std::set<SubmapPair> standing{};
    std::map<SubmapPair, Pose2> tried{};  ///< older_T_newer at the last attempt
    /// Compared by appearance, which no pose changes.
    std::set<SubmapPair> tried_by_appearance{};
    /// Which of the newer one's surfaces the older one saw; of closures that waited when found.
    std::map<SubmapPair, std::vector<bool>> seen{};
    std::set<SubmapId> newly_closed{};  ///< the newer ones of closures since drop_covered()

    template <typename Archive>
    void archive(Archive& a) {
      a(standing, tried, tried_by_appearance, seen, newly_closed);
    }
  };

  LoopCloser(const LoopOptions& options, const SubmapOptions& submap, const GridMatchOptions& match,
             Threads threads);

  /// Compares the newest submap with older ones within reach at the present poses, nearest first,
  /// until those that match saw nearly all of it; then with those that look like it, where the
  /// poses may be wrong by more than the largest window. Everything tried that scored well enough
  /// to be considered is returned, waiting or rejected; its nodes are submaps.
  [[nodiscard]] std::vector<LoopClosure> close_newest(std::span<SubmapRecord> submaps);

  /// The same of any submap, with those older than it.
  [[nodiscard]] std::vector<LoopClosure> close(SubmapId newest, std::span<SubmapRecord> submaps);

  /// Compares all pairs within reach that have not been closed yet; for the end of a run, when
  /// poses are good.
  /// \param goes_on  asked now and then; once it returns false, what was found until then is
  ///                 returned. May be empty.
  [[nodiscard]] std::vector<LoopClosure> close_all(std::span<SubmapRecord> submaps,
                                                   const std::function<bool()>& goes_on = {});

  /// Drops what submaps hold that saw nothing new: standing closures tie them to older ones, and
  /// those saw nearly all of their surfaces. They keep their places, but nothing is compared with
  /// them any more. Returns which.
  /// \param forgets  what older ones saw of them; else it is kept, for when those are gone
  std::vector<SubmapId> drop_covered(std::span<SubmapRecord> submaps, bool forgets = true);

  /// Nothing will be compared any more: drops what all submaps hold.
  void drop_all(std::span<SubmapRecord> submaps);

  /// Tells which closures stand, so that uncertainty can be followed through them.
  void set_closures(std::span<SubmapRecord> submaps, std::span<const LoopClosure> closures);

  [[nodiscard]] const State& state() const { return state_; }
  void restore(State state) { state_ = std::move(state); }

 private:
  [[nodiscard]] std::vector<LoopCandidate> untried_for(SubmapId newer,
                                                       std::span<SubmapRecord> submaps);
  [[nodiscard]] bool was_tried(const LoopCandidate& candidate) const;
  void note_tried(const LoopCandidate& candidate);
  [[nodiscard]] std::vector<LoopClosure> compare(std::span<const LoopCandidate> candidates,
                                                 std::span<const SubmapRecord> submaps);
  void reject_rivals(std::vector<LoopClosure>& closures,
                     std::span<const SubmapRecord> submaps) const;

  LoopOptions options_;
  SubmapOptions submap_options_;
  GridMatchOptions match_options_;
  Threads threads_;
  State state_{};
};

/// Whether a closer's memory speaks only of submaps that are there, and of all of their surfaces;
/// for what comes from a file.
[[nodiscard]] bool is_sound(const LoopCloser::State& state, std::span<const SubmapRecord> submaps);

}  // namespace loopstone
