#pragma once

#include "match_input.hpp"
#include "match_request.hpp"

namespace loopstone::app {

/// Scan, planar cloud or map: picks the matcher that suits both sides and the request, and runs it.
/// Throws UsageError when the method does not go with them.
[[nodiscard]] MatchOutcome<2> match_in_plane(const MatchInput& source, const MatchInput& target,
                                             const MatchRequest<2>& request,
                                             const AppContext& context);

/// Clouds in space.
[[nodiscard]] MatchOutcome<3> match_in_space(const MatchInput& source, const MatchInput& target,
                                             const MatchRequest<3>& request,
                                             const AppContext& context);

}  // namespace loopstone::app
