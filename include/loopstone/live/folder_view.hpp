#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "loopstone/live/playback.hpp"
#include "loopstone/live/replay_clock.hpp"
#include "loopstone/live/view_board.hpp"
#include "loopstone/report/map_folder.hpp"
#include "loopstone/sensor/robot_model.hpp"

namespace loopstone {

/// A finished map on a board: everything is known at once, and the robot drives along its path as
/// a clock says.
///
///   FolderView view(read_map_folder("out"), robot, board);
///   ReplayClock clock(*view.range(), 1.0, tell);
///   view.play(clock, go_on);
class FolderView {
 public:
  FolderView(MapFolder folder, const RobotModel& robot, ViewBoard& board);
  ~FolderView();
  FolderView(const FolderView&) = delete;
  FolderView& operator=(const FolderView&) = delete;

  /// Of the path.
  [[nodiscard]] PlaybackRange range() const;

  /// A scan of the log, as it was mapped: it is shown when the robot is there, and with the
  /// closures that it has a part in. Before play(). Those that are no pose of the path are not
  /// kept, and others than those of closures not beyond `most_bytes` in all.
  void add_scan(const LaserScan& scan, std::size_t most_bytes = std::size_t{1} << 29U);
  [[nodiscard]] std::size_t scans() const;

  /// Shows the map, then moves the robot until `go_on` says no.
  /// \param go_on  asked several times a second
  void play(ReplayClock& clock, const std::function<bool()>& go_on);

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace loopstone
