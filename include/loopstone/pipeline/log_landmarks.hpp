#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "loopstone/base/memory_budget.hpp"
#include "loopstone/formats/left_out.hpp"
#include "loopstone/formats/mrclam.hpp"
#include "loopstone/localization/landmark_map.hpp"
#include "loopstone/localization/landmark_mapping.hpp"
#include "loopstone/localization/landmark_mapping_options.hpp"
#include "loopstone/localization/landmark_tracking_options.hpp"
#include "loopstone/localization/reflector_mapping.hpp"
#include "loopstone/pipeline/cut_log.hpp"
#include "loopstone/pipeline/log_localization.hpp"
#include "loopstone/pipeline/log_source.hpp"
#include "loopstone/sensor/landmark_reading.hpp"
#include "loopstone/sensor/robot_model.hpp"
#include "loopstone/slam/map_options.hpp"
#include "loopstone/slam/map_result.hpp"

// Logs with landmarks: reflectors in scans, told by their brightness, and the sightings of MRCLAM's
// folders. What `loopstone map --landmarks` and `loopstone localize --landmarks` make of them.

namespace loopstone {

/// The options of `map --landmarks`.
struct LandmarkMapOptions {
  MapOptions map{};
  LandmarkMappingOptions landmarks{};
};

template <typename Visitor>
void visit_options(LandmarkMapOptions& options, Visitor&& visit) {
  visit_options(options.map, visit);
  visit.group("landmarks", options.landmarks);
}

/// What a map has of landmarks.
struct MapLandmarks {
  LandmarkMapping mapping{};
  std::string failure{};  ///< why the log can't show any; empty: it can
  std::string warning{};  ///< that there are none, and why; empty: there are
};

/// \param reflectors  that the finished map was made with
[[nodiscard]] MapLandmarks landmarks_of(const ReflectorMapper& reflectors, const MapResult& result);

/// Where the robot of a log was among landmarks of known places, by the reflectors in its scans:
/// `loopstone localize LOG --landmarks FILE`, without what that writes. What was called off has a
/// result that is not complete.
/// \param reader  of the source, at its beginning; it must read intensities
/// Throws DataError when nothing can be made of the log: no scan has intensities, or no beam is
/// bright enough; and as LandmarkTracker does.
[[nodiscard]] LogLocalization localize_by_reflectors(const LogSource& source, LogReader& reader,
                                                     const LandmarkMap& landmarks,
                                                     const LandmarkTrackingOptions& options,
                                                     const std::optional<InitialPose>& initial,
                                                     const LogCut& cut,
                                                     const ReadingWatch& watch = {});

/// A drive of MRCLAM's.
/// \param how  its noise is that of `noise`
/// Throws DataError where none of what was seen is a landmark, and as read_mrclam_log() does.
[[nodiscard]] MrclamLog read_mrclam_drive(const std::string& path, MrclamOptions how,
                                          const SightingNoise& noise, const MemoryBudget& budget);

/// Readings within the cut, of which `max_scans` counts these.
/// \param nameless  identities of what was seen are left out
[[nodiscard]] std::vector<LandmarkReading> readings_within(const MrclamLog& log, const LogCut& cut,
                                                           bool nameless);

/// How much was read of it, and what not.
[[nodiscard]] LeftOut left_out_of(const MrclamLog& log);

/// Where the robot of such a drive was among landmarks of known places.
/// \param readings  of the drive that are used: readings_within()
/// \param stop      asked again and again, true ends it; may be empty
/// Throws as LandmarkTracker does.
[[nodiscard]] LocalizationResult localize_mrclam(
    const MrclamLog& log, const std::vector<LandmarkReading>& readings, const RobotModel& robot,
    const LandmarkMap& landmarks, const LandmarkTrackingOptions& options,
    const std::optional<InitialPose>& initial, const std::function<bool()>& stop = {});

}  // namespace loopstone
