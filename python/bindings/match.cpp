#include <nanobind/nanobind.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>

#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "arrays.hpp"
#include "bindings.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/registration/align.hpp"
#include "loopstone/sensor/point_cloud.hpp"
#include "maps.hpp"
#include "options.hpp"
#include "robot.hpp"

namespace loopstone::python {

namespace {

/// A pose that the source may lie at.
struct Candidate {
  Pose2 pose{};
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  double score = 0.0;
  double rmse_m = 0.0;
};

/// Of the plane or of space: what a match found, as arrays.
struct Matched {
  int dimension = 2;
  Pose2 pose{};
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  Eigen::MatrixXd covariance{};
  std::string status{};
  std::string method{};
  bool supported = false;
  double rmse_m = 0.0;
  double inlier_fraction = 0.0;
  double score = 0.0;
  int pairs = 0;
  int iterations = 0;
  std::optional<bool> sure{};  ///< none: nobody looked elsewhere
  bool complete = true;
  std::vector<Candidate> candidates{};
};

/// How to match, whatever it is.
struct Request {
  AlignMethod method = AlignMethod::kAuto;
  std::optional<ArrayLike> guess{};
  std::optional<double> search_xy_m{};
  std::optional<double> search_yaw_rad{};
  bool anywhere = false;
  OptionValues options{};
  Threads threads{};
};

AlignMethod method_of(const std::string& word) {
  if (const auto method = find_word<AlignMethod>(word)) return *method;
  std::string known;
  for (const std::string_view w : kWords<AlignMethod>)
    known += (known.empty() ? "" : ", ") + std::string(w);
  throw UsageError("method = " + word + ": must be one of " + known);
}

Candidate candidate_at(const Pose2& pose) {
  Candidate at{.pose = pose};
  at.matrix.topLeftCorner<2, 2>() = pose.rotation();
  at.matrix.block<2, 1>(0, 3) = pose.translation();
  return at;
}

Candidate candidate_at(const Pose3& pose) {
  Candidate at{.pose = project_to_plane(pose)};
  at.matrix.topLeftCorner<3, 3>() = pose.rotation.toRotationMatrix();
  at.matrix.block<3, 1>(0, 3) = pose.translation;
  return at;
}

template <int kDimension>
Candidate candidate_of(const BasicMatchResult<kDimension>& match) {
  Candidate candidate = candidate_at(match.target_T_source);
  candidate.score = match.score;
  candidate.rmse_m = match.rmse_m;
  return candidate;
}

/// The answer and what else a search found, best first.
template <int kDimension>
void add_candidates(const AlignResult<kDimension>& aligned, Matched& m) {
  if (aligned.map_match) {
    m.sure = aligned.map_match->sure;
    m.complete = aligned.map_match->complete;
    for (const MatchResult& match : aligned.map_match->poses)
      m.candidates.push_back(candidate_of<2>(match));
    return;
  }
  if (m.supported) m.candidates.push_back(candidate_of<kDimension>(aligned.match));
  if (!aligned.search) return;
  m.sure = m.supported && !aligned.search->ambiguous;
  if (const auto& other = aligned.search->runner_up) {
    m.candidates.push_back(candidate_at(other->target_T_source));
    m.candidates.back().score = std::numeric_limits<double>::quiet_NaN();
    m.candidates.back().rmse_m = other->rmse_m;
  }
}

template <int kDimension>
Matched as_arrays(const AlignResult<kDimension>& aligned) {
  const auto& match = aligned.match;
  Matched m;
  m.dimension = kDimension;
  const Candidate best = candidate_of<kDimension>(match);
  m.pose = best.pose;
  m.matrix = best.matrix;
  m.covariance = match.covariance;
  m.status = std::string(loopstone::to_string(match.status));
  m.method = aligned.method;
  m.supported = has_supported_pose(match.status);
  m.rmse_m = match.rmse_m;
  m.inlier_fraction = match.inlier_fraction;
  m.score = match.score;
  m.pairs = match.pairs;
  m.iterations = match.iterations;
  add_candidates(aligned, m);
  return m;
}

template <int kDimension, typename OptionsFor>
AlignRequest<kDimension> request_of(const Request& given, OptionsFor&& defaults) {
  AlignRequest<kDimension> request;
  request.method = given.method;
  if (given.guess) {
    if constexpr (kDimension == 2) {
      request.guess = pose_of(*given.guess, "guess");
    } else {
      request.guess = pose3_of(*given.guess, "guess");
    }
  }
  request.search_xy_m = given.search_xy_m;
  request.search_yaw_rad = given.search_yaw_rad;
  request.anywhere = given.anywhere;
  request.threads = given.threads;
  AlignOptions<kDimension> options = defaults();
  set_options(list_options(options), given.options);
  request.options = options;
  return request;
}

/// One side: its points that can be used.
template <typename Point>
std::vector<Point> usable(std::vector<Point> points, const char* name) {
  std::erase_if(points, [](const Point& p) { return !is_usable_point(p); });
  if (points.empty())
    throw nb::value_error((std::string(name) + ": there is no point with finite numbers").c_str());
  return points;
}

std::vector<Eigen::Vector2d> cloud2(nb::handle object, const char* name) {
  return usable(points2_of({nb::borrow(object)}, name), name);
}

RobotScan robot_scan(const LaserScan& scan, const Robot* robot) {
  return {scan, mount_of(scan, robot == nullptr ? RobotModel{} : robot->model)};
}

template <typename Source, typename Target>
Matched match2(const Source& source, const Target& target, const AlignRequest<2>& request) {
  const nb::gil_scoped_release unlocked;
  return as_arrays<2>(align(source, target, request));
}

Matched match_to_map(nb::handle source, const GridMap& map, const Robot* robot,
                     const Request& given) {
  const CellStates& cells = *map.cells;
  const auto request = request_of<2>(given, [&] { return align_options_for(cells); });
  if (nb::isinstance<LaserScan>(source))
    return match2(robot_scan(nb::cast<const LaserScan&>(source), robot), cells, request);
  const std::vector<Eigen::Vector2d> points = cloud2(source, "source");
  return match2(std::span<const Eigen::Vector2d>(points), cells, request);
}

Matched match_scans(const LaserScan& source, nb::handle target, const Robot* robot,
                    const Request& given) {
  const auto request = request_of<2>(given, [] { return AlignOptions<2>{}; });
  return match2(robot_scan(source, robot), robot_scan(nb::cast<const LaserScan&>(target), robot),
                request);
}

Matched match_clouds3(nb::handle source, nb::handle target, const Request& given) {
  const auto a = usable(points3_of({nb::borrow(source)}, "source"), "source");
  const auto b = usable(points3_of({nb::borrow(target)}, "target"), "target");
  const auto request =
      request_of<3>(given, [&] { return align_options_for(std::span<const Eigen::Vector3d>(b)); });
  const nb::gil_scoped_release unlocked;
  return as_arrays<3>(
      align(std::span<const Eigen::Vector3d>(a), std::span<const Eigen::Vector3d>(b), request));
}

Matched match_clouds2(nb::handle source, nb::handle target, const Request& given) {
  const auto a = cloud2(source, "source");
  const auto b = cloud2(target, "target");
  const auto request =
      request_of<2>(given, [&] { return align_options_for(std::span<const Eigen::Vector2d>(b)); });
  return match2(std::span<const Eigen::Vector2d>(a), std::span<const Eigen::Vector2d>(b), request);
}

Matched match(nb::handle source, nb::handle target, const Robot* robot, const std::string& method,
              const std::optional<ArrayLike>& guess, const std::optional<double>& search_xy_m,
              const std::optional<double>& search_yaw_rad, bool anywhere,
              const OptionValues& options, int threads) {
  const Request given{method_of(method), guess,   search_xy_m,     search_yaw_rad,
                      anywhere,          options, Threads{threads}};
  if (nb::isinstance<GridMap>(target))
    return match_to_map(source, nb::cast<const GridMap&>(target), robot, given);
  const bool is_scan = nb::isinstance<LaserScan>(source);
  if (is_scan != nb::isinstance<LaserScan>(target)) {
    throw UsageError(
        "a LaserScan is matched to a LaserScan or to a map; for points of both sides take "
        "scan.points()");
  }
  if (is_scan) return match_scans(nb::cast<const LaserScan&>(source), target, robot, given);
  const std::size_t columns = columns_of({nb::borrow(source)}, "source");
  if (columns == 0 || columns != columns_of({nb::borrow(target)}, "target")) {
    throw nb::value_error(
        "source and target: expected arrays of shape (N, 2) and (M, 2), or (N, 3) and (M, 3)");
  }
  return columns == 3 ? match_clouds3(source, target, given) : match_clouds2(source, target, given);
}

template <typename Number>
Vector of_candidates(const Matched& self, Number&& number) {
  std::vector<double> values;
  for (const Candidate& candidate : self.candidates) values.push_back(number(candidate));
  const std::size_t count = values.size();
  return array_of<double, nb::ndim<1>>(std::move(values), {count});
}

void def_candidates(nb::class_<Matched>& matched) {
  matched.def_ro("sure", &Matched::sure,
                 "Of a search: the answer explains the source, and no other pose explains it\n"
                 "nearly as well. None where nobody looked elsewhere: from a guess.");
  matched.def_ro("complete", &Matched::complete,
                 "False: more places on the map look alike than were looked into.");
  def_array(
      matched, "candidates",
      [](const Matched& self) {
        std::vector<Pose2> poses;
        for (const Candidate& candidate : self.candidates) poses.push_back(candidate.pose);
        return to_array(std::span<const Pose2>(poses));
      },
      "(C, 3) target_T_source, best first: the answer and what else the search found; of\n"
      "clouds in space without z, roll and pitch. None when nothing was found.");
  def_array(
      matched, "candidate_matrices",
      [](const Matched& self) {
        std::vector<double> values;
        for (const Candidate& candidate : self.candidates) {
          const Eigen::Matrix<double, 4, 4, Eigen::RowMajor> rows = candidate.matrix;
          values.insert(values.end(), rows.data(), rows.data() + rows.size());
        }
        return array_of<double, nb::ndim<3>>(std::move(values), {self.candidates.size(), 4, 4});
      },
      "(C, 4, 4) the same.");
  def_array(
      matched, "candidate_scores",
      [](const Matched& self) {
        return of_candidates(self, [](const Candidate& c) { return c.score; });
      },
      "(C,) score of each; NaN of a cloud's other pose, which has none.");
  def_array(
      matched, "candidate_rmse_m",
      [](const Matched& self) {
        return of_candidates(self, [](const Candidate& c) { return c.rmse_m; });
      },
      "(C,) rmse_m of each; of a cloud's other pose over a sample of its points.");
}

}  // namespace

void bind_match(nb::module_& m) {
  nb::class_<Matched> matched(m, "MatchResult",
                              "Where a scan or cloud lies in the frame of another, or of a map.");
  matched.def_ro("dimension", &Matched::dimension, "2 or 3.");
  def_array(
      matched, "pose", [](const Matched& self) { return to_array(self.pose); },
      "(3,) target_T_source: x, y [m], yaw [rad]; of clouds in space without z, "
      "roll and pitch.");
  def_array(
      matched, "matrix", [](const Matched& self) { return to_array(Eigen::MatrixXd(self.matrix)); },
      "(4, 4) target_T_source.");
  def_array(
      matched, "covariance", [](const Matched& self) { return to_array(self.covariance); },
      "(3, 3) of x, y, yaw, or (6, 6) of x, y, z, rotation vector, axes of the\n"
      "target; infinite variances where no pose was found.");
  matched.def_ro("status", &Matched::status,
                 "``converged``, ``degenerate`` (a direction is open: the covariance is large\n"
                 "along it), ``not_converged`` or ``too_few_pairs``: then the pose is the guess.");
  matched.def_ro("method", &Matched::method, "What gave the answer.");
  matched.def_ro("supported", &Matched::supported, "Whether the data support the pose.");
  matched.def_ro("rmse_m", &Matched::rmse_m, "Of the residuals of the pairs used.");
  matched.def_ro("inlier_fraction", &Matched::inlier_fraction,
                 "[0, 1], share of the source's points that were paired.");
  matched.def_ro("score", &Matched::score, "[0, 1], share of the source that the target explains.");
  matched.def_ro("pairs", &Matched::pairs, "That were used in the end.");
  matched.def_ro("iterations", &Matched::iterations, "Of the method that gave the answer.");
  def_candidates(matched);
  matched.def("__bool__", [](const Matched& self) { return self.supported; });
  matched.def("__repr__", [](const Matched& self) {
    return "<MatchResult by " + self.method + ": " + self.status + ">";
  });
  m.def("match", match, nb::arg("source"), nb::arg("target"), nb::arg("robot").none(),
        nb::arg("method"), nb::arg("guess").none(), nb::arg("search_xy_m").none(),
        nb::arg("search_yaw_rad").none(), nb::arg("anywhere"), nb::arg("options"),
        nb::arg("threads"));
}

}  // namespace loopstone::python
