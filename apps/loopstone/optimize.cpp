#include <fmt/format.h>

#include <chrono>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bounds.hpp"
#include "commands.hpp"
#include "interrupt.hpp"
#include "loopstone/formats/image.hpp"
#include "loopstone/formats/text_file.hpp"
#include "loopstone/formats/tum.hpp"
#include "loopstone/report/graph_picture.hpp"
#include "loopstone/version.hpp"
#include "optimize_report.hpp"
#include "optimize_request.hpp"
#include "output_path.hpp"
#include "word_flag.hpp"

namespace loopstone::app {

namespace {

struct Arguments {
  std::string input;
  std::string output;
  std::optional<Initialisation> initial;  ///< none: best
  std::optional<DescentMethod> method;
  std::optional<RobustKernel> robust;
  bool gnc = false;  ///< in place of a kernel
  InformationOrder information_order = InformationOrder::kGuess;
  bool certify = false;
  std::string tum;
  std::string picture;
  std::string report;
  std::string edges;
  std::vector<std::string> require;
  bool force = false;
};

constexpr const char* kFooter = R"(
IN is a g2o file (VERTEX_SE2, VERTEX_XY, EDGE_SE2, EDGE_SE2_XY, EDGE_SE2_PRIOR, FIX) or a TORO file (VERTEX2, EDGE2), with or without
vertices. The cost is the sum of e^T Omega e over all edges, without 1/2, e = vector(measured^-1 (from^-1 to)) as in g2o.

Starts:   best           the cheapest of chordal, spanning_tree, odometry and the file's own poses; with gnc odometry
          chordal        all headings at once by a linear relaxation, then all positions: needs no guess and is hard to mislead
          spanning_tree  along the fewest edges; odometry: along the edges i, i + 1; file: as the file has them

--certify minimises the isotropic objective of SE-Sync (kappa = I33, tau = 2 / tr(I_tt^-1)) first, proves that its minimum is the
global one, and begins the solution there; a local minimum is left along its direction of negative curvature. What was certified,
the smallest eigenvalue, its tolerance and the largest gap that is left are part of the result. With a robust kernel the edges
that the solution kept (weight 0.5 or more) are certified; nothing is proven of those set aside, which may have been right.
--robust softens loop closures that disagree, by a kernel; gnc (graduated non-convexity) finds out which are wrong, up to most of
them, and leaves them out. --set reaches solver.*, gnc.* and certificate.*.

Examples:
  loopstone optimize graph.g2o -o solved.g2o --picture solved.png
  loopstone optimize graph.g2o --certify --json
  loopstone optimize graph.g2o --robust gnc --edges weights.csv        which closures were thrown out
  loopstone optimize old.graph -o new.g2o --information-order toro     TORO in, g2o out
  loopstone optimize graph.g2o --certify --require certified --require 'cost<=45.01'   exits with 3 if it is not so)";

OptimizeSettings settings_of(const Arguments& arguments, const AppContext& context) {
  auto settings = context.load_options<OptimizeSettings>();
  SolverOptions& solver = settings.solver;
  solver.robust_kernel = arguments.robust.value_or(solver.robust_kernel);
  solver.method = arguments.method.value_or(solver.method);
  return settings;
}

void check_usage(const Arguments& arguments) {
  const auto needs = [](const std::string& flag, const std::string& path, const char* extension) {
    if (path.empty() || std::filesystem::path(path).extension() == extension) return;
    throw UsageError(flag + " " + path + ": the name must end in " + extension);
  };
  needs("--picture", arguments.picture, ".png");
  needs("--report", arguments.report, ".html");
  needs("--edges", arguments.edges, ".csv");
}

Outputs outputs_of(const Arguments& arguments, const AppContext& context) {
  Outputs outputs(context, arguments.force);
  outputs.reads(arguments.input);
  const auto add = [&](const char* flag, const std::string& path) {
    if (!path.empty()) outputs.add_file(flag, path);
  };
  add("-o", arguments.output);
  add("--tum", arguments.tum);
  add("--picture", arguments.picture);
  add("--report", arguments.report);
  add("--edges", arguments.edges);
  return outputs;
}

/// A pose graph has no times: the ids stand for seconds.
Trajectory trajectory_of(const GraphFile& file) {
  std::vector<StampedPose2> poses;
  poses.reserve(file.ids.size());
  constexpr std::int64_t kMostSeconds = std::numeric_limits<std::int64_t>::max() / 1'000'000'000;
  for (std::size_t i = 0; i < file.ids.size(); ++i) {
    if (file.ids[i] > kMostSeconds) {
      throw UsageError(fmt::format("--tum: id {} is too large to stand for seconds", file.ids[i]));
    }
    poses.push_back({Stamp{file.ids[i] * 1'000'000'000}, file.graph.poses[i]});
  }
  return Trajectory(std::move(poses));
}

RunInfo info_of(const Arguments& arguments, OptimizeSettings settings, const GraphRun& run,
                const AppContext& context) {
  RunInfo info;
  info.log_path = arguments.input;
  info.command_line = context.command_line();
  info.version = kVersion;
  info.options_toml = options_to_toml(list_options(settings));
  info.wall_time_s = run.read_s + run.found.times.wall_s();
  return info;
}

void write_outputs(const Arguments& arguments, const OptimizeSettings& settings,
                   const GraphRun& run, const AppContext& context) {
  if (!arguments.output.empty()) write_g2o(arguments.output, run.file);
  if (!arguments.tum.empty()) write_tum(arguments.tum, trajectory_of(run.file));
  if (!arguments.picture.empty()) write_png(arguments.picture, draw_graph_run(run));
  if (!arguments.edges.empty()) write_text_file(arguments.edges, format_edge_weights(run));
  if (!arguments.report.empty()) {
    write_text_file(arguments.report,
                    format_graph_report(run, info_of(arguments, settings, run, context)));
  }
}

/// "converged" and "certified" demand a status; everything else is a bound on a figure.
std::vector<std::string> missed_demands(const Arguments& arguments, const Result& result) {
  std::vector<Bound> bounds;
  std::vector<std::string> missed;
  for (const std::string& text : arguments.require) {
    if (text == "converged") {
      const auto status = result.json().at("status").get<std::string>();
      if (status != "converged") missed.push_back("the solution is " + status);
    } else if (text == "certified") {
      if (!result.json().at("certified").get<bool>()) missed.emplace_back("it is not certified");
    } else {
      bounds.push_back(parse_bound(text));
    }
  }
  for (std::string& text : missed_bounds(bounds, result.figures()))
    missed.push_back(std::move(text));
  return missed;
}

void warn_of_file(const GraphFile& file, const AppContext& context) {
  for (const std::string& note : file.notes) context.note(note);
  for (const auto& [tag, count] : file.skipped_tags) {
    context.warn(fmt::format("{} {} of a kind that is not read: {}", count,
                             count == 1 ? "line" : "lines", tag));
  }
}

GraphOptimisationOptions options_for(const OptimizeRequest& request, const GraphFile& file) {
  GraphOptimisationOptions options;
  options.start = request.initial;
  options.poses_given = file.has_poses;
  if (options.start == Initialisation::kAsGiven && !file.has_poses) {
    throw UsageError("--initial file: the file has no VERTEX lines; use best, or chordal");
  }
  options.solver = request.settings.solver;
  if (request.gnc) options.gnc = request.settings.gnc;
  if (request.certify) options.certificate = request.settings.certificate;
  return options;
}

ExitCode run(const Arguments& arguments, const AppContext& context) {
  using Clock = std::chrono::steady_clock;
  check_usage(arguments);
  for (const std::string& text : arguments.require) {
    if (text == "certified" && !arguments.certify) {
      throw UsageError("--require certified needs --certify");
    }
    if (text != "converged" && text != "certified") (void)parse_bound(text);
  }
  OptimizeRequest request;
  request.initial = arguments.initial;
  request.certify = arguments.certify;
  request.gnc = arguments.gnc;
  request.settings = settings_of(arguments, context);
  const Outputs outputs = outputs_of(arguments, context);
  outputs.check();

  const auto begin = Clock::now();
  GraphFile file = read_g2o(arguments.input, arguments.information_order, context.memory());
  const double read_s = std::chrono::duration<double>(Clock::now() - begin).count();
  warn_of_file(file, context);
  require_connected(file, arguments.input);

  GraphOptimisation found = optimize_graph(file.graph, options_for(request, file));
  GraphRun run = make_graph_run(std::filesystem::path(arguments.input).filename().string(),
                                std::move(file), std::move(found));
  run.read_s = read_s;
  outputs.prepare();
  const HeldInterrupt held;  // all of the outputs, or none
  write_outputs(arguments, request.settings, run, context);

  const Result result = report_graph_run(run, request);
  const std::vector<std::string> missed = missed_demands(arguments, result);
  result.print(context);
  for (const std::string& text : missed) context.warn("bound missed: " + text);
  return missed.empty() ? kExitDone : kExitBoundMissed;
}

void add_output_flags(CLI::App& command, Arguments& arguments) {
  const auto add = [&command](const char* flag, std::string& value, const char* help,
                              const char* type) {
    command.add_option(flag, value, help)->type_name(type);
  };
  add("-o,--output", arguments.output, "the solved graph", "OUT.g2o");
  add("--tum", arguments.tum, "its trajectory; ids stand for seconds", "FILE.tum");
  add("--picture", arguments.picture, "before and after", "FILE.png");
  add("--report", arguments.report, "everything on one page", "FILE.html");
  add("--edges", arguments.edges, "chi2 and final weight of every edge", "FILE.csv");
  add_force_flag(command, arguments.force);
}

/// Words of an enum and one more.
void add_choices(CLI::App& command, Arguments& arguments) {
  std::vector<std::string> starts = word_list<Initialisation>();
  starts.insert(starts.begin(), "best");
  add_word_flag(command, {"--initial", starts, "where to start", "best"},
                [&arguments](const std::string& word) {
                  arguments.initial = find_word<Initialisation>(word);
                });
  add_word_flag(command, "--method", arguments.method,
                "how steps are found (default: gauss_newton)");
  std::vector<std::string> kernels = word_list<RobustKernel>();
  kernels.emplace_back("gnc");
  add_word_flag(
      command,
      {"--robust", kernels, "how edges that disagree with the rest are softened (default: none)"},
      [&arguments](const std::string& word) {
        arguments.robust = find_word<RobustKernel>(word);
        arguments.gnc = !arguments.robust;
      });
}

}  // namespace

void add_optimize_command(CLI::App& app, AppContext& context) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command =
      app.add_subcommand("optimize", "Solve a pose graph, and prove the solution optimal");
  command->add_option("IN", arguments->input, "a pose graph, g2o or TORO")->required();
  add_output_flags(*command, *arguments);
  add_choices(*command, *arguments);
  command->add_flag("--certify", arguments->certify,
                    "prove that the isotropic optimum, where the solution begins, is global");
  add_word_flag(*command, "--information-order", arguments->information_order,
                "of EDGE2 lines: toro (xx xy yy tt xt yt) or g2o (xx xy xt yy yt tt)");
  command
      ->add_option("--require", arguments->require,
                   "converged, certified, or a bound on a figure of --json's result; may be given "
                   "several times")
      ->type_name("KEY<=VALUE")
      ->allow_extra_args(false);
  context.add_common_flags(*command);
  context.add_option_flags(*command);
  command->footer(kFooter);
  context.on_run(*command, [arguments, &context] { return run(*arguments, context); });
}

}  // namespace loopstone::app
