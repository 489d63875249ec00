#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "loopstone/base/option_list.hpp"
#include "loopstone/base/rng.hpp"
#include "loopstone/simulation/realism_laser.hpp"
#include "loopstone/simulation/realism_robot.hpp"
#include "loopstone/simulation/realism_surroundings.hpp"
#include "loopstone/simulation/world.hpp"

namespace loopstone {

/// Everything in which the real world is less kind than a simulation: each effect by itself, all
/// off by default. The field's name is the effect's name. Each draws from a stream of its own, so
/// that one more leaves the draws of the others as they were. Times count from the log's start.
struct Realism {
  RealismRange range{};
  RealismMixed mixed{};
  RealismDropouts dropouts{};
  RealismSteps steps{};
  RealismSweep sweep{};
  RealismMount mount{};
  RealismBlocked blocked{};
  RealismDirty dirty{};
  RealismUpsideDown upside_down{};
  RealismStamps stamps{};
  RealismLoss loss{};
  RealismWheels wheels{};
  RealismGyro gyro{};
  RealismRolling rolling{};
  RealismUneven uneven{};
  RealismCarried carried{};                     ///< the laser runs
  RealismCarried carried_blind{.at_s = 110.0};  ///< no scans come meanwhile
  RealismTurned turned{};
  RealismBent bent{};
  RealismMoved moved{};
  RealismStanders standers{};
  RealismWalkers walkers{};
  RealismFollower follower{};
  RealismAhead ahead{};
  RealismCrowd crowd{};
  RealismGlass glass{};
  RealismMirrors mirrors{};
};

template <typename Visitor>
void visit_options(Realism& options, Visitor&& visit) {
  visit.group("range", options.range);
  visit.group("mixed", options.mixed);
  visit.group("dropouts", options.dropouts);
  visit.group("steps", options.steps);
  visit.group("sweep", options.sweep);
  visit.group("mount", options.mount);
  visit.group("blocked", options.blocked);
  visit.group("dirty", options.dirty);
  visit.group("upside_down", options.upside_down);
  visit.group("stamps", options.stamps);
  visit.group("loss", options.loss);
  visit.group("wheels", options.wheels);
  visit.group("gyro", options.gyro);
  visit.group("rolling", options.rolling);
  visit.group("uneven", options.uneven);
  visit.group("carried", options.carried);
  visit.group("carried_blind", options.carried_blind);
  visit.group("turned", options.turned);
  visit.group("bent", options.bent);
  visit.group("moved", options.moved);
  visit.group("standers", options.standers);
  visit.group("walkers", options.walkers);
  visit.group("follower", options.follower);
  visit.group("ahead", options.ahead);
  visit.group("crowd", options.crowd);
  visit.group("glass", options.glass);
  visit.group("mirrors", options.mirrors);
}

/// The effects by name.
[[nodiscard]] std::vector<std::string> realism_names();
/// Those that are on.
[[nodiscard]] std::vector<std::string> realism_names(const Realism& realism);
/// What every robot has every day: the effects that are no event and no mistake of assembly.
[[nodiscard]] std::vector<std::string> usual_realism();

/// Turns on the effects that a list names, all others off: names with commas between them, "usual",
/// "all" or "none". Throws UsageError for another name.
void choose_realism(Realism& realism, std::string_view list);

/// The random numbers of one effect.
[[nodiscard]] Rng realism_stream(std::uint64_t seed, std::string_view effect);

/// A number that was drawn, or that only the simulation knows.
struct RealismFact {
  std::string effect;
  std::string name;  ///< with its unit
  double value = 0.0;
};

/// A stretch of the log that an effect spoils [s since its start].
struct RealismSpoil {
  std::string effect;
  double from_s = 0.0;
  double to_s = 0.0;
};

/// What was truly simulated, beyond the options.
struct RealismRecord {
  std::vector<RealismFact> facts{};
  std::vector<RealismSpoil> spoils{};
};

/// The world as `bent` and `turned` make it. For the caller of simulate(), who wants its true map.
[[nodiscard]] World real_world(World world, const Realism& realism, std::uint64_t seed,
                               RealismRecord& record);

}  // namespace loopstone
