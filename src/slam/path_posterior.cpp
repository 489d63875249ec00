#include "slam/path_posterior.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

#include "loopstone/geometry/covariance.hpp"
#include "slam/loose_parts_numbers.hpp"

namespace loopstone {
namespace {

/// Steps that lose nothing are as good as rigid.
constexpr double kRigidM = 1e-4;
constexpr double kRigidRad = 1e-5;

/// Runs of key scans that lie in one segment; those that are held are runs of their own kind.
struct Run {
  int segment = -1;
  std::size_t middle = 0;
};

std::vector<Run> runs_of(std::span<const int> places, const SurfaceSegments& segments) {
  const auto segment_at = [&](std::size_t node) {
    return places[node] < 0 ? -1 : segments.segment_of(places[node]);
  };
  std::vector<Run> runs;
  for (std::size_t first = 0; first < places.size();) {
    std::size_t end = first + 1;
    while (end < places.size() && segment_at(end) == segment_at(first)) ++end;
    runs.push_back({segment_at(first), (first + end - 1) / 2});
    first = end;
  }
  return runs;
}

/// Before which key scans rigid bodies end: at breaks, and where a direction opens or closes.
std::vector<bool> ends_of(const PathWeakness& weakness) {
  std::vector<bool> ends = weakness.broken;
  if (ends.empty()) ends.resize(weakness.open.size(), false);
  for (std::size_t key = 1; key < weakness.open.size(); ++key)
    if (weakness.open[key] != weakness.open[key - 1]) ends[key] = true;
  return ends;
}

}  // namespace

std::vector<LinkAlong> links_along(std::span<const Pose2> map_T_key, std::span<const int> places,
                                   const SurfaceSegments& segments,
                                   std::span<const Eigen::Matrix3d> covariances,
                                   const std::vector<bool>& known) {
  std::vector<LinkAlong> links;
  const std::vector<Run> runs = runs_of(places, segments);
  for (std::size_t i = 0; i + 1 < runs.size(); ++i) {
    const std::size_t from = runs[i].middle;
    const std::size_t to = runs[i + 1].middle;
    const Eigen::Vector2d end = map_T_key[to].translation();
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
    bool whole = true;
    for (std::size_t node = from + 1; node <= to; ++node) {
      whole = whole && known[node];
      const Eigen::Matrix3d at = lever_of(end - map_T_key[node].translation());
      covariance += at * covariances[node] * at.transpose();
    }
    if (!whole || (places[to] < 0 && places[from] < 0)) continue;
    const Eigen::Vector2d from_T_to = end - map_T_key[from].translation();
    if (places[to] < 0) {
      // Seen from the one that is held.
      const Eigen::Matrix3d back = lever_of(-from_T_to);
      const Eigen::Matrix3d information = (back * covariance * back.transpose()).inverse();
      links.push_back({{.to = places[from], .information = information}, to, from});
      continue;
    }
    links.push_back({{.from = places[from],
                      .to = places[to],
                      .from_T_point = from_T_to,
                      .information = covariance.inverse()},
                     from,
                     to});
  }
  return links;
}

PathSurfaces::PathSurfaces(std::span<const Pose2> map_T_key, std::span<const int> places,
                           std::size_t size, const PathWeakness& weakness,
                           const SurfaceSystem& by_visit)
    : knowledge_(std::make_shared<Knowledge>(
          Knowledge{{map_T_key.begin(), map_T_key.end()},
                    {places.begin(), places.end()},
                    SurfaceSegments(map_T_key, places, size, ends_of(weakness))})) {
  knowledge_->segments.gather(by_visit);
}

std::span<const Pose2> PathSurfaces::poses() const { return knowledge_->poses; }

PathPosterior::PathPosterior(PathSurfaces surfaces, const PathChain& chain,
                             std::span<const Eigen::Matrix3d> steps)
    : surfaces_(std::move(surfaces)),
      knowledge_(surfaces_.knowledge()),
      sigma_(std::sqrt(chain.factor)) {
  std::vector<Eigen::Matrix3d> covariances(steps.size() + 1, Eigen::Matrix3d::Zero());
  const Eigen::Vector3d rigid(kRigidM * kRigidM, kRigidM * kRigidM, kRigidRad * kRigidRad);
  for (std::size_t i = 0; i < steps.size(); ++i) {
    covariances[i + 1] = steps[i];
    covariances[i + 1].diagonal() += rigid;
  }
  std::vector<SurfaceSegments::Link> links;
  std::vector<Eigen::Vector2d> open;
  std::vector<Eigen::Vector2d> off;
  for (const LinkAlong& along :
       links_along(knowledge_.poses, knowledge_.places, knowledge_.segments, covariances,
                   std::vector<bool>(covariances.size(), true))) {
    links.push_back(along.link);
    open.emplace_back(Eigen::Vector2d::Zero());
    off.emplace_back(Eigen::Vector2d::Zero());
    const auto [first, last] = std::minmax(along.from, along.to);
    for (std::size_t i = first; i < last; ++i) {
      if (!chain.open[i]) continue;
      const Eigen::Vector2d way =
          knowledge_.poses[i + 1].translation() - knowledge_.poses[i].translation();
      const Eigen::Vector2d axis = way_at(knowledge_.poses, i);
      open.back() += chain.scale_sigma * way;
      off.back() += kLooseParts.off_share * axis.dot(chain.off[i]) * axis;
    }
  }
  available_ = knowledge_.segments.factorise_along(links);
  if (!available_) return;
  by_scale_ = knowledge_.segments.response_to(links, open);
  by_off_ = knowledge_.segments.response_to(links, off);
  for (const Run& run : runs_of(knowledge_.places, knowledge_.segments))
    if (run.segment >= 0) middles_.push_back(run.middle);
}

std::vector<Eigen::Vector2d> PathPosterior::places() const {
  std::vector<Eigen::Vector2d> places;
  for (const std::size_t key : middles_) places.push_back(knowledge_.poses[key].translation());
  return places;
}

Eigen::Vector3d PathPosterior::at(const Motions& motions, std::size_t key) const {
  const int place = knowledge_.places[key];
  if (place < 0) return Eigen::Vector3d::Zero();
  const int segment = knowledge_.segments.segment_of(place);
  return knowledge_.segments.motion_at(place, Eigen::Vector2d::Zero()) *
         motions[static_cast<std::size_t>(segment)];
}

std::vector<Eigen::Vector3d> PathPosterior::draw(Rng rng) {
  const double scale = rng.normal();
  const double off = rng.normal();
  Motions motions(knowledge_.segments.size());
  for (Eigen::Vector3d& unit : motions)
    for (const int i : {0, 1, 2}) unit[i] = sigma_ * rng.normal();
  knowledge_.segments.colour_in_place(motions);
  for (std::size_t i = 0; i < motions.size(); ++i)
    motions[i] += scale * by_scale_[i] + off * by_off_[i];
  std::vector<Eigen::Vector3d> errors;
  errors.reserve(middles_.size());
  for (const std::size_t key : middles_) errors.push_back(at(motions, key));
  return errors;
}

Eigen::Matrix3d PathPosterior::between(std::size_t first, std::size_t last) {
  const Eigen::Vector2d apart =
      knowledge_.poses[last].translation() - knowledge_.poses[first].translation();
  std::vector<BlockSolver::RowsAt> rows;
  const auto add = [&](std::size_t node, const Eigen::Vector2d& offset, double sign) {
    const int place = knowledge_.places[node];
    if (place < 0) return;
    rows.push_back({knowledge_.segments.segment_of(place),
                    sign * knowledge_.segments.motion_at(place, offset)});
  };
  add(last, Eigen::Vector2d::Zero(), 1.0);
  add(first, apart, -1.0);
  Eigen::Matrix3d covariance = sigma_ * sigma_ * knowledge_.segments.through_inverse(rows);
  for (const Motions* motions : {&by_scale_, &by_off_}) {
    const Eigen::Vector3d off = at(*motions, last) - lever_of(apart) * at(*motions, first);
    covariance += off * off.transpose();
  }
  return covariance;
}

}  // namespace loopstone
