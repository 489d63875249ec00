#include "match_arguments.hpp"

#include "loopstone/base/error.hpp"
#include "loopstone/formats/point_cloud_file.hpp"
#include "loopstone/registration/icp_guess.hpp"
#include "parse_pose.hpp"
#include "word_flag.hpp"

namespace loopstone::app {

namespace {

constexpr const char* kFooter = R"(
SOURCE and TARGET: a scan of a log, LOG#120 (number, from 0) or LOG@+12.5 (seconds after the first scan; LOG@1000.5 by the
log's clock), of a folder with several sets DIR#20#120; a point cloud, .pcd .ply .npy .mat (FILE.mat#variable) .csv .xyz .txt;
TARGET may also be a map, map.yaml. Clouds whose z is 0 or absent are in the plane. A scan stands for the robot's pose.

Methods: auto     scan to scan: search about the guess, then Gauss-Newton; scan to map: from --initial on the map's distances,
                  in the window of --search-xy, or without either anywhere; clouds: icp_plane from --initial, else from the
                  better of identity and centroids, else by search
         icp_*    iterated closest points to points, lines or planes; gicp: planes of both sides
         grid     Gauss-Newton on a grid; correlative: every pose in a window (branch and bound), then refinement
--set reaches the options of each: icp, icp_cloud, cloud_search, scans, map, map_match, field, grid.

Status: converged; degenerate (a direction or a choice is left open; see covariance); not_converged and too_few_pairs are no
match. A match that fails is a result, too (exit code 0); for scripts, --require converged makes it exit code 3.

Examples:
  loopstone match sim#120 sim#119                                            motion between two scans
  loopstone match sim#120 sim#119 --target-pose 4,3,0.5                      and where that leads in the world
  loopstone match sim#120 map.yaml --initial 4,3,0 --search-xy 5 --search-yaw 3.15   from a guess that is wrong by metres
  loopstone match sim#120 map.yaml --global --png where.png                  from no guess at all
  loopstone match part.npy model.mat --target-scale 0.001 --global           a partial cloud to a model in millimetres
  loopstone match a.ply b.pcd --initial centroids --sweep-yaw 36 --aligned a_on_b.ply)";

Pose3 parse_pose3(const std::string& flag, const std::string& text) {
  const std::vector<double> v = parse_numbers(flag, text);
  if (v.size() != 6) {
    throw UsageError(flag + " " + text + ": must be X,Y,Z,ROLL,PITCH,YAW [m, rad] in space");
  }
  return Pose3::from_roll_pitch_yaw({v[0], v[1], v[2]}, v[3], v[4], v[5]);
}

void add_input_and_search_flags(CLI::App& command, MatchArguments& arguments) {
  command.add_option("SOURCE", arguments.source, "scan or point cloud to move")->required();
  command.add_option("TARGET", arguments.target, "scan, point cloud or map to move it onto")
      ->required();
  add_word_flag(command, "--method", arguments.method, "how");
  command
      .add_option("--initial", arguments.initial,
                  "guess of target_T_source: X,Y,YAW [m, rad]; in space X,Y,Z,ROLL,PITCH,YAW; or "
                  "identity, or centroids")
      ->type_name("POSE");
  command
      .add_option("--search-xy", arguments.search_xy_m,
                  "search this far about the guess, in x and in y [m]")
      ->type_name("M")
      ->check(CLI::Range(0.0, 1000.0));
  command
      .add_option("--search-yaw", arguments.search_yaw_rad,
                  "and this far about its heading [rad]; 3.15: all around")
      ->type_name("RAD")
      ->check(CLI::Range(0.0, 6.3));
  command.add_flag("--global", arguments.global, "no guess at all: search everywhere");
  command
      .add_option("--sweep-yaw", arguments.sweep_yaw,
                  "match from so many headings around the guess and tell how many agree")
      ->type_name("N")
      ->check(CLI::Range(1, 100000));
  command
      .add_option("--target-pose", arguments.target_pose,
                  "where the target stands in the world; prints world_T_source, too")
      ->type_name("X,Y,YAW");
  for (const bool is_source : {true, false}) {
    command
        .add_option(is_source ? "--source-scale" : "--target-scale",
                    is_source ? arguments.source_scale : arguments.target_scale,
                    "coordinates of that cloud times this are metres; 0.001 for millimetres")
        ->type_name("FACTOR")
        ->check(CLI::Range(1e-9, 1e9))
        ->capture_default_str();
  }
}

void add_output_flags(CLI::App& command, MatchArguments& arguments) {
  command.add_option("--png", arguments.png, "picture of before and after")->type_name("FILE.png");
  command
      .add_option("--aligned", arguments.aligned, "write the source's points in the target's frame")
      ->type_name("FILE.ply|FILE.pcd");
}

}  // namespace

void add_match_flags(CLI::App& command, MatchArguments& arguments) {
  add_input_and_search_flags(command, arguments);
  add_output_flags(command, arguments);
  command.footer(kFooter);
}

void check_match_usage(const MatchArguments& arguments) {
  if (arguments.global && !arguments.initial.empty()) {
    throw UsageError("--global needs no guess: leave out --initial, or give it with --search-xy");
  }
  if (arguments.global && (arguments.search_xy_m || arguments.search_yaw_rad)) {
    throw UsageError("--global searches everywhere: leave out --search-xy and --search-yaw");
  }
  // Wrong options are refused before anything is read; --initial once it is known whether space or
  // plane.
  if (!arguments.target_pose.empty()) (void)parse_pose2("--target-pose", arguments.target_pose);
  if (!arguments.aligned.empty() && !can_write_point_cloud(arguments.aligned)) {
    throw UsageError("--aligned " + arguments.aligned + ": a cloud is written as .ply or .pcd");
  }
}

template <int kDimension>
AlignRequest<kDimension> match_request(const MatchArguments& arguments, Threads threads) {
  AlignRequest<kDimension> request;
  request.method = arguments.method;
  request.search_xy_m = arguments.search_xy_m;
  request.search_yaw_rad = arguments.search_yaw_rad;
  request.anywhere = arguments.global;
  request.sweep_yaw = arguments.sweep_yaw;
  request.threads = threads;
  const auto guess = find_word<IcpGuess>(arguments.initial);
  if (guess == IcpGuess::kIdentity) {
    request.guess.emplace();
  } else if (guess == IcpGuess::kCentroids) {
    request.from_centroids = true;
  } else if (!arguments.initial.empty()) {
    if constexpr (kDimension == 2) {
      request.guess = parse_pose2("--initial", arguments.initial);
    } else {
      request.guess = parse_pose3("--initial", arguments.initial);
    }
  }
  return request;
}

template AlignRequest<2> match_request<2>(const MatchArguments&, Threads);
template AlignRequest<3> match_request<3>(const MatchArguments&, Threads);

}  // namespace loopstone::app
