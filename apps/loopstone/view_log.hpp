#pragma once

#include "view_request.hpp"

namespace loopstone::app {

/// Maps a log while it is replayed, until Ctrl-C.
[[nodiscard]] ExitCode view_log(const ViewRequest& request, const AppContext& context);

}  // namespace loopstone::app
