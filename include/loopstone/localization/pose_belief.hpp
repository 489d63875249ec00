#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "loopstone/base/options.hpp"
#include "loopstone/base/parallel_for.hpp"
#include "loopstone/base/rng.hpp"
#include "loopstone/geometry/pose2.hpp"
#include "loopstone/localization/injection.hpp"
#include "loopstone/localization/particle_filter.hpp"
#include "loopstone/localization/resampling.hpp"

namespace loopstone {

struct PoseBeliefOptions {
  int particles_max = 2000;  ///< of all places together
  int particles_min = 100;   ///< of each place
  ResamplingScheme resampling = ResamplingScheme::kSystematic;
  double bin_m = 0.1;  ///< of the histogram that decides how many particles a place needs
  double bin_rad = 0.09;
  double kld_epsilon = 0.05;    ///< Kullback-Leibler distance to that histogram ...
  double kld_quantile = 2.326;  ///< ... which is kept with 99 % probability
  double gap_m =
      /// particles this far apart in position, or that far in heading, with none between, are two
      /// places
      0.35;
  double gap_rad = 0.3;
  double negligible = 1e-4;  ///< places believed in less are dropped
  int places_max = 60;       ///< and those beyond so many
};

/// A place where the robot may be: a cloud of particles and the belief in it.
struct PlaceBelief {
  int id = 0;  ///< stays while the place lives; new places count up
  ParticleFilter<Pose2> particles;
  double log_mass = 0.0;  ///< the exponentials over all places sum to one
  /// Mean of the particles and their covariance (x, y, yaw), map axes.
  PoseWithCovariance2 moments{};
  std::optional<double> log_evidence{};  ///< of the scan since the last settling, for one reading
  AugmentedInjection injection{0.05, 0.4};
};

/// Which poses belong together: those in the same or neighbouring cells of a lattice, and so on.
/// One label a pose, counted from 0 in the order of first appearance. Cost: O(poses) on average.
[[nodiscard]] std::vector<int> group_poses(std::span<const Pose2> poses, double cell_m,
                                           double cell_rad);

/// What is believed of the robot's pose: a mixture of places, each with particles of its own.
///
/// Particles of one filter that are drawn anew from all over the map drift into one of several
/// places that explain the readings equally well, by chance. Here a place loses particles to its
/// own alone, and the belief in each place changes by what the readings say and by nothing else.
/// Places that grow together become one, a cloud that falls apart becomes several.
/// Source: Vermaak, Doucet and Perez 2003, "Maintaining multi-modality through mixture tracking",
/// equations 8 to 13.
class PoseBelief {
 public:
  /// Log-likelihoods of a scan at many poses.
  using SensorModel =
      std::function<void(std::span<const Pose2> map_T_robot, std::span<double> out)>;
  /// A pose after the robot's motion, drawn from the motion model.
  using MotionModel = std::function<Pose2(const Pose2& map_T_robot, Rng& noise)>;

  PoseBelief(const PoseBeliefOptions& options, std::uint64_t seed, Threads threads)
      : options_(options), rng_(seed), threads_(threads) {}

  /// A place to believe in, before or beside the others.
  struct Proposal {
    PoseWithCovariance2 map_T_robot;  ///< particles are drawn from this
    double log_mass = 0.0;            ///< against the other proposals
  };
  /// Gives `share` of the belief to new places; all of it when there are none yet. Proposals that
  /// fall where the belief already has particles add to them.
  void add(std::span<const Proposal> proposals, double share);
  /// As if nothing had been believed yet.
  void forget() { places_.clear(); }

  void predict(const MotionModel& motion);

  /// Weighs all particles of each place against each other, and the places by their evidence. Where
  /// no particle can explain the scan, nothing changes.
  /// \param readings  independent ones that the log-likelihoods add up: what belongs to one of them
  ///                  tells how well a place explains scans
  /// \param evidence  log-likelihood of the scan in a place as a whole; without it the mean over
  ///                  its particles, which is noisy where they are few
  void update(const SensorModel& sensor, double readings = 1.0,
              const std::function<double(const PlaceBelief&)>& evidence = {});

  /// Joins and parts places, drops negligible ones, draws particles anew where weights have become
  /// uneven, and where a place explains scans worse than it used to, some of them widely around it.
  /// \param spread  the last: false where the robot can be looked for in better ways
  void settle(bool spread = true);

  /// The most probable first.
  [[nodiscard]] const std::vector<PlaceBelief>& places() const { return places_; }
  [[nodiscard]] bool empty() const { return places_.empty(); }
  [[nodiscard]] std::size_t particle_count() const;
  /// Of all places; those of the most probable first.
  [[nodiscard]] std::vector<Pose2> particles() const;

 private:
  [[nodiscard]] std::vector<Pose2> draw(const PoseWithCovariance2& from, std::size_t count);
  void regroup();
  /// Takes new masses, scaled to sum to one; nothing changes when all of them are zero.
  void take_masses(std::span<const double> log_masses);

  PoseBeliefOptions options_;
  Rng rng_;
  Threads threads_;
  std::vector<PlaceBelief> places_{};
  int next_id_ = 0;
};

}  // namespace loopstone
