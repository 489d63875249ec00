#pragma once

#include "view_request.hpp"

namespace loopstone::app {

/// Whether `loopstone map` left it.
[[nodiscard]] bool is_map_folder(const std::string& path);

/// Shows a finished map, until Ctrl-C.
[[nodiscard]] ExitCode view_folder(const ViewRequest& request, const AppContext& context);

}  // namespace loopstone::app
