#pragma once

#include <string>

#include "app.hpp"
#include "live_view.hpp"
#include "log_run.hpp"

namespace loopstone::app {

/// What `loopstone view` is asked for.
struct ViewRequest {
  std::string what{};  ///< a folder or a log
  std::string log{};   ///< of a folder: whose scans are shown; empty: the one that it names
  bool edit = false;
  std::string edits{};  ///< where edits are saved; empty: beside the folder
  double speed = 1.0;
  LogCut cut{};
  LogFlags reading{};
  ViewFlags view{};
};

/// The name of a file or folder, without what it lies in.
[[nodiscard]] std::string short_name(const std::string& path);

/// Says where the view is, on stdout.
void tell_address(const LiveView& view, const AppContext& context);

}  // namespace loopstone::app
