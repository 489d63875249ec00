#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "loopstone/base/options.hpp"
#include "loopstone/mapping/submap.hpp"
#include "loopstone/registration/grid_matcher.hpp"
#include "loopstone/registration/match_result.hpp"
#include "loopstone/sensor/laser_scan.hpp"
#include "loopstone/sensor/scan_points.hpp"
#include "loopstone/slam/finished_submap.hpp"
#include "loopstone/slam/laser_check.hpp"
#include "loopstone/slam/laser_cover.hpp"
#include "loopstone/slam/motion_predictor.hpp"
#include "loopstone/slam/path_break.hpp"
#include "loopstone/slam/tracking_status.hpp"
#include "loopstone/slam/travelling_things.hpp"
#include "loopstone/slam/untold_reach.hpp"

namespace loopstone {

enum class OdometryUse {
  kCheck,  ///< used while it agrees with the laser
  kTrust,  ///< used always
  kIgnore,
};

constexpr auto words_of(OdometryUse /*any*/) {
  using enum OdometryUse;
  return std::array{Word{kCheck, "check"}, Word{kTrust, "trust"}, Word{kIgnore, "ignore"}};
}

struct FrontEndOptions {
  double range_max_m = 60.0;
  int points_max = 360;
  double key_distance_m = 0.15;
  double key_angle_rad = 0.12;
  double submap_length_m = 8.0;
  double trusted_score = 0.6;
  double search_half_xy_m = 0.6;
  double search_half_yaw_rad = 0.5;
  OdometryUse odometry = OdometryUse::kCheck;
};

template <typename Visitor>
void visit_options(FrontEndOptions& options, Visitor&& visit) {
  visit("range_max_m", options.range_max_m, Range{0.5, 1000.0},
        "farther returns are not used for matching");
  visit("points_max", options.points_max, Range{20, 10000},
        "points of a scan that are matched, after thinning");
  visit("key_distance_m", options.key_distance_m, Range{0.01, 5.0},
        "a key scan after so much travel");
  visit("key_angle_rad", options.key_angle_rad, Range{0.01, 3.2}, "or after so much turning");
  visit("submap_length_m", options.submap_length_m, Range{0.5, 100.0},
        "travel that fills a submap; the next one starts at half of it");
  visit("trusted_score", options.trusted_score, Range{0.0, 1.0},
        "a match that explains less of the scan is checked by a search");
  visit("search_half_xy_m", options.search_half_xy_m, Range{0.1, 10.0},
        "half side of the window of that search");
  visit("search_half_yaw_rad", options.search_half_yaw_rad, Range{0.01, 3.2},
        "half heading range of that search");
  visit("odometry", options.odometry,
        "used while it agrees with the laser, used always, or not at all");
}

/// What the front end says of one scan.
struct TrackedScan {
  bool used = false;    ///< false: too few returns; the pose is the prediction
  Pose2 local_T_robot;  ///< smooth, drifts
  Eigen::Matrix3d covariance =
      Eigen::Matrix3d::Zero();  ///< of the match, (x, y, yaw) in the local frame
  MatchStatus status = MatchStatus::kTooFewPairs;
  TrackingStatus tracking = TrackingStatus::kLost;
  Pose2 guess_local_T_robot;  ///< before the laser was asked
  double score = 0.0;
  bool searched = false;
  bool left_out =
      false;  ///< it contradicts the map wherever it was looked for: the pose is a guess
  std::vector<bool> taken_out{};  ///< beams that do not show the surroundings; empty: none
  bool key = false;
  bool starts_submap = false;
  std::optional<PathBreak> path_break{};  ///< that ends with this scan
  std::vector<FinishedSubmap> finished;   ///< submaps that this scan filled
};

/// The last scan whose pose the laser held.
struct HeldScan {
  Stamp stamp{};
  Pose2 local_T_robot{};
  std::optional<OdometryReading> odometry{};
  double usual_seconds = 0.0;  ///< to the next one

  template <typename Archive>
  void archive(Archive& a) {
    a(stamp, local_T_robot, odometry, usual_seconds);
  }
};

/// What one laser of the robot saw last.
struct LaserView {
  int lidar = 0;
  Stamp stamp{};
  Pose2 local_T_robot{};
  std::vector<SurfacePoint> surfaces{};  ///< robot frame at that stamp
  std::size_t piece = 0;                 ///< in which it was mapped last
  Pose2 last_key{};

  template <typename Archive>
  void archive(Archive& a) {
    a(lidar, stamp, local_T_robot, surfaces, piece, last_key);
  }
};

/// Aligns each scan to the active submap and keeps the submaps going.
///
/// Frame `local`: that of the first scan; continuous, never corrected by loop closures.
///
/// Several lasers: each scan is aligned at its own time, together with what the others saw a moment
/// before, moved by the motion since; so lasers that look different ways hold one another. Each is
/// mapped from its own place.
///
/// Where the laser has not held the pose for a while, the next scan may show a place that no submap
/// knows. It stands where odometry says, unless it fits the active submap there; then a new piece
/// of the path begins with a submap of its own, tied to the piece before by odometry's motion and
/// its covariance alone. Without odometry the robot is looked for around where it was last; where
/// it isn't found, nothing but loop closures can tie the new piece.
class FrontEnd {
 public:
  /// \param odometry_scale  RobotModel::odometry_scale
  FrontEnd(const FrontEndOptions& options, const GridMatchOptions& match,
           const SubmapOptions& submap, double odometry_scale = 1.0);

  /// \param odometry  dead reckoning at the scan's stamp, if there is any
  [[nodiscard]] TrackedScan add(const LaserScan& scan, const Pose2& robot_T_lidar,
                                std::optional<OdometryReading> odometry);

  /// How odometry fared beside the laser.
  [[nodiscard]] const OdometryCheck& odometry_check() const { return predictor_.check(); }
  /// From now on odometry is read at another time than was found late.
  void forget_lag() { predictor_.forget_lag(); }
  [[nodiscard]] const LaserCheck& laser_check() const { return laser_check_; }

  /// FrozenSubmap::lies_within() of the submaps still open.
  [[nodiscard]] bool submaps_lie_within(double reach_m) const;

  /// Another drive begins, of which nothing is known: the submaps still open end. The local frame
  /// begins anew with its first scan.
  [[nodiscard]] std::vector<FinishedSubmap> begin_drive();

  /// Whether the laser did not hold the pose any more in the end, and what carried it since.
  /// \param last      stamp of the last scan, with
  /// \param odometry  dead reckoning at that time, if there is any
  [[nodiscard]] std::optional<PathBreak> break_in_the_end(
      Stamp last, const std::optional<OdometryReading>& odometry) const;

  /// The submaps still open, as they are. Call once, at the end.
  [[nodiscard]] std::vector<FinishedSubmap> finish();

  struct State {
    /// A submap that is open.
    struct Active {
      Submap::State submap{};
      Pose2 local_T_submap{};
      std::size_t first_key = 0;
      double travelled_m = 0.0;

      template <typename Archive>
      void archive(Archive& a) {
        a(submap, local_T_submap, first_key, travelled_m);
      }
    };
    /// What the parts do not have.
    struct Own {
      std::size_t key_count = 0;
      Pose2 last_key{};
      int lost_in_a_row = 0;
      double usual_score = 1.0;  ///< of the scans so far, mean over some tens
      std::optional<HeldScan> held{};
      std::size_t piece = 0;
      /// From where scans were settled to where odometry alone would have them, headings apart.
      Eigen::Vector2d local_to_ground_m = Eigen::Vector2d::Zero();

      template <typename Archive>
      void archive(Archive& a) {
        a(key_count, last_key, lost_in_a_row, usual_score, held, piece, local_to_ground_m);
      }
    };
    std::vector<Active> active{};  ///< oldest first
    MotionPredictor::State predictor{};
    LaserCheck::State laser_check{};
    TravellingThings::State travelling{};
    std::vector<LaserView> views{};  ///< one a laser
    Own own{};

    template <typename Archive>
    void archive(Archive& a) {
      a(active, predictor, laser_check, travelling, views, own);
    }
  };

  [[nodiscard]] State state() const;
  /// Throws UsageError when nothing can have led to it with these options; then the front end is of
  /// no use.
  void restore(State state);

 private:
  struct ActiveSubmap {
    Submap submap;
    Pose2 local_T_submap;
    std::size_t first_key;
    double travelled_m;
  };
  struct Alignment {
    MatchResult match;  ///< local frame
    bool searched = false;
    bool overruled = false;  ///< it is not what the likeliest guess led to: that was wrong
    bool lost =
        false;  ///< the scan contradicts the submap wherever it was looked for; the pose is a guess
  };

  using Seen = MotionPredictor::Seen;
  /// A scan, and what is known of it before it is aligned.
  struct Sighting {
    const LaserScan* scan;  ///< without the beams that were taken out
    const Pose2& robot_T_lidar;
    const std::optional<OdometryReading>& odometry;
    std::vector<MotionGuess> guesses;  ///< at least one
    bool believed = false;             ///< the laser shows its surroundings
    LaserCover cover{};                ///< was taken out of `scan`
    bool is_crowded = false;           ///< asked where odometry may lead, and says that it drives
    bool is_led = false;  ///< what travels was taken out, too: odometry holds the robot
    /// Where nothing but who goes with the robot would hold it: odometry alone does, robot frame.
    std::optional<Eigen::Vector2d> led_along{};
    const LaserScan* whole = nullptr;  ///< as it came
    bool is_driven = false;  ///< odometry that has proved itself says that the robot moves
    std::vector<SurfacePoint> surfaces{};  ///< its own, then those of other lasers
    std::size_t own_count = 0;
    bool is_new_laser = false;  ///< nothing that it saw is mapped yet, but what others see is

    [[nodiscard]] const MotionGuess& likeliest() const { return guesses.front(); }
    [[nodiscard]] std::span<const SurfacePoint> own() const {
      return std::span(surfaces).first(own_count);
    }
    /// What is aligned to the submap.
    [[nodiscard]] std::span<const SurfacePoint> matched() const {
      return std::span(surfaces).subspan(is_new_laser ? own_count : 0);
    }
  };

  // The steps of add(), in their order.
  /// What of a scan shows the laser's cover, or people about the robot.
  [[nodiscard]] LaserCover cover_of(const LaserScan& scan, const Pose2& robot_T_lidar,
                                    std::span<const MotionGuess> guesses);
  [[nodiscard]] Sighting prepare(const LaserScan& scan, const Pose2& robot_T_lidar,
                                 const std::optional<OdometryReading>& odometry);
  [[nodiscard]] static TrackedScan predicted(const Sighting& sighting);
  [[nodiscard]] Seen place(Sighting& sighting, TrackedScan& tracked);
  [[nodiscard]] Seen follow(Sighting& sighting, TrackedScan& tracked);
  void give_up_or_ride(const Sighting& sighting, TrackedScan& tracked);
  void keep(const Sighting& sighting, TrackedScan& tracked, Seen seen);
  void insert(const Sighting& sighting, TrackedScan& tracked);

  void show_rest(const LaserScan& scan, Sighting& sighting);
  [[nodiscard]] bool odometry_may_lead() const;
  [[nodiscard]] bool is_crowded(const LaserScan& scan) const;
  void take_out_travelling(const LaserScan& scan, Sighting& sighting);
  // Who is at fault where laser and odometry disagree (front_end_contest.cpp).
  [[nodiscard]] bool is_driven(const Sighting& sighting) const;
  [[nodiscard]] bool is_said_to_drive(const Sighting& sighting) const;
  [[nodiscard]] bool explains_less(const Alignment& alignment) const;
  [[nodiscard]] static bool agrees(const Alignment& alignment, const Sighting& sighting);
  [[nodiscard]] bool leaps(const Alignment& alignment, const Sighting& sighting) const;
  [[nodiscard]] bool is_believed(const Alignment& alignment, const Sighting& sighting) const;
  void take_out_new(Sighting& sighting);
  [[nodiscard]] Alignment contest(Sighting& sighting);
  [[nodiscard]] Alignment lead(const Sighting& sighting) const;
  void straighten(Sighting& sighting, const Tangent2& velocity);
  /// Adds what other lasers saw a moment before.
  void add_companions(Sighting& sighting) const;
  void remember(const Sighting& sighting, const TrackedScan& tracked);
  void remember_ground(const LaserScan& scan, const Sighting& sighting, const TrackedScan& tracked);
  [[nodiscard]] const LaserView* view_of(int lidar) const;
  [[nodiscard]] std::vector<SurfacePoint> surfaces_of(const LaserScan& scan,
                                                      const Pose2& robot_T_lidar,
                                                      const Tangent2& velocity);
  /// \param others       guesses that are tried when none of the first explains what scans usually
  ///                     do
  /// \param may_outvote  a match far from its guess shows that the guess was wrong
  [[nodiscard]] Alignment align(std::span<const SurfacePoint> surfaces,
                                std::span<const MotionGuess> guesses,
                                std::span<const MotionGuess> others, bool may_outvote) const;
  struct Searched {
    MatchResult match;  ///< submap frame
    bool lost = false;
  };
  /// Odometry drives into what nobody saw before: that contradicts nothing.
  [[nodiscard]] bool is_unfamiliar(std::span<const Eigen::Vector2d> points, const MaxPyramid& known,
                                   const PosePrior2& prior) const;
  [[nodiscard]] Searched search(std::span<const SurfacePoint> surfaces,
                                std::span<const PosePrior2> priors,
                                const MatchResult& matched) const;
  /// The motion since the laser last held the pose.
  struct BlindMotion {
    PosePrior2 prior{};       ///< local frame
    double odometry_m = 0.0;  ///< path that odometry tells, where it can be trusted
    double odometry_rad = 0.0;
    std::optional<UntoldReach> reach{};  ///< where odometry was silent; local frame

    /// Odometry says that the robot hardly moved: the scan is aligned as any other.
    [[nodiscard]] bool is_short() const;
  };

  void hold(Stamp stamp, const Pose2& local_T_robot,
            const std::optional<OdometryReading>& odometry);
  /// The laser has not held the pose for long enough that the motion can't be followed.
  [[nodiscard]] bool is_gap(Stamp stamp) const;
  [[nodiscard]] double longest_step_s() const;
  [[nodiscard]] BlindMotion blind_motion(Stamp stamp, const MotionGuess& guess,
                                         const std::optional<OdometryReading>& odometry) const;
  [[nodiscard]] BlindMotion untold_motion(Stamp stamp, const MotionGuess& guess,
                                          const std::optional<OdometryReading>& odometry) const;
  /// The scan on the active submap, from where it is expected; both in the submap's frame.
  [[nodiscard]] MatchResult match_at(std::span<const SurfacePoint> surfaces,
                                     const PosePrior2& there) const;
  /// What the laser alone would have said, but for a direction that it leaves open.
  [[nodiscard]] bool fits_along(const MatchResult& match, const PosePrior2& there) const;
  /// A match of the scan near where odometry says, if that can be told; in the local frame.
  [[nodiscard]] std::optional<MatchResult> recognise_near(std::span<const SurfacePoint> surfaces,
                                                          const MatchResult& match,
                                                          const PosePrior2& there) const;
  /// Whether the scan shows what scans usually do, or as much of what is known there.
  [[nodiscard]] bool explains(const MatchResult& match, std::span<const SurfacePoint> surfaces,
                              const MaxPyramid& known) const;
  /// The same without odometry: as far around as the robot may be.
  [[nodiscard]] std::optional<MatchResult> recognise_around(std::span<const SurfacePoint> surfaces,
                                                            const PosePrior2& prior) const;
  /// Where a scan may have been taken.
  struct Place {
    MatchResult match{};    ///< submap frame
    double value = 0.0;     ///< what speaks for it: the share that it explains, or that is new,
                            ///< less what its distance from the expected one speaks against it
    double turn_rad = 0.0;  ///< from the middle of the reach
    bool explains = false;
  };
  [[nodiscard]] std::vector<Place> places_within(std::span<const SurfacePoint> surfaces,
                                                 const UntoldReach& reach,
                                                 const PosePrior2& expected) const;
  /// Where a robot may be that drove on.
  struct Ahead {
    std::optional<MatchResult> match{};  ///< where it most likely is
    double value = 0.0;                  ///< of that place
    bool explains = false;               ///< the scan does fit there
    bool is_likely = false;              ///< or what it shows of the known, if the robot drove
    bool faces_certainly = false;        ///< likely, and nowhere else facing another way
    bool is_only = false;                ///< likely, and nowhere else at all
    [[nodiscard]] bool is_certain() const { return explains && is_only; }
  };
  /// The same where a robot drove on that nothing told of: part of what it sees may be new.
  [[nodiscard]] Ahead look_ahead(std::span<const SurfacePoint> surfaces, const UntoldReach& reach,
                                 const PosePrior2& expected) const;
  [[nodiscard]] Seen rejoin(std::span<const SurfacePoint> surfaces, BlindMotion blind, Stamp stamp,
                            TrackedScan& tracked);
  /// As far as somebody walks with it in the time, or across a room, facing any way that odometry
  /// would not have felt.
  [[nodiscard]] UntoldReach carried_from(const Pose2& local_T_robot, Stamp stamp) const;
  /// Where it was carried to, if that can be told; else the prior is what can.
  [[nodiscard]] std::optional<MatchResult> find_carried(std::span<const SurfacePoint> surfaces,
                                                        Stamp stamp, PosePrior2& prior) const;
  [[nodiscard]] bool was_carried(std::span<const SurfacePoint> surfaces, const BlindMotion& blind,
                                 Stamp stamp) const;
  void turn_to_match(std::span<const SurfacePoint> surfaces, const Ahead& ahead,
                     const UntoldReach& reach, PosePrior2& prior) const;
  [[nodiscard]] Seen take_match(const MatchResult& match, bool is_held, TrackedScan& tracked);
  /// The motion goes on as it was: where odometry may be doubted.
  [[nodiscard]] std::vector<MotionGuess> others_than_odometry(Stamp stamp) const;
  [[nodiscard]] TrackingStatus tracking_of(const TrackedScan& tracked, bool odometry_guides,
                                           Stamp stamp) const;
  /// Odometry says that the robot hardly moved.
  [[nodiscard]] bool stood(const BlindMotion& blind) const;
  /// And nobody saw it for so long that somebody may have carried it.
  [[nodiscard]] bool rested(const BlindMotion& blind, Stamp stamp) const;
  /// A piece that begins where the scan was matched, which may be anywhere along what it leaves
  /// open.
  Seen begin_along(const MatchResult& match, BlindMotion blind, Stamp stamp, TrackedScan& tracked);
  /// The first scan after somebody carried the robot while the laser left open how far.
  [[nodiscard]] Seen set_down(const Lift& lift, Sighting& sighting, TrackedScan& tracked);
  void note_gap(const BlindMotion& blind, BreakCause cause, Stamp stamp,
                TrackedScan& tracked) const;
  void begin_piece(const BlindMotion& blind, BreakCause cause, Stamp stamp, TrackedScan& tracked);
  /// Ends the submaps that are open.
  [[nodiscard]] std::vector<FinishedSubmap> end_piece();
  /// What is said in the local frame, as the submap that scans are aligned to has it; and back.
  [[nodiscard]] PosePrior2 in_submap(const PosePrior2& prior) const;
  [[nodiscard]] MatchResult in_local(MatchResult match) const;

  /// Constant from the last scan's pose to this one [m/s, m/s, rad/s], robot frame.
  [[nodiscard]] Tangent2 velocity_to(const Pose2& local_T_robot, const LaserScan& scan) const;
  /// Since this laser was mapped last.
  [[nodiscard]] bool moved_enough(int lidar, const Pose2& local_T_robot) const;
  /// A scan that explains less, by much less than usual, shows another place.
  [[nodiscard]] double least_score() const;

  FrontEndOptions options_;
  GridMatchOptions match_options_;
  SubmapOptions submap_options_;
  double odometry_scale_;
  BeamTable beams_{};
  std::vector<ActiveSubmap> active_{};  ///< oldest first; the oldest is what scans are aligned to
  MotionPredictor predictor_;
  LaserCheck laser_check_{};
  TravellingThings travelling_{};
  LaserScan uncovered_{};  ///< of a scan that was covered in part, the rest
  std::vector<LaserView> views_{};
  State::Own own_{};
};

}  // namespace loopstone
