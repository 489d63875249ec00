#include "mapping/floor_alignment.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstddef>

#include "mapping/floor_homography.hpp"

namespace loopstone {
namespace {

constexpr double kCell_m = 0.01;
constexpr double kHeightTolerance_m = 0.01;
constexpr double kMostDepth_m = 1.4;  ///< farther floor is too coarse in the picture
constexpr float kCoarse_m = 0.05F;
constexpr float kFine_m = 0.02F;
constexpr int kCoarseEvery = 3;  ///< points of the grid that are looked at
constexpr int kFineEvery = 2;    ///< boxes side by side
constexpr std::size_t kFewestPoints = 300;
constexpr double kLeastCorrelation = 0.7;
constexpr int kMostSteps = 15;
constexpr double kSettled_m = 5e-5;  // a tenth of what pictures tell
constexpr double kSettled_rad = 3e-5;

using Vector5d = Eigen::Matrix<double, 5, 1>;
using Matrix5d = Eigen::Matrix<double, 5, 5>;

}  // namespace

/// Normal equations about a pose: unknowns are the motion of the template (x, y, yaw), contrast and
/// brightness.
struct FloorAligner::Fit {
  Matrix5d normal = Matrix5d::Zero();
  Vector5d right = Vector5d::Zero();
  double squared_residuals = 0.0;
  double sum = 0.0;  ///< of both brightnesses, and their products, for the correlation
  double other_sum = 0.0;
  double squares = 0.0;
  double other_squares = 0.0;
  double products = 0.0;
  std::size_t points = 0;

  [[nodiscard]] double correlation() const {
    const auto n = static_cast<double>(points);
    const double a = squares - sum * sum / n;
    const double b = other_squares - other_sum * other_sum / n;
    const double ab = products - sum * other_sum / n;
    return a > 0.0 && b > 0.0 ? ab / std::sqrt(a * b) : 0.0;
  }
};

FloorAligner::FloorAligner(const CameraModel& camera, const FloorPlane& plane, double noise_per_m)
    : lenses_(camera),
      colour_homography_(
          floor_homography(colour_lens(camera), Pose2{}, robot_T_colour_optical(camera))
              .cast<float>()),
      depth_homography_(
          floor_homography(camera.depth, Pose2{}, robot_T_depth_optical(camera)).cast<float>()),
      from_{{}, FloorSight(camera, plane, noise_per_m, kHeightTolerance_m)},
      to_(from_) {
  const LensModel& lens = colour_lens(camera);
  constexpr double kReach_m = 3.0;
  const int cells = static_cast<int>(kReach_m / kCell_m);
  first_row_ = lens.height_px;
  for (int row = -cells; row <= cells; ++row) {
    for (int column = -cells; column <= cells; ++column) {
      const Eigen::Vector2f point(static_cast<float>(column * kCell_m),
                                  static_cast<float>(row * kCell_m));
      const Eigen::Vector3f seen = colour_homography_ * point.homogeneous();
      if (seen.z() < 0.1F || seen.z() > static_cast<float>(kMostDepth_m)) continue;
      Eigen::Vector2f pixel = seen.head<2>() / seen.z();
      if (is_distorted(lens)) {
        pixel = project(lens, Eigen::Vector3d(pixel.x(), pixel.y(), 1.0)).cast<float>();
      }
      if (pixel.x() < 0.0F || pixel.y() < 0.0F ||
          pixel.x() > static_cast<float>(lens.width_px - 1) ||
          pixel.y() > static_cast<float>(lens.height_px - 1)) {
        continue;
      }
      grid_m_.push_back(point);
      first_row_ = std::min(first_row_, static_cast<int>(pixel.y()));
    }
  }
  constexpr int kBoxRows = 24;  // boxes about the farthest points reach so much higher
  first_row_ = std::max(0, first_row_ - kBoxRows);
}

void FloorAligner::assign(View& view, const RgbdImages& images) const {
  view.sight.assign(images.depth);
  view.light.assign(images.colour, first_row_, images.colour.height);
}

float FloorAligner::brightness(const View& view, const Eigen::Vector2f& point_m,
                               float side_m) const {
  const Eigen::Vector3f seen = colour_homography_ * point_m.homogeneous();
  if (seen.z() < 0.1F || seen.z() > 1.3F * static_cast<float>(kMostDepth_m)) return -1.0F;
  const FloorBox box = lenses_.box(colour_homography_, seen, side_m);
  if (!lenses_.shows(box, static_cast<float>(first_row_))) return -1.0F;
  const Eigen::Vector2f measured_at =
      lenses_.depth_pixel(depth_homography_ * point_m.homogeneous());
  if (!view.sight.measured(measured_at.x(), measured_at.y()) || view.sight.hidden(box.u, box.v)) {
    return -1.0F;
  }
  const LinearRgb light = view.light.mean(box.u, box.v, box.width, box.height);
  return std::sqrt((light[0] + light[1] + light[2]) / 3.0F);
}

FloorAligner::Template FloorAligner::make_template(const View& view, float side_m,
                                                   int every) const {
  Template made;
  const float step_m = 0.5F * side_m;
  for (std::size_t i = 0; i < grid_m_.size(); ++i) {
    const Eigen::Vector2f& point = grid_m_[i];
    const auto column = static_cast<int>(std::lround(static_cast<double>(point.x()) / kCell_m));
    const auto row = static_cast<int>(std::lround(static_cast<double>(point.y()) / kCell_m));
    if (column % every != 0 || row % every != 0) continue;
    const float here = brightness(view, point, side_m);
    if (here < 0.0F) continue;
    const float ahead = brightness(view, point + Eigen::Vector2f(step_m, 0.0F), side_m);
    const float behind = brightness(view, point - Eigen::Vector2f(step_m, 0.0F), side_m);
    const float left = brightness(view, point + Eigen::Vector2f(0.0F, step_m), side_m);
    const float right = brightness(view, point - Eigen::Vector2f(0.0F, step_m), side_m);
    if (ahead < 0.0F || behind < 0.0F || left < 0.0F || right < 0.0F) continue;
    made.points_m.push_back(point);
    made.brightness.push_back(here);
    made.slope_per_m.emplace_back((ahead - behind) / (2.0F * step_m),
                                  (left - right) / (2.0F * step_m));
  }
  return made;
}

FloorAligner::Fit FloorAligner::measure(const Template& reference, const View& view,
                                        const Pose2& from_T_to, float side_m) const {
  Fit fit;
  const Pose2 to_T_from = from_T_to.inverse();
  const auto cosine = static_cast<float>(std::cos(to_T_from.yaw));
  const auto sine = static_cast<float>(std::sin(to_T_from.yaw));
  const auto x_m = static_cast<float>(to_T_from.x);
  const auto y_m = static_cast<float>(to_T_from.y);
  for (std::size_t i = 0; i < reference.points_m.size(); ++i) {
    const Eigen::Vector2f& p = reference.points_m[i];
    const float seen = brightness(
        view, {cosine * p.x() - sine * p.y() + x_m, sine * p.x() + cosine * p.y() + y_m}, side_m);
    if (seen < 0.0F) continue;
    const float known = reference.brightness[i];
    const Eigen::Vector2f& slope = reference.slope_per_m[i];
    Vector5d j;
    j << static_cast<double>(slope.x()), static_cast<double>(slope.y()),
        static_cast<double>(p.x() * slope.y() - p.y() * slope.x()), static_cast<double>(known), 1.0;
    const auto residual = static_cast<double>(seen - known);
    fit.normal.noalias() += j * j.transpose();
    fit.right += residual * j;
    fit.squared_residuals += residual * residual;
    const auto a = static_cast<double>(known);
    const auto b = static_cast<double>(seen);
    fit.sum += a;
    fit.other_sum += b;
    fit.squares += a * a;
    fit.other_squares += b * b;
    fit.products += a * b;
    ++fit.points;
  }
  return fit;
}

std::optional<FloorMotion> FloorAligner::align(const RgbdImages& from, const RgbdImages& to,
                                               std::span<const Pose2> guesses) {
  assign(from_, from);
  assign(to_, to);
  FloorMotion motion;
  bool is_first = true;
  Fit fit;
  for (const float side_m : {kCoarse_m, kFine_m}) {
    const Template reference =
        make_template(from_, side_m, side_m == kCoarse_m ? kCoarseEvery : kFineEvery);
    if (reference.points_m.size() < kFewestPoints) return {};
    if (is_first) {
      double best = -2.0;
      for (const Pose2& guess : guesses) {
        const double correlation = measure(reference, to_, guess, side_m).correlation();
        if (correlation > best) {
          best = correlation;
          motion.from_T_to = guess;
        }
      }
      is_first = false;
    }
    for (int step = 0; step < kMostSteps; ++step) {
      fit = measure(reference, to_, motion.from_T_to, side_m);
      if (fit.points < kFewestPoints) return {};
      const Eigen::LDLT<Matrix5d> factor(fit.normal);
      if (factor.info() != Eigen::Success || factor.vectorD().minCoeff() <= 0.0) return {};
      const Vector5d change = factor.solve(fit.right);
      // to(from_T_to^-1 p) = from(exp(change) p): the pose moves on by that motion, in the frame of
      // `from`.
      motion.from_T_to = Pose2{change[0], change[1], change[2]} * motion.from_T_to;
      if (change.head<2>().norm() < kSettled_m && std::abs(change[2]) < kSettled_rad) break;
    }
  }
  motion.correlation = fit.correlation();
  if (motion.correlation < kLeastCorrelation) return {};
  // What the five unknowns leave of the residuals.
  const Eigen::LDLT<Matrix5d> factor(fit.normal);
  const double explained = fit.right.dot(factor.solve(fit.right));
  const double variance = std::max(0.0, fit.squared_residuals - explained) /
                          static_cast<double>(std::max<std::size_t>(fit.points, 6) - 5);
  motion.covariance = variance * factor.solve(Matrix5d::Identity()).topLeftCorner<3, 3>();
  return motion;
}

}  // namespace loopstone
