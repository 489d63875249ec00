#include "loopstone/localization/pose_belief.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <unordered_map>
#include <utility>

#include "loopstone/base/union_find.hpp"
#include "loopstone/geometry/angle.hpp"
#include "loopstone/grid/grid_frame.hpp"
#include "loopstone/localization/motion_models.hpp"
#include "loopstone/localization/renewal.hpp"
#include "loopstone/localization/weighted_moments.hpp"

namespace loopstone {

namespace {

/// A cell of positions and headings as one number: 26 bits for each coordinate of the position, 12
/// for the heading.
struct PoseCell {
  int x = 0;
  int y = 0;
  int yaw = 0;

  [[nodiscard]] std::uint64_t key() const {
    constexpr std::uint64_t kMask = (1U << 26U) - 1U;
    return ((static_cast<std::uint64_t>(x) & kMask) << 38U) |
           ((static_cast<std::uint64_t>(y) & kMask) << 12U) | static_cast<std::uint64_t>(yaw);
  }
};

/// Cells of headings divide the circle evenly.
class PoseLattice {
 public:
  PoseLattice(double cell_m, double cell_rad)
      : cell_m_(cell_m), headings_(std::max(1, static_cast<int>(2.0 * kPi / cell_rad))) {}

  [[nodiscard]] PoseCell cell_of(const Pose2& pose) const {
    const double turns = (pose.yaw + kPi) / (2.0 * kPi);
    return {floor_to_int(pose.x / cell_m_), floor_to_int(pose.y / cell_m_),
            wrapped(floor_to_int(turns * headings_))};
  }
  [[nodiscard]] int wrapped(int heading) const {
    return ((heading % headings_) + headings_) % headings_;
  }

 private:
  double cell_m_;
  int headings_;
};

/// Fresh particles come from so far around a place ...
constexpr double kInjectedM = 0.5;
constexpr double kInjectedRad = 0.35;
/// ... and replace no more than this share.
constexpr double kInjectedMost = 0.25;

GaussianMotion widely_around(const PoseWithCovariance2& moments) {
  Eigen::Matrix3d covariance = moments.covariance;
  covariance.diagonal() += Eigen::Vector3d(kInjectedM * kInjectedM, kInjectedM * kInjectedM,
                                           kInjectedRad * kInjectedRad);
  return {moments.pose, covariance};
}

/// Particles that belong together, and the places that they came from.
struct ParticleGroup {
  std::vector<Pose2> states{};
  std::vector<double> log_weights{};
  std::map<int, double> mass_by_id{};

  void add(int id, const Pose2& state, double log_weight) {
    states.push_back(state);
    log_weights.push_back(log_weight);
    mass_by_id[id] += std::exp(log_weight);
  }
  /// The place that most of the mass came from.
  [[nodiscard]] int heir() const {
    return std::max_element(mass_by_id.begin(), mass_by_id.end(),
                            [](const auto& a, const auto& b) { return a.second < b.second; })
        ->first;
  }
};

/// A few particles at the rim of a cloud are no place of their own: they go back to the cloud that
/// they came from.
void take_stragglers_in(std::vector<ParticleGroup>& groups) {
  constexpr std::size_t kFew = 10;
  std::map<int, std::size_t> largest;
  for (std::size_t i = 0; i < groups.size(); ++i) {
    const auto [found, fresh] = largest.try_emplace(groups[i].heir(), i);
    if (!fresh && groups[i].states.size() > groups[found->second].states.size()) found->second = i;
  }
  for (std::size_t i = 0; i < groups.size(); ++i) {
    const std::size_t home = largest.at(groups[i].heir());
    if (home == i || groups[i].states.size() >= kFew) continue;
    const int id = groups[i].heir();
    for (std::size_t k = 0; k < groups[i].states.size(); ++k)
      groups[home].add(id, groups[i].states[k], groups[i].log_weights[k]);
    groups[i] = {};
  }
}

/// Particles that belong together, whatever places they are of now.
std::vector<ParticleGroup> group_particles(std::span<const PlaceBelief> places, double gap_m,
                                           double gap_rad) {
  // Particles that are ruled out and wait to be drawn anew must not bridge the gap between two that
  // are not.
  constexpr double kRuledOut = 12.0;
  struct Origin {
    int id;
    double log_weight;
  };
  std::vector<Pose2> poses;
  std::vector<Origin> origins;
  for (const PlaceBelief& place : places) {
    const auto log_weights = place.particles.log_weights();
    const double most = *std::max_element(log_weights.begin(), log_weights.end());
    for (std::size_t i = 0; i < log_weights.size(); ++i) {
      if (log_weights[i] < most - kRuledOut) continue;
      poses.push_back(place.particles.states()[i]);
      origins.push_back({place.id, place.log_mass + log_weights[i]});
    }
  }
  // Neighbouring cells are joined, so that particles up to two cells apart may be.
  const std::vector<int> labels = group_poses(poses, 0.5 * gap_m, 0.5 * gap_rad);
  std::vector<ParticleGroup> groups;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const auto label = static_cast<std::size_t>(labels[i]);
    if (label >= groups.size()) groups.resize(label + 1);
    groups[label].add(origins[i].id, poses[i], origins[i].log_weight);
  }
  take_stragglers_in(groups);
  return groups;
}

/// What a group of particles is from now on; it goes on from the place that most of them came from.
PlaceBelief place_of(ParticleGroup group, double log_mass, std::span<const PlaceBelief> before) {
  PlaceBelief place{
      .id = group.heir(),
      .particles = ParticleFilter<Pose2>(std::move(group.states), std::move(group.log_weights)),
      .log_mass = log_mass};
  place.moments = weighted_moments(place.particles.states(), place.particles.weights());
  for (const PlaceBelief& old : before) {
    if (old.id != place.id) continue;
    place.injection = old.injection;
    place.log_evidence = old.log_evidence;
  }
  return place;
}

}  // namespace

std::vector<int> group_poses(std::span<const Pose2> poses, double cell_m, double cell_rad) {
  const PoseLattice lattice(cell_m, cell_rad);
  std::unordered_map<std::uint64_t, std::size_t> index_of;
  std::vector<PoseCell> cells;
  std::vector<std::size_t> cell_of_pose;
  cell_of_pose.reserve(poses.size());
  for (const Pose2& pose : poses) {
    const PoseCell cell = lattice.cell_of(pose);
    const auto [found, fresh] = index_of.try_emplace(cell.key(), cells.size());
    if (fresh) cells.push_back(cell);
    cell_of_pose.push_back(found->second);
  }
  std::vector<std::size_t> parents(cells.size());
  std::iota(parents.begin(), parents.end(), std::size_t{0});
  for (std::size_t i = 0; i < cells.size(); ++i) {
    for (int neighbour = 0; neighbour < 27; ++neighbour) {
      const PoseCell beside{cells[i].x + neighbour % 3 - 1, cells[i].y + neighbour / 3 % 3 - 1,
                            lattice.wrapped(cells[i].yaw + neighbour / 9 - 1)};
      const auto found = index_of.find(beside.key());
      if (found != index_of.end()) parents[root_of(parents, found->second)] = root_of(parents, i);
    }
  }
  std::vector<int> label_of_root(cells.size(), -1);
  std::vector<int> labels;
  labels.reserve(poses.size());
  int groups = 0;
  for (const std::size_t cell : cell_of_pose) {
    int& label = label_of_root[root_of(parents, cell)];
    if (label < 0) label = groups++;
    labels.push_back(label);
  }
  return labels;
}

std::vector<Pose2> PoseBelief::draw(const PoseWithCovariance2& from, std::size_t count) {
  const GaussianMotion around(from.pose, from.covariance);
  std::vector<Pose2> poses(count);
  for (Pose2& pose : poses) pose = around.sample(Pose2{}, rng_);
  return poses;
}

void PoseBelief::add(std::span<const Proposal> proposals, double share) {
  if (proposals.empty()) return;
  std::vector<double> log_masses;
  for (const Proposal& proposal : proposals) log_masses.push_back(proposal.log_mass);
  const NormalisedLogWeights masses = normalise_log_weights(std::move(log_masses));
  const double new_share = places_.empty() ? 1.0 : share;
  for (PlaceBelief& place : places_) place.log_mass += std::log1p(-new_share);
  // Each place may need as many as the whole belief does until its particles have been weighed
  // once.
  const auto count = static_cast<std::size_t>(std::max(
      options_.particles_min, options_.particles_max / static_cast<int>(proposals.size())));
  for (std::size_t i = 0; i < proposals.size(); ++i) {
    places_.push_back({.id = next_id_++,
                       .particles = ParticleFilter<Pose2>(draw(proposals[i].map_T_robot, count)),
                       .log_mass = masses.log_weights[i] + std::log(new_share)});
  }
  regroup();
}

void PoseBelief::predict(const MotionModel& motion) {
  for (PlaceBelief& place : places_) place.particles.predict(motion, rng_, threads_);
}

void PoseBelief::update(const SensorModel& sensor, double readings,
                        const std::function<double(const PlaceBelief&)>& evidence) {
  const std::vector<Pose2> poses = particles();
  std::vector<double> log_likelihoods(poses.size());
  sensor(poses, log_likelihoods);
  std::vector<double> log_masses;
  std::size_t begin = 0;
  for (PlaceBelief& place : places_) {
    const std::size_t count = place.particles.size();
    const double mean =
        place.particles.reweight(std::span<const double>(log_likelihoods).subspan(begin, count));
    place.moments = weighted_moments(place.particles.states(), place.particles.weights());
    place.log_evidence = mean / readings;
    log_masses.push_back(place.log_mass + (evidence ? evidence(place) : mean));
    begin += count;
  }
  take_masses(log_masses);
}

void PoseBelief::regroup() {
  std::vector<PlaceBelief> places;
  for (ParticleGroup& group : group_particles(places_, options_.gap_m, options_.gap_rad)) {
    if (group.states.empty()) continue;
    const LogWeightSum sum = sum_log_weights(group.log_weights);
    if (!sum.any() || sum.log_total < std::log(options_.negligible)) continue;
    places.push_back(place_of(std::move(group), sum.log_total, places_));
  }
  if (places.empty()) return;
  std::stable_sort(places.begin(), places.end(), [](const PlaceBelief& a, const PlaceBelief& b) {
    return a.log_mass > b.log_mass;
  });
  if (places.size() > static_cast<std::size_t>(options_.places_max))
    places.erase(places.begin() + options_.places_max, places.end());
  // A cloud that fell apart: the name goes to its heaviest piece.
  std::vector<int> taken;
  for (PlaceBelief& place : places) {
    if (std::find(taken.begin(), taken.end(), place.id) != taken.end()) place.id = next_id_++;
    taken.push_back(place.id);
  }
  places_ = std::move(places);
  std::vector<double> log_masses;
  for (const PlaceBelief& place : places_) log_masses.push_back(place.log_mass);
  take_masses(log_masses);
}

void PoseBelief::take_masses(std::span<const double> log_masses) {
  const LogWeightSum sum = sum_log_weights(log_masses);
  if (!sum.any()) return;
  for (std::size_t i = 0; i < places_.size(); ++i)
    places_[i].log_mass = log_masses[i] - sum.log_total;
}

void PoseBelief::settle(bool spread) {
  regroup();
  const PoseLattice lattice(options_.bin_m, options_.bin_rad);
  const std::size_t fair =
      std::max<std::size_t>(20, static_cast<std::size_t>(options_.particles_max) / places_.size());
  Renewal<Pose2> renewal{.resampler = resampler_of(options_.resampling)};
  renewal.size =
      KldSize<Pose2>{.bin_of = [&](const Pose2& pose) { return lattice.cell_of(pose).key(); },
                     .min_count = std::min(fair, static_cast<std::size_t>(options_.particles_min)),
                     .max_count = fair,
                     .epsilon = options_.kld_epsilon,
                     .z_quantile = options_.kld_quantile};
  for (PlaceBelief& place : places_) {
    if (!place.log_evidence) continue;
    const GaussianMotion around = widely_around(place.moments);
    renewal.injection =
        Injection<Pose2>{.share =
                             [&](double evidence) {
                               const double share = place.injection.share_after(evidence);
                               return spread ? std::min(kInjectedMost, share) : 0.0;
                             },
                         .sample = [&](Rng& rng) { return around.sample(Pose2{}, rng); }};
    // A place of few particles is filled up, however even their weights are.
    constexpr double kAlways = 2.0;
    constexpr double kWhenUneven = 0.5;
    renewal.effective_share =
        place.particles.size() < renewal.size->min_count ? kAlways : kWhenUneven;
    renew(place.particles, renewal, *place.log_evidence, rng_);
    place.log_evidence.reset();
  }
}

std::size_t PoseBelief::particle_count() const {
  std::size_t count = 0;
  for (const PlaceBelief& place : places_) count += place.particles.size();
  return count;
}

std::vector<Pose2> PoseBelief::particles() const {
  std::vector<Pose2> all;
  all.reserve(particle_count());
  for (const PlaceBelief& place : places_)
    all.insert(all.end(), place.particles.states().begin(), place.particles.states().end());
  return all;
}

}  // namespace loopstone
