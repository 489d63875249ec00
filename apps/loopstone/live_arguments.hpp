#pragma once

#include <optional>
#include <string>
#include <vector>

#include "app.hpp"
#include "live_listener.hpp"
#include "live_view.hpp"
#include "log_flags.hpp"
#include "loopstone/live/live_log.hpp"
#include "loopstone/slam/front_end.hpp"

namespace loopstone::app {

/// What a program is asked for that maps or localises live.
struct LiveArguments {
  std::vector<std::string> sources{};
  double speed = 1.0;      ///< of logs that are replayed
  double end_after_s = 0;  ///< without a message; 0: never
  std::string out{};       ///< a folder; of localisation a trajectory
  std::string map{};       ///< empty: one is made
  std::string from{};      ///< a folder of an earlier map to go on with
  std::string record{};    ///< what comes, as MCAP
  std::string poses{};     ///< where poses are told as they are known
  double checkpoint_s = 30.0;
  std::optional<OdometryUse> odometry{};
  std::string initial{};  ///< of localisation; empty: anywhere on the map
  std::string initial_sigma{};
  bool no_view = false;
  ViewFlags view{};
  LogFlags reading{};
  bool force = false;

  // What is not said by the user: another program's own source, and who hears of the drive there.
  std::vector<LiveSource> given{};
  LiveListener* listener = nullptr;
};

/// Makes a map of what comes, until Ctrl-C.
[[nodiscard]] ExitCode map_live(const LiveArguments& arguments, const AppContext& context);
/// Tells where the robot is on a map, until Ctrl-C.
[[nodiscard]] ExitCode localize_live(const LiveArguments& arguments, const AppContext& context);

}  // namespace loopstone::app
