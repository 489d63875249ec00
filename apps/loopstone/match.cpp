#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <initializer_list>
#include <memory>

#include "bounds.hpp"
#include "commands.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/base/number_text.hpp"
#include "loopstone/formats/log_scan.hpp"
#include "loopstone/formats/point_cloud_file.hpp"
#include "loopstone/registration/align.hpp"
#include "loopstone/report/match_picture.hpp"
#include "match_arguments.hpp"
#include "match_report.hpp"
#include "output_path.hpp"
#include "parse_pose.hpp"

namespace loopstone::app {

namespace {

Outputs outputs_of(const MatchArguments& arguments, const AppContext& context) {
  Outputs outputs(context, arguments.force);
  for (const std::string& input : {arguments.source, arguments.target}) {
    const auto scan = parse_scan_name(input);
    if (scan) {
      outputs.reads_log(scan->log);
    } else {
      outputs.reads(input);
    }
  }
  if (!arguments.png.empty()) outputs.add_file("--png", arguments.png);
  if (!arguments.aligned.empty()) outputs.add_file("--aligned", arguments.aligned);
  return outputs;
}

void check_pair(const MatchInput& source, const MatchInput& target,
                const MatchArguments& arguments) {
  if (source.map) throw UsageError("a map can only be the target: match SCAN " + source.name);
  if (source.planar() != target.planar()) {
    const MatchInput& flat = source.planar() ? source : target;
    const MatchInput& deep = source.planar() ? target : source;
    throw UsageError("'" + flat.name + "' lies in the plane and '" + deep.name +
                     "' in space: they have no common motion");
  }
  if (!source.planar() && !arguments.target_pose.empty()) {
    throw UsageError("--target-pose is for the plane");
  }
}

/// Throws DataError for a cloud of fewer than 3 points: nothing can be laid on it.
void require_points(const MatchInput& target) {
  if (!target.cloud) return;
  const auto& points = target.cloud->points;
  if (std::count_if(points.begin(), points.end(),
                    [](const auto& point) { return is_usable_point(point); }) < 3) {
    throw DataError({target.name},
                    "has fewer than 3 points with finite coordinates; nothing can be laid on it");
  }
}

/// Coordinates in other units than metres.
void scale(MatchInput& input, const std::string& flag, double factor) {
  if (factor == 1.0) return;
  if (!input.cloud) throw UsageError(flag + " is for point clouds; '" + input.name + "' is none");
  for (Eigen::Vector3d& point : input.cloud->points) point *= factor;
}

/// Two clouds of very different size hardly show the same thing in the same unit.
void warn_of_units(const MatchInput& source, const MatchInput& target, const AppContext& context) {
  if (!source.cloud || !target.cloud) return;
  const double target_m = cloud_extent<3>(target.points3()).radius_m;
  const double source_m = cloud_extent<3>(source.points3()).radius_m;
  if (!(std::min(target_m, source_m) > 0.0)) return;  // a single point has no size
  const double ratio = target_m / source_m;
  if (ratio > 50.0) {
    context.warn(
        fmt::format("the target is {} times larger than the source; if it is in "
                    "millimetres: --target-scale 0.001",
                    number_text(ratio, 3)));
  } else if (ratio < 1.0 / 50.0) {
    context.warn(
        fmt::format("the source is {} times larger than the target; if it is in "
                    "millimetres: --source-scale 0.001",
                    number_text(1.0 / ratio, 3)));
  }
}

template <int kDimension>
void write_png(const MatchArguments& arguments, const MatchInput& source, const MatchInput& target,
               const std::vector<Eigen::Matrix<double, kDimension, 1>>& source_points,
               const std::vector<Eigen::Matrix<double, kDimension, 1>>& target_points,
               const AlignResult<kDimension>& outcome) {
  if (arguments.png.empty()) return;
  MatchScene<kDimension> scene;
  scene.source = source_points;
  scene.target = target_points;
  if (target.map) scene.map = &*target.map;
  scene.guess_target_T_source = outcome.guess;
  scene.target_T_source = outcome.match.target_T_source;
  if (arguments.global) scene.before = "before: no guess";
  scene.after = fmt::format("after: {}, {:.0f} % explained", to_string(outcome.match.status),
                            100.0 * outcome.match.score);
  scene.shows_robot = source.scan.has_value();
  loopstone::write_png(arguments.png, draw_match_picture<kDimension>(scene));
}

template <typename Points, typename Pose>
PointCloud moved(const Points& points, const Pose& target_T_source) {
  PointCloud cloud;
  for (const auto& point : points) {
    Eigen::Vector3d place = Eigen::Vector3d::Zero();
    const auto target_point = (target_T_source * point).eval();
    place.head(target_point.size()) = target_point;
    cloud.points.push_back(place);
  }
  return cloud;
}

/// The defaults that suit both sides, under what the user set.
AlignOptions<2> options_in_plane(const MatchInput& source, const MatchInput& target,
                                 const AppContext& context) {
  if (target.map) return context.load_options(align_options_for(*target.map));
  if (!source.cloud) return context.load_options<AlignOptions<2>>();
  return context.load_options(align_options_for(target.points2()));
}

AlignResult<2> align_in_plane(const MatchInput& source, const MatchInput& target,
                              const AlignRequest<2>& request) {
  if (target.map) {
    return source.scan ? align(source.robot_scan(), *target.map, request)
                       : align(source.points2(), *target.map, request);
  }
  if (source.scan && target.scan) return align(source.robot_scan(), target.robot_scan(), request);
  return align(source.points2(), target.points2(), request);
}

template <int kDimension>
Result run_in(const MatchArguments& arguments, const MatchInput& source, const MatchInput& target,
              const AppContext& context) {
  using Points = std::vector<Eigen::Matrix<double, kDimension, 1>>;
  AlignRequest<kDimension> request = match_request<kDimension>(arguments, context.threads());
  AlignResult<kDimension> outcome;
  Points source_points;
  Points target_points;
  if constexpr (kDimension == 2) {
    source_points = source.points2();
    target_points = target.points2();
    request.options = options_in_plane(source, target, context);
  } else {
    source_points = source.points3();
    target_points = target.points3();
    request.options = context.load_options(align_options_for(target_points));
  }
  const auto begin = std::chrono::steady_clock::now();
  if constexpr (kDimension == 2) {
    outcome = align_in_plane(source, target, request);
  } else {
    outcome = align(source_points, target_points, request);
  }
  const double wall_time_s =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  Result result = report_match<kDimension>(source, target, outcome, wall_time_s);
  if constexpr (kDimension == 2) {
    if (!arguments.target_pose.empty()) {
      add_world_pose(result, parse_pose2("--target-pose", arguments.target_pose), outcome.match);
    }
  }
  write_png<kDimension>(arguments, source, target, source_points, target_points, outcome);
  if (!arguments.aligned.empty()) {
    write_point_cloud(arguments.aligned, moved(source_points, outcome.match.target_T_source));
  }
  return result;
}

/// "converged" demands the status; everything else is a bound on a figure.
std::vector<std::string> missed_demands(const MatchArguments& arguments, const Result& result) {
  std::vector<Bound> bounds;
  std::vector<std::string> missed;
  const auto status = result.json().at("status").get<std::string>();
  for (const std::string& text : arguments.require) {
    if (text != "converged") {
      bounds.push_back(parse_bound(text));
    } else if (status != "converged") {
      missed.push_back("the match is " + status);
    }
  }
  for (std::string& text : missed_bounds(bounds, result.figures()))
    missed.push_back(std::move(text));
  return missed;
}

ExitCode run(const MatchArguments& arguments, const AppContext& context) {
  check_match_usage(arguments);
  for (const std::string& text : arguments.require) {
    if (text != "converged") (void)parse_bound(text);
  }
  (void)context.load_options<AlignOptions<2>>();
  const Outputs outputs = outputs_of(arguments, context);
  outputs.check();
  outputs.prepare();
  MatchInput source = read_match_input(arguments.source, context);
  MatchInput target = read_match_input(arguments.target, context);
  scale(source, "--source-scale", arguments.source_scale);
  scale(target, "--target-scale", arguments.target_scale);
  check_pair(source, target, arguments);
  require_points(target);
  warn_of_units(source, target, context);
  const Result result = source.planar() ? run_in<2>(arguments, source, target, context)
                                        : run_in<3>(arguments, source, target, context);
  const std::vector<std::string> missed = missed_demands(arguments, result);
  result.print(context);
  return report_missed(missed, context);
}

}  // namespace

void add_match_command(CLI::App& app, AppContext& context) {
  auto arguments = std::make_shared<MatchArguments>();
  CLI::App* command =
      app.add_subcommand("match", "Align two scans or clouds, or a scan with a map");
  add_match_flags(*command, *arguments);
  add_force_flag(*command, arguments->force);
  add_require_flag(
      *command, arguments->require,
      "converged, or a bound on a figure of --json's result; may be given several times");
  context.add_common_flags(*command);
  context.add_threads_flag(*command);
  context.add_option_flags(*command);
  context.add_robot_flag(*command);
  context.on_run(*command, [arguments, &context] { return run(*arguments, context); });
}

}  // namespace loopstone::app
