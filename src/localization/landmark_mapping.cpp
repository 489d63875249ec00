#include "loopstone/localization/landmark_mapping.hpp"

#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <utility>

#include "localization/landmark_group.hpp"
#include "localization/landmark_mapping_numbers.hpp"
#include "localization/landmark_recognition.hpp"
#include "localization/landmark_tracks.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/base/median.hpp"
#include "loopstone/base/option_list.hpp"
#include "loopstone/base/robust_kernel.hpp"
#include "loopstone/geometry/covariance.hpp"
#include "loopstone/geometry/rigid_motion.hpp"
#include "loopstone/graph/marginals.hpp"
#include "loopstone/graph/solver.hpp"
#include "slam/scan_edges.hpp"

namespace loopstone {
namespace {

/// Of chi-square with two degrees of freedom: 2 ln 2.
constexpr double kMedianChi2 = 1.3863;
/// Of a motion that no edge tells.
constexpr double kUnknownM = 0.5;
constexpr double kUnknownRad = 0.2;
/// As bad as a misfit can be.
constexpr double kWandering = 1e3;

/// From each pose to the next: by the poses, as well known as the path's edges say.
std::vector<PoseWithCovariance2> motions_of(const PoseGraph& graph) {
  std::vector<PoseWithCovariance2> motions(graph.poses.size());
  for (std::size_t i = 0; i < motions.size(); ++i) {
    if (i > 0) motions[i].pose = graph.poses[i - 1].inverse() * graph.poses[i];
    motions[i].covariance = planar_covariance(kUnknownM, kUnknownRad);
  }
  std::vector<bool> known(motions.size(), false);
  for (const RelativePoseEdge& edge : graph.edges) {
    const auto to = static_cast<std::size_t>(edge.to.index);
    if (edge.from.index + 1 != edge.to.index || known[to]) continue;
    known[to] = true;
    motions[to].covariance = rotated(edge.information.inverse(), edge.from_T_to.rotation());
  }
  return motions;
}

class Mapping {
 public:
  Mapping(const PoseGraph& graph, std::span<const std::vector<LandmarkObservation>> seen,
          const LandmarkMappingOptions& options, const SeenThrough& seen_through)
      : options_(options), seen_through_(seen_through), seen_(seen), base_(graph) {
    for (const auto& reading : seen)
      figures_.observations += static_cast<std::int64_t>(reading.size());
    tracks_ = follow_landmarks(motions_of(graph), seen, options.clutter_share);
    scene_ = {seen_, tracks_};
    weights_.resize(seen.size());
    for (std::size_t i = 0; i < seen.size(); ++i) weights_[i].assign(seen[i].size(), 1.0);
  }

  LandmarkMapping run() {
    std::vector<std::size_t> candidates = candidate_tracks();
    add_in_order(candidates);
    for (int round = 0; round < kLandmarkMapping.rounds && recognise_again(); ++round) {
    }
    for (int round = 0; round < kLandmarkMapping.rounds; ++round) {
      weigh();
      if (!drop_misfits()) break;
    }
    drop_immature();
    weigh();
    return result();
  }

 private:
  /// Of things without a name those that were seen long enough; all that have one.
  std::vector<std::size_t> candidate_tracks() {
    std::vector<std::size_t> candidates;
    for (std::size_t i = 0; i < tracks_.size(); ++i) {
      const LandmarkTrack& track = tracks_[i];
      if (track.sightings.size() > 1) ++figures_.tracks;
      if (track.name || is_mature(track.sightings)) {
        candidates.push_back(i);
      } else if (track.sightings.size() > 1) {
        ++figures_.too_few;
      }
    }
    return candidates;
  }

  [[nodiscard]] bool is_mature(std::span<const Sighting> sightings) const {
    return static_cast<int>(sightings.size()) >= options_.sightings_min &&
           baseline_m(sightings, base_.poses) >= options_.baseline_min_m;
  }

  /// What comes into view along some metres of the path is taken in together.
  void add_in_order(std::span<const std::size_t> candidates) {
    const std::vector<double> travelled_m = way_to_each_node();
    const auto began_at = [&](std::size_t track) {
      return travelled_m[tracks_[track].sightings.front().node];
    };
    for (std::size_t first = 0; first < candidates.size();) {
      std::size_t last = first;
      while (last < candidates.size() &&
             began_at(candidates[last]) <= began_at(candidates[first]) + kLandmarkMapping.batch_m)
        ++last;
      std::vector<std::size_t> older;
      for (std::size_t i = 0; i < groups_.size(); ++i) {
        if (!groups_[i].tracks.empty()) older.push_back(i);
      }
      std::vector<std::size_t> newer;
      bool moved = false;
      for (std::size_t i = first; i < last; ++i) moved = add_track(candidates[i], newer) || moved;
      build_graph();
      if (moved) solve();
      if (!newer.empty() && !older.empty()) take(recognise(graph_, groups_, newer, older, scene_));
      first = last;
    }
    build_graph();
    solve();
  }

  [[nodiscard]] std::vector<double> way_to_each_node() const {
    std::vector<double> way(base_.poses.size(), 0.0);
    for (std::size_t i = 1; i < way.size(); ++i) {
      way[i] =
          way[i - 1] + (base_.poses[i].translation() - base_.poses[i - 1].translation()).norm();
    }
    return way;
  }

  /// \return whether it is of a landmark known by its name, so that the map moves
  bool add_track(std::size_t track, std::vector<std::size_t>& newer) {
    const LandmarkTrack& t = tracks_[track];
    LandmarkGroup group{.name = t.name, .tracks = {track}};
    group.radius_m = radius_of(t.sightings, options_.radius_max_m, scene_, base_.poses);
    if (t.name) {
      const auto known = group_named_.find(*t.name);
      if (known != group_named_.end()) {
        groups_[known->second].tracks.push_back(track);
        ++figures_.merged;
        return true;
      }
      group_named_[*t.name] = groups_.size();
    } else {
      newer.push_back(groups_.size());
    }
    groups_.push_back(std::move(group));
    return false;
  }

  /// Groups that are one become one.
  bool take(const std::vector<GroupPair>& pairs) {
    bool moves = false;
    for (const GroupPair& pair : pairs) {
      LandmarkGroup& older = groups_[pair.older];
      LandmarkGroup& newer = groups_[pair.newer];
      if (older.tracks.empty() || newer.tracks.empty()) continue;
      older.tracks.insert(older.tracks.end(), newer.tracks.begin(), newer.tracks.end());
      std::ranges::sort(older.tracks);
      newer.tracks.clear();
      find_radius(older);
      ++figures_.merged;
      moves = moves || pair.moves_map;
    }
    if (moves) {
      build_graph();
      solve();
    }
    return !pairs.empty();
  }

  void find_radius(LandmarkGroup& group) const {
    group.radius_m =
        radius_of(sightings_of(group, scene_), options_.radius_max_m, scene_, graph_.poses);
  }

  /// With the map as it is now, what was left open may be clear.
  bool recognise_again() {
    bool any = false;
    std::vector<Eigen::Vector2d> places;
    for (const LandmarkGroup& group : groups_) {
      places.emplace_back(Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity()));
      if (group.tracks.empty() || group.name) continue;
      const std::vector<Sighting> sightings = sightings_of(group, scene_);
      places.back() = place_of(sightings, group.radius_m, scene_, graph_.poses).position;
    }
    for (std::size_t newer = 1; newer < groups_.size(); ++newer) {
      if (groups_[newer].tracks.empty() || groups_[newer].name) continue;
      std::vector<std::size_t> others;
      for (std::size_t older = 0; older < newer; ++older) {
        if (!groups_[older].tracks.empty() &&
            (places[newer] - places[older]).norm() < kLandmarkMapping.again_m)
          others.push_back(older);
      }
      if (others.empty()) continue;
      any = take(recognise(graph_, groups_, std::vector{newer}, others, scene_)) || any;
    }
    build_graph();
    if (any) solve();
    return any;
  }

  /// The graph with what is taken for a landmark now; poses stay where they are.
  void build_graph() {
    std::vector<Pose2> poses = std::move(graph_.poses);
    if (poses.empty()) poses = base_.poses;
    graph_ = base_;
    graph_.poses = std::move(poses);
    for (const LandmarkGroup& group : groups_) {
      if (group.tracks.empty()) continue;
      const std::vector<Sighting> sightings = sightings_of(group, scene_);
      const LandmarkId id{static_cast<int>(graph_.landmarks.size())};
      graph_.landmarks.push_back(
          place_of(sightings, group.radius_m, scene_, graph_.poses).position);
      for (const Sighting& sighting : sightings) {
        const double weight = weights_[sighting.node][sighting.observation];
        const LandmarkObservation& seen = scene_.of(sighting);
        const Eigen::Matrix2d information = weight / noise_ * seen.covariance.inverse();
        graph_.landmark_edges.push_back({NodeId{static_cast<int>(sighting.node)}, id,
                                         centre_of(seen, group.radius_m),
                                         0.5 * (information + information.transpose())});
      }
    }
  }

  void solve() {
    SolveResult solved = optimize(graph_, closure_solver());
    graph_.poses = std::move(solved.poses);
    graph_.landmarks = std::move(solved.landmarks);
  }

  /// Of a sighting of a landmark at the solution, by the noise that it is told to have.
  [[nodiscard]] double chi2_of(const Sighting& sighting, const LandmarkGroup& group,
                               const Eigen::Vector2d& landmark) const {
    const LandmarkObservation& seen = scene_.of(sighting);
    const Eigen::Vector2d off =
        graph_.poses[sighting.node].inverse() * landmark - centre_of(seen, group.radius_m);
    return off.dot(seen.covariance.inverse() * off);
  }

  template <typename Visit>
  void for_each_landmark(Visit&& visit) {
    std::size_t landmark = 0;
    for (LandmarkGroup& group : groups_) {
      if (!group.tracks.empty()) visit(group, graph_.landmarks[landmark++]);
    }
  }

  /// Solves with each sighting weighed by how well it agrees; noise that is told too small is
  /// found to be larger.
  void weigh() {
    for (int round = 0; round < kLandmarkMapping.weight_rounds; ++round) {
      for (LandmarkGroup& group : groups_) {
        if (!group.tracks.empty()) find_radius(group);
      }
      build_graph();
      solve();
      std::vector<double> all;
      for_each_landmark([&](const LandmarkGroup& group, const Eigen::Vector2d& landmark) {
        for (const Sighting& s : sightings_of(group, scene_))
          all.push_back(chi2_of(s, group, landmark));
      });
      if (all.empty()) return;
      noise_ = std::max(1.0, median_of(all) / kMedianChi2);
      for_each_landmark([&](const LandmarkGroup& group, const Eigen::Vector2d& landmark) {
        for (const Sighting& s : sightings_of(group, scene_)) {
          weights_[s.node][s.observation] = evaluate(RobustKernel::kCauchy, options_.robust_width,
                                                     chi2_of(s, group, landmark) / noise_)
                                                .weight;
        }
      });
    }
    build_graph();
    solve();
  }

  [[nodiscard]] double misfit_of(std::size_t track, const LandmarkGroup& group,
                                 const Eigen::Vector2d& landmark) const {
    std::vector<double> chi2;
    for (const Sighting& sighting : tracks_[track].sightings)
      chi2.push_back(chi2_of(sighting, group, landmark) / noise_);
    const double typical = median_of(chi2);
    return wanders(tracks_[track].sightings, group) ? std::max(typical, kWandering) : typical;
  }

  /// Whether it is elsewhere in the second half of a visit: slow things are followed, too.
  [[nodiscard]] bool wanders(std::span<const Sighting> sightings,
                             const LandmarkGroup& group) const {
    const std::size_t half = sightings.size() / 2;
    if (half < 2) return false;
    const auto place = [&](std::span<const Sighting> part) {
      return place_of(part, group.radius_m, scene_, graph_.poses);
    };
    const UncertainPoint before = place(sightings.first(half));
    const UncertainPoint after = place(sightings.subspan(half));
    const double sigma_m = std::sqrt(noise_) * largest_sigma(before.covariance + after.covariance);
    const double way_m = (after.position - before.position).norm();
    return way_m > kLandmarkMapping.wander_m && way_m > kLandmarkMapping.wander_sigmas * sigma_m;
  }

  /// Of each landmark what does not agree with it, the worst first; whether there was any.
  bool drop_misfits() {
    bool any = false;
    for_each_landmark([&](LandmarkGroup& group, const Eigen::Vector2d& landmark) {
      std::size_t worst = 0;
      double most = 0.0;
      for (const std::size_t track : group.tracks) {
        const double misfit = misfit_of(track, group, landmark);
        if (misfit <= most) continue;
        most = misfit;
        worst = track;
      }
      if (most > kLandmarkMapping.misfit_chi2) {
        std::erase(group.tracks, worst);
        ++figures_.moving;
        any = true;
      } else if (was_carried_away(group, landmark)) {
        group.tracks.clear();
        ++figures_.see_through;
        any = true;
      }
    });
    return any;
  }

  [[nodiscard]] bool was_carried_away(const LandmarkGroup& group,
                                      const Eigen::Vector2d& landmark) const {
    if (!seen_through_) return false;
    std::set<std::size_t> there;
    for (const Sighting& sighting : sightings_of(group, scene_)) there.insert(sighting.node);
    int through = 0;
    for (std::size_t node = 0; node < graph_.poses.size(); ++node) {
      if (there.contains(node)) continue;
      if (seen_through_(node, graph_.poses[node].inverse() * landmark).value_or(false)) ++through;
    }
    const auto looks = static_cast<double>(there.size()) + through;
    return through > kLandmarkMapping.through_share * looks;
  }

  void drop_immature() {
    for (LandmarkGroup& group : groups_) {
      if (group.tracks.empty() || is_mature(good_sightings(group))) continue;
      group.tracks.clear();
      ++figures_.too_few;
    }
  }

  [[nodiscard]] std::vector<Sighting> good_sightings(const LandmarkGroup& group) const {
    std::vector<Sighting> good = sightings_of(group, scene_);
    std::erase_if(good, [&](const Sighting& s) { return weights_[s.node][s.observation] < 0.5; });
    return good;
  }

  LandmarkMapping result() {
    LandmarkMapping mapping;
    double chi2 = 0.0;
    for_each_landmark([&](const LandmarkGroup& group, const Eigen::Vector2d& landmark) {
      const std::vector<Sighting> good = good_sightings(group);
      for (const Sighting& sighting : good) chi2 += chi2_of(sighting, group, landmark);
      figures_.used += static_cast<std::int64_t>(good.size());
      const int next = static_cast<int>(mapping.landmarks.size()) + 1;
      mapping.landmarks.push_back({.id = group.name.value_or(next),
                                   .position = landmark,
                                   .radius_m = group.radius_m,
                                   .sightings = static_cast<int>(good.size()),
                                   .visits = static_cast<int>(group.tracks.size())});
    });
    const double freedom =
        2.0 * (static_cast<double>(figures_.used) - static_cast<double>(mapping.landmarks.size()));
    figures_.chi2 = freedom > 0.0 ? chi2 / freedom : 0.0;
    find_covariances(mapping.landmarks);
    mapping.figures = figures_;
    mapping.graph = std::move(graph_);
    return mapping;
  }

  void find_covariances(std::vector<FoundLandmark>& landmarks) const {
    if (landmarks.empty()) return;
    const Eigen::MatrixXd joint = joint_landmark_covariance(graph_);
    if (joint.size() == 0) return;
    const Eigen::MatrixXd among = without_common_motion(joint, graph_.landmarks);
    for (std::size_t i = 0; i < landmarks.size(); ++i) {
      const auto at = static_cast<Eigen::Index>(2 * i);
      landmarks[i].covariance = joint.block<2, 2>(at, at);
      landmarks[i].sigma_m = largest_sigma(among.block<2, 2>(at, at));
    }
  }

  const LandmarkMappingOptions& options_;
  const SeenThrough& seen_through_;
  std::span<const std::vector<LandmarkObservation>> seen_;
  const PoseGraph& base_;
  PoseGraph graph_{};
  std::vector<LandmarkTrack> tracks_{};
  LandmarkScene scene_{};
  std::vector<LandmarkGroup> groups_{};  ///< without tracks: it is none any more
  std::map<int, std::size_t> group_named_{};
  std::vector<std::vector<double>> weights_{};  ///< of each observation
  double noise_ = 1.0;  ///< variance of sightings by what they are told to have
  LandmarkMappingFigures figures_{};
};

}  // namespace

Eigen::MatrixXd without_common_motion(const Eigen::MatrixXd& joint,
                                      std::span<const Eigen::Vector2d> points) {
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& point : points) centre += point / static_cast<double>(points.size());
  Eigen::MatrixXd motions(joint.rows(), 3);
  for (std::size_t i = 0; i < points.size(); ++i) {
    motions.block<2, 3>(static_cast<Eigen::Index>(2 * i), 0) =
        RigidMotion<2>::point_jacobian(points[i] - centre);
  }
  // Of a single point, or of several in one place, there is no turn.
  const Eigen::MatrixXd own = motions.completeOrthogonalDecomposition().pseudoInverse();
  const Eigen::MatrixXd kept =
      Eigen::MatrixXd::Identity(joint.rows(), joint.cols()) - motions.lazyProduct(own);
  // Not by Eigen's product, whose blocks depend on the processor.
  const Eigen::MatrixXd half = kept.lazyProduct(joint);
  return half.lazyProduct(kept.transpose());
}

LandmarkMapping map_landmarks(const PoseGraph& graph,
                              std::span<const std::vector<LandmarkObservation>> seen,
                              const LandmarkMappingOptions& options,
                              const SeenThrough& seen_through) {
  require_valid(options);
  if (seen.size() != graph.poses.size()) {
    throw UsageError("landmarks: " + std::to_string(seen.size()) + " readings for " +
                     std::to_string(graph.poses.size()) + " poses; each pose needs its own");
  }
  check_graph(graph);
  if (graph.poses.empty()) return {.graph = graph};
  return Mapping(graph, seen, options, seen_through).run();
}

NumberGroup landmark_numbers() { return number_group("landmark_mapping", kLandmarkMapping); }

std::vector<MappedLandmark> as_mapped(std::span<const FoundLandmark> landmarks) {
  std::vector<MappedLandmark> mapped;
  for (const FoundLandmark& landmark : landmarks) {
    mapped.push_back({.id = landmark.id,
                      .position = landmark.position,
                      .sigma_m = landmark.sigma_m,
                      .radius_m = landmark.radius_m});
  }
  return mapped;
}

}  // namespace loopstone
