#pragma once

#include <memory>
#include <optional>

#include "loopstone/localization/landmark_map.hpp"
#include "loopstone/localization/landmark_tracking_options.hpp"
#include "loopstone/localization/localization_result.hpp"
#include "loopstone/localization/localizer.hpp"
#include "loopstone/sensor/landmark_reading.hpp"
#include "loopstone/sensor/messages.hpp"
#include "loopstone/sensor/robot_model.hpp"

namespace loopstone {

/// Follows a robot among landmarks of known places, by reflectors in its scans or by readings of
/// range and bearing: motion by odometry, a reading taken into every place that the robot may be at
/// (LandmarkBelief), and a search of the whole map by constellations (ConstellationIndex) while
/// there is no such place.
///
///   LandmarkTracker tracker(LandmarkMap(read_landmarks("landmarks.csv")), robot, {}, {});
///   while (auto message = log.next()) tracker.add(*message);
///   LocalizationResult result = tracker.finish();
///
/// The result holds what that of a Localizer does. Of the evidence, `explained` is the share of
/// what was seen lately that is of a landmark, `innovation` chi-square per degree of freedom;
/// `violations` and `unexpected` are 0. The same input gives the same bytes; nothing is drawn by
/// chance.
class LandmarkTracker {
 public:
  /// \param initial  about where the robot is at the first reading; nothing: anywhere
  /// Throws OptionsError with everything that is wrong with the options, UsageError for a map of
  /// too many landmarks.
  LandmarkTracker(LandmarkMap map, const RobotModel& robot, const LandmarkTrackingOptions& options,
                  const std::optional<InitialPose>& initial);
  ~LandmarkTracker();
  LandmarkTracker(LandmarkTracker&&) noexcept;
  LandmarkTracker& operator=(LandmarkTracker&&) noexcept;

  /// Odometry, and scans with intensities. A scan waits for odometry of its time, at most 0.25 s.
  void add(const SensorMessage& message);
  /// A reading of another sensor. It waits for odometry of its time, so that all of a drive may be
  /// given before the odometry; where there is none, until the end. Those that are not newer than
  /// the last are left out.
  void add(const LandmarkReading& reading);

  /// The oldest estimate that was not handed out yet: one a reading, from the first pose on.
  [[nodiscard]] std::optional<LocalizationEstimate> next_update();

  /// Ends the recording. Call once.
  [[nodiscard]] LocalizationResult finish();

  /// Scans that came with intensities.
  [[nodiscard]] std::int64_t scans_with_intensities() const;
  /// What was seen that may be a landmark, in all readings together.
  [[nodiscard]] std::int64_t observations() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace loopstone
