#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "loopstone/base/stamp.hpp"
#include "loopstone/base/words.hpp"
#include "loopstone/sensor/laser_scan.hpp"
#include "loopstone/slam/motion_predictor.hpp"

namespace loopstone {

/// What the check of the laser decides by.
struct LaserCheckNumbers {
  double blocked_m = 0.35;
  double blocked_share = 0.8;
  int fewest_returns = 20;
  double moved_m = 0.05;
  double moved_rad = 0.05;
  float cover_m = 0.5F;
  double cover_share = 0.1;
  float stranger_m = 4.0F;
  double stranger_share = 0.15;
  float stranger_step_m = 0.3F;
  double rest_agrees = 0.6;
  double crowd_share = 0.3;
};
inline constexpr LaserCheckNumbers kLaserCheck{};

template <typename Visitor>
void visit_numbers(const LaserCheckNumbers& n, Visitor&& visit) {
  visit("blocked_m", n.blocked_m,
        "chosen: nearer than this there is nothing but the robot itself and what hangs over it");
  visit("blocked_share", n.blocked_share,
        "chosen: of the returns must be so near; a robot in a niche sees out of it");
  visit("fewest_returns", n.fewest_returns, "chosen: fewer say too little to be judged");
  visit("moved_m", n.moved_m,
        "chosen: odometry that moved so far says that the robot does not stand; far beyond what "
        "wheels tremble");
  visit("moved_rad", n.moved_rad, "chosen: as moved_m, of a point a metre off");
  visit("cover_m", n.cover_m,
        "chosen: what covers a laser in part, or crowds about it, is nearer than this");
  visit("cover_share", n.cover_share,
        "chosen: of the beams must end so near where the map is free; legs beside the robot are "
        "fewer");
  visit("stranger_m", n.stranger_m,
        "chosen: who goes with a robot is nearer than this; farther off a pose that is a little "
        "wrong puts walls into free space");
  visit("stranger_share", n.stranger_share,
        "chosen: of the beams must end in free space around; a passer-by takes less, and is "
        "outvoted in any match");
  visit("stranger_step_m", n.stranger_step_m,
        "chosen: beams beside one another show one thing unless their ranges differ by more");
  visit("rest_agrees", n.rest_agrees,
        "chosen: of the other returns must fall on known surfaces where the robot is expected, as "
        "trusted_score of a match; else it is elsewhere");
  visit("crowd_share", n.crowd_share,
        "chosen: strangers that take so much of the beams are worth a word");
}

/// What is wrong with the laser, as far as its scans tell.
enum class LaserFault {
  kBlocked,  ///< nearly all returns come from right in front of it
  kFrozen,   ///< the same scan to the last bit, while odometry says that the robot moves
  kCovered,  ///< many beams end around it where the map knows free space; the rest is used
};

constexpr auto words_of(LaserFault /*any*/) {
  using enum LaserFault;
  return std::array{Word{kBlocked, "blocked"}, Word{kFrozen, "frozen"}, Word{kCovered, "covered"}};
}

/// A time during which scans said nothing of the surroundings.
struct LaserEpisode {
  LaserFault fault = LaserFault::kBlocked;
  int lidar = 0;  ///< LaserScan::lidar
  Stamp from{};   ///< of the first scan that shows it
  Stamp to{};     ///< of the last one
  std::size_t scans = 0;
  double odometry_m = 0.0;    ///< travelled meanwhile, as odometry has it
  double odometry_rad = 0.0;  ///< turned

  template <typename Archive>
  void archive(Archive& a) {
    a(fault, lidar, from, to, scans, odometry_m, odometry_rad);
  }
};

/// Tells scans that show the laser's cover, or are one scan again and again, from those that show
/// the surroundings. (Whether it is covered in part, the map tells: laser_cover.hpp.)
///
/// A robot that stands still in a world without noise repeats itself too; so a scan counts as
/// frozen only once odometry has moved since the scan that it repeats. Without odometry nothing
/// tells the two apart; then repetition is counted and not judged.
/// Several lasers are told apart. Cost: one pass over the ranges. Deterministic.
class LaserCheck {
 public:
  /// Whether the scan can be believed; of one that is covered in part, the rest of it.
  /// \param odometry    at its stamp, if there is any
  /// \param is_covered  by what the map knows, part of it shows a cover
  [[nodiscard]] bool add(const LaserScan& scan, const std::optional<OdometryReading>& odometry,
                         bool is_covered = false);

  [[nodiscard]] const std::vector<LaserEpisode>& episodes() const { return state_.episodes; }
  /// Whether an episode goes on.
  [[nodiscard]] bool is_open(std::size_t episode) const;
  /// Whether any does.
  [[nodiscard]] bool is_faulty() const;
  /// Most scans in a row that were the same to the last bit while no odometry told whether the
  /// robot stood, the first one not counted.
  [[nodiscard]] std::size_t most_repeated() const { return state_.most_repeated; }

  /// What is known of one laser.
  struct Laser {
    int lidar = 0;
    std::vector<float> last_ranges_m{};
    std::optional<OdometryReading> repeated_since{};  ///< at the scan that is repeated
    std::size_t repeated = 0;
    std::optional<std::size_t> open{};       ///< its episode that goes on
    std::optional<OdometryReading> begun{};  ///< odometry when it began

    template <typename Archive>
    void archive(Archive& a) {
      a(lidar, last_ranges_m, repeated_since, repeated, open, begun);
    }
  };
  struct State {
    std::vector<LaserEpisode> episodes{};
    std::vector<Laser> lasers{};
    std::size_t most_repeated = 0;

    template <typename Archive>
    void archive(Archive& a) {
      a(episodes, lasers, most_repeated);
    }
  };

  [[nodiscard]] const State& state() const { return state_; }
  /// Throws UsageError when nothing can have led to it.
  void restore(State state);

 private:
  [[nodiscard]] Laser& laser_of(const LaserScan& scan);
  [[nodiscard]] std::optional<LaserFault> fault_of(const LaserScan& scan, Laser& laser,
                                                   const std::optional<OdometryReading>& odometry,
                                                   bool is_covered);
  [[nodiscard]] bool is_frozen(const LaserScan& scan, Laser& laser,
                               const std::optional<OdometryReading>& odometry);

  State state_{};
};

}  // namespace loopstone
