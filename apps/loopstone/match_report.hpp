#pragma once

#include "loopstone/registration/align.hpp"
#include "match_input.hpp"
#include "result.hpp"

namespace loopstone::app {

/// The table and the JSON object of a match.
/// \param wall_time_s  preparation of the target included, reading not
template <int kDimension>
[[nodiscard]] Result report_match(const MatchInput& source, const MatchInput& target,
                                  const AlignResult<kDimension>& result, double wall_time_s);

/// Where the source stands in the world, when it is known where the target does.
void add_world_pose(Result& result, const Pose2& world_T_target, const MatchResult& match);

extern template Result report_match<2>(const MatchInput&, const MatchInput&, const AlignResult<2>&,
                                       double);
extern template Result report_match<3>(const MatchInput&, const MatchInput&, const AlignResult<3>&,
                                       double);

}  // namespace loopstone::app
