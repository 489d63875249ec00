#include <fmt/format.h>

#include <memory>

#include "bounds.hpp"
#include "commands.hpp"
#include "log_flags.hpp"
#include "loopstone/evaluation/map_score.hpp"
#include "loopstone/evaluation/relations.hpp"
#include "loopstone/evaluation/trajectory_error.hpp"
#include "loopstone/formats/decimal_stamp.hpp"
#include "loopstone/formats/mrclam.hpp"
#include "loopstone/formats/relations_file.hpp"
#include "loopstone/formats/ros_map.hpp"
#include "loopstone/formats/truth_log.hpp"
#include "loopstone/formats/tum.hpp"
#include "result.hpp"
#include "word_flag.hpp"

namespace loopstone::app {

namespace {

struct Arguments {
  std::string estimate;
  std::string reference;
  std::string truth_topic;
  std::string relations;
  Alignment align = Alignment::kSe2;
  std::string rpe = "1m";
  RelationErrorOrder order = RelationErrorOrder::kMeasuredTimesInverseExpected;
  std::string map;
  std::string true_map;
  double tolerance_m = 0.1;
  std::vector<std::string> require;
};

constexpr const char* kFooter = R"(
Trajectories are TUM files (t x y z qx qy qz qw). Stamps that one file lacks are interpolated in the estimate; what lies
outside its time is counted as missing.

Examples:
  loopstone evaluate --estimate out/trajectory.tum --reference sim/truth.tum
  loopstone evaluate --estimate out/trajectory.tum --relations intel.relations --json
  loopstone evaluate --estimate out/trajectory.tum --reference sim/truth.tum --map out/map.yaml --true-map sim/map.yaml
  loopstone evaluate --estimate out/trajectory.tum --reference run.bag --truth-topic /ground_truth
  loopstone evaluate --estimate a.tum --reference b.tum --require 'ate_rmse_m<=0.05'     exits with 3 if it is more)";

struct Stretch {
  double length;
  Spacing spacing;
};

/// "1m", "0.5s", "10f".
Stretch parse_stretch(const std::string& text) {
  std::size_t used = 0;
  double length = 0.0;
  try {
    length = std::stod(text, &used);
  } catch (const std::exception&) {
    used = 0;
  }
  const std::string unit = text.substr(used);
  if (used > 0 && length > 0.0) {
    if (unit == "m") return {length, Spacing::kMetres};
    if (unit == "s") return {length, Spacing::kSeconds};
    if (unit == "f") return {length, Spacing::kFrames};
  }
  throw UsageError("--rpe " + text + ": must be a length such as 1m, 0.5s or 10f (frames)");
}

std::string span_of(const Trajectory& trajectory) {
  return format_decimal_stamp(trajectory.front().stamp) + " to " +
         format_decimal_stamp(trajectory.back().stamp) + " s";
}

/// Mean, std, rmse, median and max under the key; one row for people.
void add_statistics(Result& result, const std::string& key, std::string_view label,
                    const ErrorStatistics& s, double scale, std::string_view unit) {
  result.add_json(key + ".mean", s.mean * scale)
      .add_json(key + ".std", s.std * scale)
      .add_json(key + ".rmse", s.rmse * scale)
      .add_json(key + ".median", s.median * scale)
      .add_json(key + ".max", s.max * scale)
      .add_row(
          label,
          fmt::format("{:.4f} +- {:.4f}   rmse {:.4f}   median {:.4f}   max {:.4f}", s.mean * scale,
                      s.std * scale, s.rmse * scale, s.median * scale, s.max * scale),
          unit);
}

/// A TUM file, or what a log knows of the truth.
Trajectory read_reference(const Arguments& arguments, const AppContext& context) {
  if (is_mrclam_truth(arguments.reference))
    return read_mrclam_truth(arguments.reference, context.memory());
  if (arguments.truth_topic.empty()) return read_tum(arguments.reference, context.memory());
  return read_truth(arguments.reference, arguments.truth_topic, {.memory = context.memory()});
}

AbsoluteError add_trajectory_errors(Result& result, const Arguments& arguments,
                                    const Trajectory& estimate, const AppContext& context) {
  const Stretch stretch = parse_stretch(arguments.rpe);
  const Trajectory reference = read_reference(arguments, context);
  AbsoluteError absolute = absolute_error(estimate, reference, arguments.align);
  if (absolute.poses == 0) {
    throw DataError({arguments.estimate}, "has no time in common with the reference: it covers " +
                                              span_of(estimate) + ", the reference " +
                                              span_of(reference));
  }
  const RelativeError relative =
      relative_error(estimate, reference, stretch.length, stretch.spacing);
  const double to_degrees = degrees(1.0);

  result.add_json("ate_rmse_m", absolute.translation_m.rmse)
      .add_json("ate_rmse_rad", absolute.rotation_rad.rmse);
  add_statistics(result, "ate_translation_m", "absolute position error", absolute.translation_m,
                 1.0, "m");
  add_statistics(result, "ate_rotation_deg", "absolute heading error", absolute.rotation_rad,
                 to_degrees, "deg");
  const std::string over = relative.pairs > 0 ? "over " + arguments.rpe : "(no pair so far apart)";
  add_statistics(result, "rpe.translation_m", "relative position error " + over,
                 relative.translation_m, 1.0, "m");
  add_statistics(result, "rpe.rotation_deg", "relative heading error " + over,
                 relative.rotation_rad, to_degrees, "deg");
  result.add_json("rpe.delta", arguments.rpe).add_json("rpe.pairs", relative.pairs);
  const Pose2& aligned = absolute.reference_T_estimate;
  result.add("align", "alignment", std::string(to_string(arguments.align)))
      .add_json("reference_T_estimate.x_m", aligned.x)
      .add_json("reference_T_estimate.y_m", aligned.y)
      .add_json("reference_T_estimate.yaw_rad", aligned.yaw)
      .add("poses", "poses compared", absolute.poses)
      .add("poses_missing", "reference poses outside the estimate", absolute.poses_missing);
  return absolute;
}

void add_relations_error(Result& result, const Arguments& arguments, const Trajectory& estimate,
                         const AppContext& context) {
  const std::vector<Relation> relations = read_relations(arguments.relations, context.memory());
  const RelationsError error = relations_error(estimate, relations, arguments.order);
  if (error.pairs == 0) {
    throw DataError({arguments.estimate},
                    fmt::format("none of the {} relations lies within its time, {}; relations with "
                                "Unix stamps need a trajectory with Unix stamps",
                                relations.size(), span_of(estimate)));
  }
  add_statistics(result, "translation_error_m", "translation error", error.translation_m, 1.0, "m");
  add_statistics(result, "squared_translation_error_m2", "squared translation error",
                 error.squared_translation_m2, 1.0, "m^2");
  add_statistics(result, "rotation_error_deg", "rotation error", error.rotation_rad, degrees(1.0),
                 "deg");
  add_statistics(result, "squared_rotation_error_deg2", "squared rotation error",
                 error.squared_rotation_deg2, 1.0, "deg^2");
  result.add("pairs", "relations compared", error.pairs)
      .add("pairs_interpolated", "of them between two poses", error.pairs_interpolated)
      .add("pairs_missing", "relations outside the trajectory", error.missing.size());
  for (const Relation& relation : error.missing) {
    context.note(fmt::format("{}: relation {} {} lies outside the trajectory", arguments.relations,
                             format_decimal_stamp(relation.from),
                             format_decimal_stamp(relation.to)));
  }
}

void add_map_score(Result& result, const Arguments& arguments, const Pose2& truth_T_map,
                   const MemoryBudget& budget) {
  const Grid<CellState> map = classify_cells(read_ros_map(arguments.map, budget));
  const Grid<CellState> truth = classify_cells(read_ros_map(arguments.true_map, budget));
  const MapScore score = score_map(map, truth, truth_T_map, arguments.tolerance_m);
  result.add("map.precision", "map: occupied cells that are true", score.precision)
      .add("map.recall", "map: true surfaces that were found", score.recall)
      .add("map.f1", "map: F1 of both", score.f1)
      .add("map.free_iou", "map: free space, intersection / union", score.free_iou)
      .add("map.mean_distance_m", "map: occupied cell to the truth", score.mean_distance_m, "m")
      .add("map.mean_gap_m", "map: true surface to the map", score.mean_gap_m, "m")
      .add_json("map.tolerance_m", arguments.tolerance_m)
      .add_json("map.occupied_cells", score.occupied_cells)
      .add_json("map.surface_cells", score.surface_cells);
}

void check_usage(const Arguments& arguments) {
  if (arguments.reference.empty() && arguments.relations.empty() && arguments.map.empty()) {
    throw UsageError("evaluate needs something to compare with: --reference, --relations or --map");
  }
  if (arguments.estimate.empty() != (arguments.reference.empty() && arguments.relations.empty())) {
    throw UsageError("--reference and --relations judge a trajectory: --estimate goes with them");
  }
  if (arguments.map.empty() != arguments.true_map.empty()) {
    throw UsageError("--map and --true-map go together");
  }
}

ExitCode run(const Arguments& arguments, const AppContext& context) {
  const std::vector<Bound> bounds = parse_bounds(arguments.require);
  check_usage(arguments);

  Result result;
  Pose2 truth_T_map;
  if (!arguments.estimate.empty()) {
    const Trajectory estimate = read_tum(arguments.estimate, context.memory());
    if (!arguments.reference.empty()) {
      // The map stands in the estimate's frame, so what aligns the one aligns the other.
      truth_T_map =
          add_trajectory_errors(result, arguments, estimate, context).reference_T_estimate;
    }
    if (!arguments.relations.empty()) add_relations_error(result, arguments, estimate, context);
  }
  if (!arguments.map.empty()) add_map_score(result, arguments, truth_T_map, context.memory());

  const std::vector<std::string> missed = missed_bounds(bounds, result.figures());
  result.print(context);
  return report_missed(missed, context);
}

}  // namespace

void add_evaluate_command(CLI::App& app, AppContext& context) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command =
      app.add_subcommand("evaluate", "Errors of a trajectory or a map against the truth");
  command->add_option("--estimate", arguments->estimate, "the trajectory to judge")
      ->type_name("A.tum");
  command->add_option("--reference", arguments->reference, "the true trajectory: ATE and RPE")
      ->type_name("B.tum");
  add_truth_topic_flag(*command, arguments->truth_topic,
                       "--reference is a log: its true poses (a topic, tf:FRAME, or TRUEPOS)");
  command
      ->add_option("--relations", arguments->relations,
                   "true relations (t1 t2 x y z roll pitch yaw): the metric of Kuemmerle 2009")
      ->type_name("FILE");
  command->add_option("--map", arguments->map, "the map to judge, as map_server reads it")
      ->type_name("A.yaml");
  command
      ->add_option("--true-map", arguments->true_map,
                   "the true map; --reference's alignment is applied to --map")
      ->type_name("B.yaml");
  command
      ->add_option("--tolerance", arguments->tolerance_m,
                   "how far a wall may be off to count as found [m]")
      ->type_name("M")
      ->check(CLI::Range(0.0, 10.0))
      ->capture_default_str();
  add_word_flag(*command, "--align", arguments->align,
                "bring the estimate onto the reference first, or take it as it is");
  command
      ->add_option("--rpe", arguments->rpe, "stretch of the relative error: 1m, 0.5s, 10f (frames)")
      ->type_name("LENGTH")
      ->capture_default_str();
  add_word_flag(*command, "--order", arguments->order,
                "of the relation error: measured * expected^-1, or expected^-1 * measured");
  add_require_flag(*command, arguments->require);
  context.add_common_flags(*command);
  command->footer(kFooter);
  context.on_run(*command, [arguments, &context] { return run(*arguments, context); });
}

}  // namespace loopstone::app
