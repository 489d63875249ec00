#include "match_report.hpp"

#include <fmt/format.h>

#include <cmath>

#include "loopstone/geometry/roll_pitch_yaw.hpp"
#include "loopstone/registration/weakest_direction.hpp"

namespace loopstone::app {

namespace {

using Json = nlohmann::ordered_json;

Json json_of(const Pose2& pose) {
  return {{"x_m", pose.x}, {"y_m", pose.y}, {"yaw_rad", pose.yaw}};
}

/// Four by four, row by row; a pose of the plane stands at z = 0.
Json matrix_of(const Pose3& pose) {
  const Eigen::Matrix3d rotation = pose.rotation.toRotationMatrix();
  Json rows = Json::array();
  for (int row = 0; row < 3; ++row) {
    rows.push_back({rotation(row, 0), rotation(row, 1), rotation(row, 2), pose.translation(row)});
  }
  rows.push_back({0.0, 0.0, 0.0, 1.0});
  return rows;
}
Json matrix_of(const Pose2& pose) { return matrix_of(Pose3::from_pose2(pose)); }

Json json_of(const Pose3& pose) {
  const Eigen::Vector3d& t = pose.translation;
  const Eigen::Vector3d roll_pitch_yaw = to_roll_pitch_yaw(pose);
  return {{"x_m", t.x()},
          {"y_m", t.y()},
          {"z_m", t.z()},
          {"roll_rad", roll_pitch_yaw.x()},
          {"pitch_rad", roll_pitch_yaw.y()},
          {"yaw_rad", roll_pitch_yaw.z()},
          {"matrix", matrix_of(pose)}};
}

template <typename Matrix>
Json rows_of(const Matrix& matrix) {
  Json rows = Json::array();
  for (Eigen::Index row = 0; row < matrix.rows(); ++row) {
    Json line = Json::array();
    for (Eigen::Index column = 0; column < matrix.cols(); ++column)
      line.push_back(matrix(row, column));
    rows.push_back(std::move(line));
  }
  return rows;
}

/// -0.00003 prints as 0.0000.
double shown(double value) { return std::abs(value) < 5e-5 ? 0.0 : value; }

void add_pose_rows(Result& result, std::string_view label, const Pose2& pose) {
  result.add_row(label, fmt::format("x {:9.4f} m   y {:9.4f} m   yaw {:9.4f} deg", shown(pose.x),
                                    shown(pose.y), shown(degrees(pose.yaw))));
}

void add_pose_rows(Result& result, std::string_view label, const Pose3& pose) {
  const Eigen::Vector3d& t = pose.translation;
  const Eigen::Vector3d turns = to_roll_pitch_yaw(pose);
  result
      .add_row(label, fmt::format("x {:9.4f} m    y {:9.4f} m      z {:9.4f} m", shown(t.x()),
                                  shown(t.y()), shown(t.z())))
      .add_row(label, fmt::format("roll {:6.2f} deg  pitch {:6.2f} deg  yaw {:6.2f} deg",
                                  shown(degrees(turns.x())), shown(degrees(turns.y())),
                                  shown(degrees(turns.z()))));
}

template <int kDimension>
void add_sigma_rows(Result& result, const BasicMatchResult<kDimension>& match) {
  if (!match.covariance.allFinite()) {
    result.add_row("sigma", "unknown: no pose was found");
    return;
  }
  const auto sigma = [&](Eigen::Index i) {
    return std::sqrt(std::max(match.covariance(i, i), 0.0));
  };
  if constexpr (kDimension == 2) {
    result.add_row("sigma", fmt::format("x {:9.2f} mm  y {:9.2f} mm  yaw {:9.4f} deg",
                                        1e3 * sigma(0), 1e3 * sigma(1), degrees(sigma(2))));
  } else {
    result
        .add_row("sigma", fmt::format("x {:9.2f} mm   y {:9.2f} mm     z {:9.2f} mm",
                                      1e3 * sigma(0), 1e3 * sigma(1), 1e3 * sigma(2)))
        .add_row("sigma of turns",
                 fmt::format("about x {:.4f} deg, y {:.4f} deg, z {:.4f} deg", degrees(sigma(3)),
                             degrees(sigma(4)), degrees(sigma(5))));
  }
}

/// The direction that a degenerate match leaves open.
template <int kDimension>
std::string open_direction(const BasicMatchResult<kDimension>& match, double radius_m) {
  const WeakestDirection<kDimension> weakest = weakest_direction<kDimension>(match, radius_m);
  const auto& d = weakest.direction;
  const std::string size = weakest.is_turn ? fmt::format("sigma {:.2f} deg", degrees(weakest.sigma))
                                           : fmt::format("sigma {:.3f} m", weakest.sigma);
  if constexpr (kDimension == 2) {
    if (weakest.is_turn) return "the heading (" + size + ")";
    return fmt::format("along {:.1f} deg of the target's x axis ({})",
                       std::abs(d.y()) < 1e-3 ? 0.0 : degrees(std::atan2(d.y(), d.x())), size);
  } else {
    return fmt::format("{} ({:.2f}, {:.2f}, {:.2f}) of the target ({})",
                       weakest.is_turn ? "the turn about" : "along", d.x(), d.y(), d.z(), size);
  }
}

template <int kDimension>
Json json_of_match(const BasicMatchResult<kDimension>& match) {
  return {{"target_T_source", json_of(match.target_T_source)},
          {"status", to_string(match.status)},
          {"score", match.score},
          {"rmse_m", match.rmse_m}};
}

template <int kDimension>
void add_sweep(Result& result, const SweepResult<kDimension>& sweep) {
  constexpr std::size_t kMost = 5;
  Json best = Json::array();
  for (std::size_t i = 0; i < std::min(kMost, sweep.endings.size()); ++i) {
    Json ending = json_of_match(sweep.endings[i].match);
    ending["starts"] = sweep.endings[i].count;
    best.push_back(std::move(ending));
  }
  result.add_json("starts", sweep.starts)
      .add_json("agreeing", sweep.agreeing)
      .add_json("best", std::move(best))
      .add_row("starts", fmt::format("{} headings, {} ended at this pose, {} poses in all",
                                     sweep.starts, sweep.agreeing, sweep.endings.size()));
}

template <int kDimension>
void add_search(Result& result, const CloudSearchResult<kDimension>& search) {
  Json best = Json::array({json_of_match(search.match)});
  if (search.runner_up) {
    best.push_back({{"target_T_source", json_of(search.runner_up->target_T_source)},
                    {"rmse_m", search.runner_up->rmse_m}});
  }
  result.add_json("starts", search.starts)
      .add_json("finalists", search.finalists)
      .add_json("agreeing", search.agreeing)
      .add_json("ambiguous", search.ambiguous)
      .add_json("best", std::move(best))
      .add_row("starts",
               fmt::format("{} turns, {} followed to the end, {} of these ended at this pose",
                           search.starts, search.finalists, search.agreeing));
  if (search.ambiguous)
    result.add_row("ambiguous",
                   "another pose fits as well: a symmetric shape, or too small a part");
}

void add_map_match(Result& result, const MapMatch& found) {
  Json best = Json::array();
  for (const MatchResult& match : found.poses) best.push_back(json_of_match(match));
  result.add_json("sure", found.sure)
      .add_json("evaluations", found.evaluations)
      .add_json("agreeing", found.found() ? 1 : 0)
      .add_json("starts", found.poses.size())
      .add_json("best", std::move(best));
  std::string text = fmt::format("{} that fit", found.poses.size());
  if (found.poses.size() > 1)
    text += fmt::format(", the next best explains {:.1f} %", 100.0 * found.poses[1].score);
  result.add_row("distinct poses", text)
      .add_row("sure", found.sure
                           ? "yes: no other pose explains the scan nearly as well"
                           : "no: too little is explained, or another pose explains as much");
}

std::string status_text(MatchStatus status) {
  switch (status) {
    case MatchStatus::kConverged:
      return "converged";
    case MatchStatus::kDegenerate:
      return "degenerate: the pose is right but for what the data leave open";
    case MatchStatus::kTooFewPairs:
      return "too_few_pairs: NO MATCH, the pose is the guess";
    case MatchStatus::kNotConverged:
      return "not_converged: NO MATCH that can be relied on";
  }
  return "unknown";
}

}  // namespace

template <int kDimension>
Result report_match(const MatchInput& source, const MatchInput& target,
                    const AlignResult<kDimension>& outcome, double wall_time_s) {
  const BasicMatchResult<kDimension>& match = outcome.match;
  Result result;
  result.add_json("source", source.name)
      .add_json("source_kind", source.kind())
      .add_json("target", target.name)
      .add_json("target_kind", target.kind())
      .add_row("source", source.description())
      .add_row("target", target.description())
      .add("method", "method", outcome.method)
      .add_json("status", to_string(match.status))
      .add_row("status", status_text(match.status))
      .add_json("initial", json_of(outcome.guess))
      .add_json("target_T_source", json_of(match.target_T_source))
      .add_json("matrix", matrix_of(match.target_T_source))
      .add_json("covariance", rows_of(match.covariance));
  add_pose_rows(result, "initial", outcome.guess);
  add_pose_rows(result, "target_T_source", match.target_T_source);
  add_sigma_rows(result, match);
  if (match.status == MatchStatus::kDegenerate)
    result.add_row("least known", open_direction(match, outcome.source.radius_m));
  result.add_json("rmse_m", match.rmse_m)
      .add_row("rmse", fmt::format("{:.3f}", 1e3 * match.rmse_m), "mm")
      .add_json("score", match.score)
      .add_row("explained", fmt::format("{:.1f}", 100.0 * match.score), "% of the source")
      .add_json("inlier_fraction", match.inlier_fraction)
      .add_json("pairs", match.pairs)
      .add_row("pairs", fmt::format("{}, {:.1f} % of the source", match.pairs,
                                    100.0 * match.inlier_fraction))
      .add("iterations", "iterations", match.iterations);
  if (outcome.sweep) add_sweep(result, *outcome.sweep);
  if (outcome.search) add_search(result, *outcome.search);
  if (outcome.map_match) add_map_match(result, *outcome.map_match);
  result.add_json("wall_time_s", wall_time_s)
      .add_row("time", fmt::format("{:.2f}", 1e3 * wall_time_s), "ms");
  return result;
}

void add_world_pose(Result& result, const Pose2& world_T_target, const MatchResult& match) {
  const PoseWithCovariance2 world_T_source =
      compound({world_T_target}, {match.target_T_source, match.covariance});
  result.add_json("world_T_source", json_of(world_T_source.pose))
      .add_json("world_covariance", rows_of(world_T_source.covariance))
      .add_json("world_T_target", json_of(world_T_target));
  add_pose_rows(result, "world_T_source", world_T_source.pose);
}

template Result report_match<2>(const MatchInput&, const MatchInput&, const AlignResult<2>&,
                                double);
template Result report_match<3>(const MatchInput&, const MatchInput&, const AlignResult<3>&,
                                double);

}  // namespace loopstone::app
