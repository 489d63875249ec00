#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "app.hpp"
#include "floor_run.hpp"
#include "interrupt.hpp"
#include "live_view.hpp"
#include "log_run.hpp"
#include "loopstone/base/words.hpp"
#include "loopstone/live/map_feed.hpp"
#include "loopstone/localization/landmark_mapping_options.hpp"
#include "loopstone/localization/reflector_mapping.hpp"
#include "loopstone/mapping/floor_texture.hpp"
#include "loopstone/pipeline/log_landmarks.hpp"
#include "loopstone/pipeline/log_mapping.hpp"
#include "loopstone/sensor/robot_model.hpp"
#include "loopstone/slam/calibration.hpp"
#include "loopstone/slam/map_options.hpp"
#include "loopstone/slam/map_result.hpp"
#include "loopstone/slam/scan_to_scan.hpp"
#include "pace.hpp"
#include "progress_display.hpp"
#include "run_recording.hpp"
#include "session_folder.hpp"

namespace loopstone::app {

enum class Pipeline { kSubmaps, kScanToScan };

constexpr auto words_of(Pipeline /*any*/) {
  using enum Pipeline;
  return std::array{Word{kSubmaps, "submaps"}, Word{kScanToScan, "scan_to_scan"}};
}

/// What a user says of landmarks whose places are to be found.
struct LandmarkMapFlags {
  bool on = false;
  bool nameless = false;               ///< identities of what was seen are not used
  std::optional<double> brightness{};  ///< of a beam on a reflector
};

struct MapArguments {
  std::string log;
  std::string out;
  std::string mcap;  ///< empty: no recording of the run
  Pipeline pipeline = Pipeline::kSubmaps;
  LogCut cut;
  std::optional<OdometryUse> odometry;
  bool no_loop_closure = false;
  bool no_calibration = false;
  bool no_texture = false;
  bool cloud = false;
  bool force = false;
  LogFlags reading;
  double realtime = 0.0;  ///< speed of the replay; 0: as fast as it goes
  CheckpointFlags checkpoint;
  ContinueFlags drives;
  LandmarkMapFlags landmarks;
  bool view = false;
  ViewFlags view_flags;
};

/// A map beyond what the machine or --max-memory allows is drawn with wider cells.
[[nodiscard]] std::uint64_t most_cells(const AppContext& context);

/// To the mapper, and to who looks on if there is somebody.
void add_watched(const SensorMessage& message, MapFeed* feed, Mapper& mapper);

/// Those of the file and of --set, and --reflector-threshold over them. Throws OptionsError.
[[nodiscard]] LandmarkMapOptions landmark_map_options(const LandmarkMapFlags& flags,
                                                      const AppContext& context);

/// How a log becomes a map: which pipeline, with which options. The choice is made here alone.
class MapPipeline {
 public:
  /// Throws UsageError for flags that the pipeline has no use for, and as load_options() does.
  MapPipeline(const MapArguments& arguments, const AppContext& context);

  [[nodiscard]] std::string options_toml();
  [[nodiscard]] TextureOptions texture() const;
  [[nodiscard]] const OccupancyOptions& map_options() const;
  /// Whether a run can be known by its terms, and gone on with.
  [[nodiscard]] bool has_sessions() const { return std::holds_alternative<MapOptions>(options_); }

  struct Source {
    CutLog& log;
    CameraFrames& camera;
    Checkpoint& checkpoint;
    std::optional<Pace>& pace;
    ProgressDisplay& display;
    RunRecording& recording;
    MapFeed* feed = nullptr;  ///< who looks on, if anybody
    std::string out;          ///< the session is there
    bool resumes = false;
    std::string continues{};                   ///< the folder of drives before this one
    std::optional<MapperState> begins_with{};  ///< and what they led to
    bool keeps_state = false;
  };
  /// Reads the log to its end, or until the user interrupts.
  /// A result that is_bent() has nothing but its calibration: see map_anew().
  /// \param held  set once there is something that Ctrl-C must not lose
  /// \param kept  what the log has led to, where it is to be kept
  [[nodiscard]] MapResult map(Source source, const RobotModel& robot, Threads threads,
                              std::optional<HeldInterrupt>& held, std::optional<MapperState>& kept);
  /// DriveMapping::is_bent()
  [[nodiscard]] bool is_bent() const { return mapping_ && mapping_->is_bent(); }
  /// The same log once more, with the beams that the first map's calibration asks for; a state
  /// that is kept is made anew, too.
  [[nodiscard]] MapResult map_anew(CutLog& log);
  /// The robot that the map was made with: the log's, or a corrected one.
  [[nodiscard]] const RobotModel& made_by(const RobotModel& robot) const {
    return mapping_ ? mapping_->robot() : robot;
  }
  /// What the map's warnings say of that correction.
  [[nodiscard]] std::vector<std::string> corrections() const {
    return mapping_ ? mapping_->corrections() : std::vector<std::string>{};
  }
  /// What the last map has of landmarks; nothing when they are not asked for. Where the log can't
  /// show any `failure` says why; where there are none, the map's warnings.
  [[nodiscard]] std::optional<LandmarkMapping> landmarks_of(MapResult& result,
                                                            std::string& failure) const;

 private:
  const AppContext& context_;
  std::variant<MapOptions, ScanToScanOptions> options_;
  std::optional<LandmarkMappingOptions> landmarks_{};  ///< nothing: they are not asked for
  std::optional<ReflectorMapper> reflectors_{};        ///< of the map in the making
  std::unique_ptr<MappingWatch> watch_{};
  std::optional<DriveMapping> mapping_{};  ///< of submaps
};

}  // namespace loopstone::app
