#pragma once

#include "match_input.hpp"
#include "match_request.hpp"
#include "result.hpp"

namespace loopstone::app {

/// The table and the JSON object of a match.
template <int kDimension>
[[nodiscard]] Result report_match(const MatchInput& source, const MatchInput& target,
                                  const MatchOutcome<kDimension>& outcome);

/// Where the source stands in the world, when it is known where the target does.
void add_world_pose(Result& result, const Pose2& world_T_target, const MatchResult& match);

extern template Result report_match<2>(const MatchInput&, const MatchInput&,
                                       const MatchOutcome<2>&);
extern template Result report_match<3>(const MatchInput&, const MatchInput&,
                                       const MatchOutcome<3>&);

}  // namespace loopstone::app
