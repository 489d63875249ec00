#include "slam/possible_error.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "loopstone/base/rng.hpp"
#include "loopstone/geometry/covariance.hpp"
#include "slam/loose_parts_numbers.hpp"

namespace loopstone {
namespace {

/// A stretch of the path, as one: what it may lose.
struct Step {
  Eigen::Vector2d end = Eigen::Vector2d::Zero();   ///< map frame
  Eigen::Matrix3d root = Eigen::Matrix3d::Zero();  ///< of the covariance at its end
  Eigen::Vector2d open = Eigen::Vector2d::Zero();  ///< the way that is as long as odometry says
  Eigen::Vector2d off = Eigen::Vector2d::Zero();   ///< of that from what odometry says
};

/// A point's shift by a small turn about the origin, per radian.
Eigen::Vector2d swing_of(const Eigen::Vector2d& point) { return {-point.y(), point.x()}; }

Eigen::Vector2d motion_of(std::span<const Pose2> poses, std::size_t edge) {
  return poses[edge + 1].translation() - poses[edge].translation();
}

std::vector<Step> steps_of(std::span<const Pose2> poses, const PathChain& chain,
                           std::span<const int> across) {
  const std::vector<Eigen::Matrix3d> freedom = freedom_of(poses, chain, across);
  const std::size_t edges = across.size();
  const std::size_t stride = 1 + edges / static_cast<std::size_t>(kLooseParts.most_steps);
  std::vector<Step> steps;
  for (std::size_t first = 0; first < edges; first += stride) {
    const std::size_t last = std::min(first + stride, edges);
    Step step{.end = poses[last].translation()};
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
    for (std::size_t i = first; i < last; ++i) {
      const Eigen::Matrix3d lever = lever_of(step.end - poses[i + 1].translation());
      covariance += lever * freedom[i] * lever.transpose();
      if (!chain.open[i]) continue;
      step.open += motion_of(poses, i);
      step.off += chain.off[i];
    }
    step.root = std::sqrt(chain.factor) * square_root(covariance);
    steps.push_back(step);
  }
  return steps;
}

/// Errors of some places along the path.
struct Draw {
  std::vector<Eigen::Vector2d> at{};
  std::vector<double> heading{};
};

Draw draw_of(const std::vector<Step>& steps, double scale_sigma, Rng rng) {
  Draw draw;
  const double scale = scale_sigma * rng.normal();
  const double off_share = kLooseParts.off_share * rng.normal();
  // An error at a node moves all that follows: by itself, and about the node.
  Eigen::Vector2d moved = Eigen::Vector2d::Zero();
  double turned = 0.0;
  for (const Step& step : steps) {
    Eigen::Vector3d unit;
    for (const int i : {2, 1, 0}) unit[i] = rng.normal();
    const Eigen::Vector3d lost = step.root * unit;
    moved += lost.head<2>() + scale * step.open + off_share * step.off;
    moved -= lost.z() * swing_of(step.end);
    turned += lost.z();
    draw.at.emplace_back(moved + turned * swing_of(step.end));
    draw.heading.push_back(turned);
  }
  return draw;
}

Draw draw_of(PathPosterior& posterior, const Rng& rng) {
  Draw draw;
  for (const Eigen::Vector3d& error : posterior.draw(rng)) {
    draw.at.emplace_back(error.head<2>());
    draw.heading.push_back(error.z());
  }
  return draw;
}

/// What is left of it on the map that fits best.
PossibleError worst_of(const std::vector<Eigen::Vector2d>& places, const Draw& draw) {
  const auto count = static_cast<double>(places.size());
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  Eigen::Vector2d shift = Eigen::Vector2d::Zero();
  for (std::size_t i = 0; i < places.size(); ++i) {
    middle += places[i] / count;
    shift += draw.at[i] / count;
  }
  double turn = 0.0;
  double arms = 0.0;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const Eigen::Vector2d arm = places[i] - middle;
    turn += arm.x() * draw.at[i].y() - arm.y() * draw.at[i].x();
    arms += arm.squaredNorm();
  }
  if (arms > 0.0) turn /= arms;
  PossibleError worst;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const Eigen::Vector2d arm = places[i] - middle;
    const Eigen::Vector2d left = draw.at[i] - shift - turn * swing_of(arm);
    worst.m = std::max(worst.m, left.norm());
    worst.rad = std::max(worst.rad, std::abs(draw.heading[i] - turn));
  }
  return worst;
}

double quantile(std::vector<double> values) {
  const auto at =
      static_cast<std::ptrdiff_t>(kLooseParts.sure_share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + at, values.end());
  return values[static_cast<std::size_t>(at)];
}

/// \param draw_one  of errors at the places
template <typename DrawOne>
PossibleError worst_of_many(const std::vector<Eigen::Vector2d>& places, DrawOne&& draw_one) {
  if (places.empty()) return {};
  const Rng draws(1);
  std::vector<double> metres;
  std::vector<double> radians;
  for (int i = 0; i < kLooseParts.draws; ++i) {
    const PossibleError worst =
        worst_of(places, draw_one(draws.fork(static_cast<std::uint64_t>(i))));
    metres.push_back(worst.m);
    radians.push_back(worst.rad);
  }
  return {quantile(std::move(metres)), quantile(std::move(radians))};
}

}  // namespace

std::vector<Eigen::Matrix3d> freedom_of(std::span<const Pose2> poses, const PathChain& chain,
                                        std::span<const int> across) {
  std::vector<Eigen::Matrix3d> freedom = chain.drifts;
  for (std::size_t i = 0; i < freedom.size(); ++i) {
    if (across[i] <= 1) continue;
    Eigen::Matrix3d along_only = Eigen::Matrix3d::Zero();
    if (chain.open[i]) {
      const Eigen::Vector2d along = way_at(poses, i);
      along_only.topLeftCorner<2, 2>() =
          along.dot(freedom[i].topLeftCorner<2, 2>() * along) * along * along.transpose();
    }
    freedom[i] = along_only;
  }
  return freedom;
}

PossibleError possible_error(std::span<const Pose2> poses, const PathChain& chain,
                             std::span<const int> across) {
  const std::vector<Step> steps = steps_of(poses, chain, across);
  std::vector<Eigen::Vector2d> places;
  for (const Step& step : steps) places.push_back(step.end);
  return worst_of_many(places,
                       [&](const Rng& rng) { return draw_of(steps, chain.scale_sigma, rng); });
}

PossibleError possible_error(PathPosterior& posterior) {
  return worst_of_many(posterior.places(), [&](const Rng& rng) { return draw_of(posterior, rng); });
}

}  // namespace loopstone
