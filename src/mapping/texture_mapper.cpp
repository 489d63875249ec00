#include "mapping/texture_mapper.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "loopstone/sensor/camera_geometry.hpp"
#include "mapping/floor_homography.hpp"

namespace loopstone {
namespace {

/// A frame whose floor is tilted by more against the others' was taken on a ramp, a sill or a jolt.
constexpr double kMostTilt_rad = 0.012;
/// A frame's brightness may differ by so much, up or down.
constexpr float kMostGain = 2.0F;

/// The part of a convex polygon where `inside` is not negative; inside is linear. Source: Sutherland and Hodgman 1974,
/// "Reentrant polygon clipping".
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
      sight_(camera, floor.plane, floor.noise_per_m, options.height_tolerance_m),
      cells_(options.resolution_m) {}

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
  samples_.clear();
  sample_cells(pose);
  if (options_.level_exposure) level_samples();
  for (const Sample& sample : samples_) sample.cell->add(sample.light, sample.weight);
  return Use::kUsed;
}

void TextureMapper::sample_cells(const FramePose& pose) {
  std::vector<Eigen::Vector2d> corners;
  double low = 1e300;
  double high = -1e300;
  for (const Eigen::Vector2d& corner : footprint_.corners_robot) {
    corners.emplace_back(pose.map_T_robot_colour * corner);
    low = std::min(low, corners.back().y());
    high = std::max(high, corners.back().y());
  }
  const Eigen::Matrix3d colour =
      floor_homography(colour_lens(camera_), pose.map_T_robot_colour, robot_T_colour_);
  const Eigen::Matrix3d depth =
      floor_homography(camera_.depth, pose.map_T_robot_depth, robot_T_depth_);
  const bool distorted = is_distorted(colour_lens(camera_)) || is_distorted(camera_.depth);
  const double cell_m = options_.resolution_m;
  for (int row = floor_to_int(low / cell_m); row <= floor_to_int(high / cell_m); ++row) {
    const Span span = span_at(corners, (row + 0.5) * cell_m);
    if (span.left > span.right) continue;
    const int first = floor_to_int(span.left / cell_m + 0.5);
    const int last = floor_to_int(span.right / cell_m - 0.5);
    if (distorted) {
      sample_row<true>(row, first, last, colour, depth, pose);
    } else {
      sample_row<false>(row, first, last, colour, depth, pose);
    }
  }
}

template <bool kDistorted>
void TextureMapper::sample_row(int row, int first_column, int last_column,
                               const Eigen::Matrix3d& colour, const Eigen::Matrix3d& depth,
                               const FramePose& pose) {
  const LensModel& lens = colour_lens(camera_);
  const auto cell_m = static_cast<float>(options_.resolution_m);
  const float cell2 = cell_m * cell_m;
  const auto per_focal = static_cast<float>(1.0 / lens.focal_x_px);
  const auto moved_m = static_cast<float>(options_.exposure_s * std::abs(pose.speed_m_s));
  const auto turned_rad = static_cast<float>(options_.exposure_s * std::abs(pose.yaw_rate_rad_s));
  const auto most_blur2 = static_cast<float>(options_.max_blur_m * options_.max_blur_m);
  const auto right = static_cast<float>(lens.width_px) - 1.0F;
  const auto bottom = static_cast<float>(lens.height_px) - 1.0F;
  const double y_m = (row + 0.5) * options_.resolution_m;

  using Tile = TileGrid<TextureCell>::Tile;
  constexpr int kTileBits = TileGrid<TextureCell>::kTileBits;
  Tile* tile = nullptr;
  int tile_column = 0;
  for (int column = first_column; column <= last_column; ++column) {
    const Eigen::Vector3d floor((column + 0.5) * options_.resolution_m, y_m, 1.0);
    const Eigen::Vector3f seen = (colour * floor).cast<float>();
    const float z = seen.z();
    const float blur_m = moved_m + turned_rad * z;
    const float length_m = blur_per_depth2_ * z * z;
    const float width_m = z * per_focal;
    const float blur2 = length_m * length_m + width_m * width_m + blur_m * blur_m;
    if (blur2 > most_blur2) continue;

    const float per_z = 1.0F / z;
    float u = seen.x() * per_z;
    float v = seen.y() * per_z;
    // How the pixel moves with the cell, along the map's x and y.
    float u_x = (static_cast<float>(colour(0, 0)) - u * static_cast<float>(colour(2, 0))) * per_z;
    float u_y = (static_cast<float>(colour(0, 1)) - u * static_cast<float>(colour(2, 1))) * per_z;
    float v_x = (static_cast<float>(colour(1, 0)) - v * static_cast<float>(colour(2, 0))) * per_z;
    float v_y = (static_cast<float>(colour(1, 1)) - v * static_cast<float>(colour(2, 1))) * per_z;
    const Eigen::Vector3f measured_at = (depth * floor).cast<float>();
    float depth_u = measured_at.x() / measured_at.z();
    float depth_v = measured_at.y() / measured_at.z();
    if constexpr (kDistorted) {
      const auto fx = static_cast<float>(lens.focal_x_px);
      const auto fy = static_cast<float>(lens.focal_y_px);
      if (is_distorted(lens)) {
        const Eigen::Vector2f at = project(lens, Eigen::Vector3d(u, v, 1.0)).cast<float>();
        u = at.x();
        v = at.y();
        u_x *= fx, u_y *= fx, v_x *= fy, v_y *= fy;
      }
      if (is_distorted(camera_.depth)) {
        const Eigen::Vector2f at =
            project(camera_.depth, Eigen::Vector3d(depth_u, depth_v, 1.0)).cast<float>();
        depth_u = at.x();
        depth_v = at.y();
      }
    }
    if (!sight_.measured(depth_u, depth_v) || sight_.hidden(u, v)) continue;
    // An upright box of the outline's variances; at least a pixel, which is to interpolate between pixels.
    const float width = std::max(1.0F, cell_m * std::sqrt(u_x * u_x + u_y * u_y));
    const float height = std::max(1.0F, cell_m * std::sqrt(v_x * v_x + v_y * v_y));
    if (u - 0.5F * width < 0.0F || v - 0.5F * height < 0.0F || u + 0.5F * width > right ||
        v + 0.5F * height > bottom) {
      continue;
    }
    if (tile == nullptr || (column >> kTileBits) != tile_column) {
      tile_column = column >> kTileBits;
      tile = &cells_.tile({tile_column, row >> kTileBits});
    }
    // A sample that smears the floor over more than the cell says that much less about it. The fourth power lets the sharpest
    // views of a cell decide and still averages those that are alike (of 1 to 8 the best, and flat, on simulated floors).
    const float sharpness = 1.0F / (1.0F + blur2 / cell2);
    const float sharpness2 = sharpness * sharpness;
    samples_.push_back({&(*tile)[TileGrid<TextureCell>::offset_in_tile({column, row})],
                        light_.mean(u, v, width, height), sharpness2 * sharpness2});
  }
}

void TextureMapper::level_samples() {
  // Brightness against what earlier frames saw of the same cells, each channel by itself (white balance wanders as well): the
  // median ratio, so that what has changed on the floor does not count.
  constexpr std::size_t kEvery = 7;
  constexpr std::size_t kFewest = 100;
  constexpr float kDark = 0.01F * 65535.0F;  // where the ratio is mostly noise
  for (auto& ratios : ratios_) ratios.clear();
  for (std::size_t i = 0; i < samples_.size(); i += kEvery) {
    const TextureMode& known = samples_[i].cell->best;
    if (known.weight == 0) continue;
    for (std::size_t c = 0; c < 3; ++c) {
      if (known.rgb[c] > kDark && samples_[i].light[c] > kDark) {
        ratios_[c].push_back(samples_[i].light[c] / static_cast<float>(known.rgb[c]));
      }
    }
  }
  double log_gain = 0.0;
  for (std::size_t c = 0; c < 3; ++c) {
    if (ratios_[c].size() < kFewest) return;
    const auto middle = ratios_[c].begin() + static_cast<std::ptrdiff_t>(ratios_[c].size() / 2);
    std::nth_element(ratios_[c].begin(), middle, ratios_[c].end());
    // A little less than the whole difference, so that levels a long way apart do not add up errors.
    constexpr float kForget = 0.98F;
    const float gain = std::pow(std::clamp(*middle, 1.0F / kMostGain, kMostGain), kForget);
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
