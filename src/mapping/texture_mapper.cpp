#include "mapping/texture_mapper.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "geometry/symmetric_matrix.hpp"
#include "loopstone/base/median.hpp"
#include "loopstone/geometry/angle.hpp"
#include "loopstone/sensor/camera_geometry.hpp"
#include "mapping/floor_homography.hpp"

namespace loopstone {
namespace {

/// A frame whose floor is tilted by more against the others' was taken on a ramp, a sill or a jolt.
constexpr double kMostTilt_rad = 0.012;
/// A frame's brightness may differ by so much, up or down.
constexpr float kMostGain = 2.0F;

/// The part of a convex polygon where `inside` is not negative; inside is linear. Source:
/// Sutherland and Hodgman 1974, "Reentrant polygon clipping".
template <typename Inside>
std::vector<Eigen::Vector2d> clipped(const std::vector<Eigen::Vector2d>& polygon,
                                     const Inside& inside) {
  std::vector<Eigen::Vector2d> kept;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector2d& from = polygon[i];
    const Eigen::Vector2d& to = polygon[(i + 1) % polygon.size()];
    const double a = inside(from);
    const double b = inside(to);
    if (a >= 0.0) kept.push_back(from);
    if ((a >= 0.0) != (b >= 0.0)) kept.emplace_back(from + a / (a - b) * (to - from));
  }
  return kept;
}

Pose2 moved_in_place(const Pose2& pose, const Eigen::Vector3d& offset) {
  return {pose.x + offset[0], pose.y + offset[1], wrap_angle(pose.yaw + offset[2])};
}

/// The brightness of a square of the floor in a picture, and how it changes along the floor [1/m].
struct SeenLight {
  double value = 0.0;
  Eigen::Vector2d slope = Eigen::Vector2d::Zero();
};
SeenLight seen_light(const LightRows& light, const FloorBox& box) {
  const auto brightness = [&](float du, float dv) {
    const LinearRgb mean = light.mean(box.u + du, box.v + dv, box.width, box.height);
    return static_cast<double>(mean[0] + mean[1] + mean[2]) / 3.0;
  };
  const float du = 0.5F * box.width;
  const float dv = 0.5F * box.height;
  const double per_u = (brightness(du, 0.0F) - brightness(-du, 0.0F)) / (2.0 * du);
  const double per_v = (brightness(0.0F, dv) - brightness(0.0F, -dv)) / (2.0 * dv);
  return {brightness(0.0F, 0.0F),
          per_u * box.u_xy.cast<double>() + per_v * box.v_xy.cast<double>()};
}

/// Where a horizontal line cuts a convex polygon; left > right when it misses.
struct Span {
  double left = 1.0;
  double right = 0.0;
};
Span span_at(const std::vector<Eigen::Vector2d>& polygon, double y) {
  Span span{1e300, -1e300};
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Eigen::Vector2d& a = polygon[i];
    const Eigen::Vector2d& b = polygon[(i + 1) % polygon.size()];
    if ((a.y() <= y) == (b.y() <= y)) continue;
    const double x = a.x() + (y - a.y()) / (b.y() - a.y()) * (b.x() - a.x());
    span.left = std::min(span.left, x);
    span.right = std::max(span.right, x);
  }
  return span;
}

}  // namespace

TextureMapper::TextureMapper(const CameraModel& camera, const FloorEstimate& floor,
                             const TextureOptions& options)
    : camera_(camera),
      options_(options),
      robot_T_colour_(robot_T_colour_optical(camera)),
      robot_T_depth_(robot_T_depth_optical(camera)),
      footprint_(make_footprint()),
      // The area that a pixel covers on a plane is depth^3 / (fx fy height), its width depth / fx.
      blur_per_depth2_(static_cast<float>(
          1.0 / (colour_lens(camera).focal_y_px * robot_T_colour_.translation.z()))),
      width_per_depth_(static_cast<float>(1.0 / colour_lens(camera).focal_x_px)),
      most_blur2_m2_(static_cast<float>(options.max_blur_m * options.max_blur_m)),
      lenses_(camera),
      sight_(camera, floor.plane, floor.noise_per_m, options.height_tolerance_m),
      cells_(options.resolution_m) {}

void TextureMapper::look_from(const CameraModel& camera, const FloorEstimate& floor) {
  TextureMapper other(camera, floor, options_);
  camera_ = other.camera_;
  robot_T_colour_ = other.robot_T_colour_;
  robot_T_depth_ = other.robot_T_depth_;
  footprint_ = std::move(other.footprint_);
  blur_per_depth2_ = other.blur_per_depth2_;
  width_per_depth_ = other.width_per_depth_;
  lenses_ = other.lenses_;
  sight_ = std::move(other.sight_);
}

TextureMapper::Footprint TextureMapper::make_footprint() const {
  const LensModel& lens = colour_lens(camera_);
  // Boxes about a cell must stay in the picture; the outermost pixels are spoiled in many cameras.
  constexpr double kMargin_px = 8.0;
  std::vector<Eigen::Vector2d> picture{
      {kMargin_px, kMargin_px},
      {lens.width_px - 1 - kMargin_px, kMargin_px},
      {lens.width_px - 1 - kMargin_px, lens.height_px - 1 - kMargin_px},
      {kMargin_px, lens.height_px - 1 - kMargin_px}};
  const Eigen::Matrix3d robot_R_colour = robot_T_colour_.rotation.toRotationMatrix();
  const double height_m = robot_T_colour_.translation.z();
  const auto per_m = [&](const Eigen::Vector2d& pixel) {
    return -(robot_R_colour * ray_through(lens, pixel)).z() / height_m;
  };
  const double most_depth_m = std::sqrt(options_.max_blur_m * lens.focal_y_px * height_m);
  picture = clipped(
      picture, [&](const Eigen::Vector2d& pixel) { return per_m(pixel) - 1.0 / most_depth_m; });
  Footprint footprint;
  if (picture.size() < 3) return footprint;
  double low = lens.height_px;
  double high = 0.0;
  for (const Eigen::Vector2d& pixel : picture) {
    const Eigen::Vector3d on_floor =
        robot_T_colour_ * Eigen::Vector3d(ray_through(lens, pixel) / per_m(pixel));
    footprint.corners_robot.emplace_back(on_floor.head<2>());
    low = std::min(low, pixel.y());
    high = std::max(high, pixel.y());
  }
  footprint.first_row = std::max(0, static_cast<int>(low - kMargin_px));
  footprint.end_row = std::min(lens.height_px, static_cast<int>(high + kMargin_px) + 2);
  return footprint;
}

TextureMapper::Use TextureMapper::add(const RgbdImages& images, const FramePose& pose) {
  sight_.assign(images.depth);
  if (sight_.tilt_rad() > kMostTilt_rad) return Use::kTilted;
  light_.assign(images.colour, footprint_.first_row, footprint_.end_row);
  sample_cells(options_.refine_poses ? refined(pose) : pose);
  if (options_.level_exposure) level_samples();
  for (const Sample& sample : samples_) sample.cell->add(sample.light, sample.weight);
  return Use::kUsed;
}

TextureMapper::View TextureMapper::view_from(const FramePose& pose) const {
  const Eigen::Matrix3d colour =
      floor_homography(colour_lens(camera_), pose.map_T_robot_colour, robot_T_colour_);
  return {colour, colour.cast<float>(),
          floor_homography(camera_.depth, pose.map_T_robot_depth, robot_T_depth_),
          static_cast<float>(options_.exposure_s * std::abs(pose.speed_m_s)),
          static_cast<float>(options_.exposure_s * std::abs(pose.yaw_rate_rad_s))};
}

std::vector<TextureMapper::CellRun> TextureMapper::runs_seen_from(const Pose2& map_T_robot) const {
  std::vector<Eigen::Vector2d> corners;
  double low = 1e300;
  double high = -1e300;
  for (const Eigen::Vector2d& corner : footprint_.corners_robot) {
    corners.emplace_back(map_T_robot * corner);
    low = std::min(low, corners.back().y());
    high = std::max(high, corners.back().y());
  }
  std::vector<CellRun> runs;
  const double cell_m = options_.resolution_m;
  for (int row = floor_to_int(low / cell_m); row <= floor_to_int(high / cell_m); ++row) {
    const Span span = span_at(corners, (row + 0.5) * cell_m);
    if (span.left > span.right) continue;
    runs.push_back(
        {row, floor_to_int(span.left / cell_m + 0.5), floor_to_int(span.right / cell_m - 0.5)});
  }
  return runs;
}

bool TextureMapper::look(Cell cell, const View& view, Glimpse& glimpse) const {
  const Eigen::Vector3d floor((cell.column + 0.5) * options_.resolution_m,
                              (cell.row + 0.5) * options_.resolution_m, 1.0);
  const Eigen::Vector3f seen = (view.colour * floor).cast<float>();
  const float z = seen.z();
  const float blur_m = view.moved_m + view.turned_rad * z;
  const float length_m = blur_per_depth2_ * z * z;
  const float width_m = z * width_per_depth_;
  glimpse.blur2_m2 = length_m * length_m + width_m * width_m + blur_m * blur_m;
  if (glimpse.blur2_m2 > most_blur2_m2_) return false;

  glimpse.box = lenses_.box(view.colour_f, seen, static_cast<float>(options_.resolution_m));
  const Eigen::Vector2f measured_at = lenses_.depth_pixel((view.depth * floor).cast<float>());
  return sight_.measured(measured_at.x(), measured_at.y()) &&
         !sight_.hidden(glimpse.box.u, glimpse.box.v) && lenses_.shows(glimpse.box);
}

float TextureMapper::weight_of(const Glimpse& glimpse) const {
  // A sample that smears the floor over more than the cell says that much less about it. The fourth
  // power lets the sharpest views of a cell decide and still averages those that are alike (of 1 to
  // 8 the best, and flat, on simulated floors).
  const auto cell_m = static_cast<float>(options_.resolution_m);
  const float sharpness = 1.0F / (1.0F + glimpse.blur2_m2 / (cell_m * cell_m));
  return sharpness * sharpness * sharpness * sharpness;
}

void TextureMapper::sample_cells(const FramePose& pose) {
  samples_.clear();
  const View view = view_from(pose);
  Glimpse glimpse;
  for (const CellRun& run : runs_seen_from(pose.map_T_robot_colour)) {
    constexpr int kTileBits = TileGrid<TextureCell>::kTileBits;
    TileGrid<TextureCell>::Tile* tile = nullptr;
    int tile_column = 0;
    for (int column = run.first_column; column <= run.last_column; ++column) {
      const Cell cell{column, run.row};
      if (!look(cell, view, glimpse)) continue;
      if (tile == nullptr || (column >> kTileBits) != tile_column) {
        tile_column = column >> kTileBits;
        tile = &cells_.tile(TileGrid<TextureCell>::tile_of(cell));
      }
      samples_.push_back(
          {&(*tile)[TileGrid<TextureCell>::offset_in_tile(cell)],
           light_.mean(glimpse.box.u, glimpse.box.v, glimpse.box.width, glimpse.box.height),
           weight_of(glimpse)});
    }
  }
}

/// Of one step of refined(), over the cells that a frame shares with the map.
struct TextureMapper::StepSums {
  Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
  Eigen::Vector4d right = Eigen::Vector4d::Zero();
  double weights = 0.0;
  double squares = 0.0;
  std::size_t cells = 0;

  void add(const Eigen::Vector4d& slope, double residual, double weight) {
    normal.noalias() += weight * slope * slope.transpose();
    right -= weight * residual * slope;
    weights += weight;
    squares += weight * residual * residual;
    ++cells;
  }
};

TextureMapper::StepSums TextureMapper::compare(const FramePose& pose,
                                               const std::vector<CellRun>& runs, double gain,
                                               double sigma) const {
  constexpr double kSpacing_m = 0.04;
  constexpr float kLeastWeight = 0.05F * TextureCell::kWeightUnit;
  const int every = std::max(1, static_cast<int>(std::lround(kSpacing_m / options_.resolution_m)));
  const View view = view_from(pose);
  StepSums sums;
  Glimpse glimpse;
  for (const CellRun& run : runs) {
    if (run.row % every != 0) continue;
    for (int column = run.first_column; column <= run.last_column; ++column) {
      if (column % every != 0) continue;
      const Cell cell{column, run.row};
      const TextureCell* known = cells_.find(cell);
      if (known == nullptr || static_cast<float>(known->best.weight) < kLeastWeight ||
          !look(cell, view, glimpse)) {
        continue;
      }
      const SeenLight seen = seen_light(light_, glimpse.box);
      const auto& rgb = known->best.rgb;
      const double residual = gain * seen.value - (rgb[0] + rgb[1] + rgb[2]) / 3.0;
      // A robot moved by (x, y, yaw) sees at a cell what it saw before at the cell moved back by
      // that.
      const Eigen::Vector2d arm = cells_.centre_of(cell) - pose.map_T_robot_colour.translation();
      const Eigen::Vector4d slope(-gain * seen.slope.x(), -gain * seen.slope.y(),
                                  gain * (seen.slope.x() * arm.y() - seen.slope.y() * arm.x()),
                                  seen.value);
      const double ratio2 = residual * residual / (sigma * sigma);
      sums.add(slope, residual,
               static_cast<double>(weight_of(glimpse)) / ((1.0 + ratio2) * (1.0 + ratio2)));
    }
  }
  return sums;
}

FramePose TextureMapper::refined(const FramePose& given) const {
  // The pose under which the frame agrees best with what is on the map: Gauss-Newton on
  //   sum w rho((gain * seen(cell; pose) - known(cell)) / sigma) + |pose - given|^2_prior
  // over cells a few centimetres apart, with an unknown gain. The prior is what a good trajectory
  // is worth; it holds the pose where the floor has nothing to hold on to. Source: Newcombe et al.
  // 2011, "DTAM", section 2.3, for a plane.
  constexpr int kSteps = 3;
  constexpr std::size_t kFewest = 100;
  constexpr double kPrior_m = 0.004;
  constexpr double kPrior_rad = 0.002;
  constexpr double kOverlap = 16.0;  // neighbouring cells, and frames before, share their errors
  constexpr double kLeastSigma = 0.01 * 65535.0;

  const std::vector<CellRun> runs = runs_seen_from(given.map_T_robot_colour);
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();  // of the pose about its own place, map axes
  double gain = 1.0;
  double sigma = 0.05 * 65535.0;
  FramePose pose = given;
  for (int step = 0; step < kSteps; ++step) {
    StepSums sums = compare(pose, runs, gain, sigma);
    if (sums.cells < kFewest || sums.weights <= 0.0) return given;
    sigma = std::max(kLeastSigma, 2.0 * std::sqrt(sums.squares / sums.weights));
    sums.normal /= kOverlap * sigma * sigma;
    sums.right /= kOverlap * sigma * sigma;
    const Eigen::Vector4d prior(1.0 / (kPrior_m * kPrior_m), 1.0 / (kPrior_m * kPrior_m),
                                1.0 / (kPrior_rad * kPrior_rad), 1e-12);
    sums.normal.diagonal() += prior;
    sums.right.head<3>() -= prior.head<3>().cwiseProduct(offset);
    const Eigen::Vector4d change = solve_symmetric(sums.normal, sums.right);
    offset += change.head<3>();
    gain += change[3];
    if (!(gain > 1.0 / kMostGain && gain < kMostGain) || offset.head<2>().norm() > 4.0 * kPrior_m ||
        std::abs(offset[2]) > 4.0 * kPrior_rad) {
      return given;
    }
    pose.map_T_robot_colour = moved_in_place(given.map_T_robot_colour, offset);
    pose.map_T_robot_depth = moved_in_place(given.map_T_robot_depth, offset);
  }
  return pose;
}

void TextureMapper::level_samples() {
  // Brightness against what earlier frames saw of the same cells, each channel by itself (white
  // balance wanders as well): the median ratio, so that what has changed on the floor does not
  // count. A channel in which the floor is too dark to tell is levelled as all of them together.
  constexpr std::size_t kEvery = 7;
  constexpr std::size_t kFewest = 100;
  constexpr std::size_t kAll = 3;
  constexpr float kDark = 0.01F * 65535.0F;  // where the ratio is mostly noise
  for (auto& ratios : ratios_) ratios.clear();
  for (std::size_t i = 0; i < samples_.size(); i += kEvery) {
    const TextureMode& known = samples_[i].cell->best;
    const LinearRgb& light = samples_[i].light;
    if (known.weight == 0) continue;
    const auto add = [&](std::size_t channel, float seen, float before) {
      if (seen > kDark && before > kDark) ratios_[channel].push_back(seen / before);
    };
    for (std::size_t c = 0; c < 3; ++c) add(c, light[c], static_cast<float>(known.rgb[c]));
    add(kAll, light[0] + light[1] + light[2],
        static_cast<float>(known.rgb[0]) + static_cast<float>(known.rgb[1]) +
            static_cast<float>(known.rgb[2]));
  }
  if (ratios_[kAll].size() < kFewest) return;
  double log_gain = 0.0;
  for (std::size_t c = 0; c < 3; ++c) {
    const float ratio = median_of(ratios_[ratios_[c].size() < kFewest ? kAll : c]);
    // A little less than the whole difference, so that levels a long way apart do not add up
    // errors.
    constexpr float kForget = 0.98F;
    const float gain = std::pow(std::clamp(ratio, 1.0F / kMostGain, kMostGain), kForget);
    for (Sample& sample : samples_) sample.light[c] /= gain;
    log_gain += std::log(static_cast<double>(gain)) / 3.0;
  }
  ++frames_levelled_;
  log_gain_sum_ += log_gain;
  log_gain_sum2_ += log_gain * log_gain;
}

TextureMapper::Brightness TextureMapper::brightness() const {
  if (frames_levelled_ == 0) return {};
  const auto n = static_cast<double>(frames_levelled_);
  const double mean = log_gain_sum_ / n;
  return {std::exp(mean), std::sqrt(std::max(0.0, log_gain_sum2_ / n - mean * mean))};
}

}  // namespace loopstone
