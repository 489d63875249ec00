#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "loopstone/base/parallel_for.hpp"
#include "loopstone/formats/log_summary.hpp"
#include "loopstone/localization/landmark_mapping.hpp"
#include "loopstone/mapping/floor_texture.hpp"
#include "loopstone/pipeline/cut_log.hpp"
#include "loopstone/pipeline/log_landmarks.hpp"
#include "loopstone/report/edit_outputs.hpp"
#include "loopstone/report/run_info.hpp"
#include "loopstone/report/site_figures.hpp"
#include "loopstone/sensor/messages.hpp"
#include "loopstone/slam/map_options.hpp"
#include "loopstone/slam/map_result.hpp"
#include "loopstone/slam/session.hpp"
#include "reading.hpp"
#include "work.hpp"

namespace loopstone::python {

/// What was made of a log, and what a folder of results tells beside.
struct Mapped {
  MapResult result{};
  RunInfo info{};
  std::optional<FloorTexture> texture{};
  std::optional<LandmarkMapping> landmarks{};  ///< where they were asked for
  RobotModel robot{};                          ///< that the map was made with
  /// What the map can be gone on from, or edited: where it was to be kept.
  std::shared_ptr<const Session> state{};
  std::optional<EditOutputs> edits{};  ///< of a map that somebody edited
  std::optional<SiteFigures> site{};   ///< of the map of a site, with its grids

  // What is worked out when it is asked for; behind `mutex`.
  std::mutex mutex{};
  std::vector<double> covariances{};  ///< of the trajectory, 3 x 3 each
};

/// Who called this off: Ctrl-C, or a progress callback that raised. Nobody sees it.
struct CalledOff {};

/// Who waits for the work looks on, and may call it off.
[[nodiscard]] ReadingWatch watch_by(Work& work);

/// What belongs to a mapping beside log and options.
struct MappingPlan {
  LogCut cut{};
  Threads threads{};
  bool texture = true;  ///< the floor in colour, when the log has RGB-D
  std::optional<LandmarkMappingOptions> landmarks{};  ///< nothing: they are not asked for
  bool keep_state = false;
  std::shared_ptr<const Session> goes_on_with{};
  std::string goes_on_from{};  ///< what that is called in errors
};

/// As `loopstone map` does it: the same bytes. Throws DataError, UsageError, CalledOff.
[[nodiscard]] std::shared_ptr<Mapped> map_log(const Log& log, MapOptions options,
                                              const MappingPlan& plan, Work& work);

/// The same of messages that are there already; of the plan what belongs to them.
[[nodiscard]] std::shared_ptr<Mapped> map_messages(const std::vector<SensorMessage>& messages,
                                                   const RobotModel& robot, MapOptions options,
                                                   const MappingPlan& plan, Work& work);

/// What is known of every run.
/// \param options    effective
/// \param landmarks  and those of landmarks, where they are asked for
[[nodiscard]] RunInfo run_info(MapOptions options, Threads threads,
                               const std::optional<LandmarkMappingOptions>& landmarks = {});

/// Not more cells than the machine may hold.
void limit_cells(MapOptions& options);

}  // namespace loopstone::python
