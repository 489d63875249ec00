#pragma once

#include <functional>
#include <span>
#include <vector>

#include "loopstone/registration/cloud_extent.hpp"
#include "loopstone/registration/match_result.hpp"

namespace loopstone {

/// A matcher as a function of its guess.
template <int kDimension>
using Matcher = std::function<BasicMatchResult<kDimension>(
    const typename RigidMotion<kDimension>::Pose& guess_target_T_source)>;

/// What came of matching from many starts.
template <int kDimension>
struct SweepResult {
  struct Ending {
    BasicMatchResult<kDimension> match{};  ///< the best of those that ended here
    std::size_t start = 0;                 ///< the start that it came from
    int count = 0;                         ///< starts that ended here
  };

  int starts = 0;
  int agreeing = 0;               ///< starts that ended where the best one did
  std::vector<Ending> endings{};  ///< distinct poses, best first; never empty

  [[nodiscard]] const BasicMatchResult<kDimension>& best() const { return endings.front().match; }
};

/// Whether one match is better than another: a pose that the data support before one that they
/// don't, then the one that explains more of the source, then the one with the smaller residuals.
template <int kDimension>
[[nodiscard]] bool is_better(const BasicMatchResult<kDimension>& a,
                             const BasicMatchResult<kDimension>& b);

/// Matches from every start and sorts out where they ended. Two poses are the same when no point
/// within the source's radius of its centre is moved by more than `same_m` from one to the other.
/// \param starts  at least one: guesses of target_T_source
template <int kDimension>
[[nodiscard]] SweepResult<kDimension> match_from(
    std::span<const typename RigidMotion<kDimension>::Pose> starts,
    const Matcher<kDimension>& matcher, const CloudExtent<kDimension>& source, double same_m);

/// So many headings, evenly spread from the guess's own: the guess turned about the (vertical) axis
/// through the source's centre.
template <int kDimension>
[[nodiscard]] std::vector<typename RigidMotion<kDimension>::Pose> headings_from(
    const typename RigidMotion<kDimension>::Pose& guess_target_T_source,
    const CloudExtent<kDimension>& source, int count);

extern template bool is_better<2>(const MatchResult&, const MatchResult&);
extern template bool is_better<3>(const MatchResult3&, const MatchResult3&);
extern template SweepResult<2> match_from<2>(std::span<const Pose2>, const Matcher<2>&,
                                             const CloudExtent<2>&, double);
extern template SweepResult<3> match_from<3>(std::span<const Pose3>, const Matcher<3>&,
                                             const CloudExtent<3>&, double);
extern template std::vector<Pose2> headings_from<2>(const Pose2&, const CloudExtent<2>&, int);
extern template std::vector<Pose3> headings_from<3>(const Pose3&, const CloudExtent<3>&, int);

}  // namespace loopstone
