#include "loopstone/simulation/camera_renderer.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "loopstone/geometry/roll_pitch_yaw.hpp"
#include "loopstone/sensor/camera_geometry.hpp"
#include "loopstone/simulation/simulated_camera.hpp"
#include "simulation/camera_view.hpp"
#include "simulation/skyline.hpp"

namespace loopstone {
namespace {

const LinearColour kPlaster(0.62F, 0.6F, 0.54F);
const LinearColour kSkirting(0.1F, 0.09F, 0.085F);
const LinearColour kCeilingColour(0.8F, 0.8F, 0.78F);
const LinearColour kTrousers(0.03F, 0.04F, 0.09F);
constexpr double kSkirtingHeight = 0.07;  ///< [m]

/// Paint of furniture; a thing keeps its own.
LinearColour furniture_colour(std::size_t thing) {
  static const std::array<LinearColour, 6> kPaints{
      LinearColour(0.3F, 0.17F, 0.08F),  LinearColour(0.35F, 0.36F, 0.38F),
      LinearColour(0.13F, 0.2F, 0.3F),   LinearColour(0.42F, 0.3F, 0.18F),
      LinearColour(0.16F, 0.25F, 0.15F), LinearColour(0.07F, 0.07F, 0.08F),
  };
  return kPaints[(thing * 2654435761U >> 7U) % kPaints.size()];
}

struct Paint {
  LinearColour colour{};
  bool is_wall = false;
};

/// Of every surface, as SurfaceIndex numbers them.
struct Solids {
  explicit Solids(const FloorPlan& plan) : circles(plan.circles) {
    for (const Segment& side : flat_surfaces(plan)) {
      const Eigen::Vector2d along = (side.to - side.from).normalized();
      normals.emplace_back(along.y(), -along.x());
      const std::size_t box = paints.size() / 4;  // the outlines of the boxes come first
      const bool is_wall = box >= plan.boxes.size() || plan.boxes[box].is_wall;
      paints.push_back({is_wall ? kPlaster : furniture_colour(box), is_wall});
    }
    for (std::size_t i = 0; i < circles.size(); ++i) {
      const bool is_column = circles[i].radius_m > 0.2;
      paints.push_back({is_column ? kPlaster : furniture_colour(1000 + i), is_column});
    }
  }

  [[nodiscard]] Eigen::Vector2d normal_at(std::uint32_t surface, const Eigen::Vector2d& point,
                                          const std::vector<Circle>& legs) const {
    if (surface < normals.size()) return normals[surface];
    const Circle& circle = surface >= Skyline::kFirstLeg ? legs[surface - Skyline::kFirstLeg]
                                                         : circles[surface - normals.size()];
    return (point - circle.centre) / circle.radius_m;
  }

  std::vector<Circle> circles;
  std::vector<Eigen::Vector2d> normals{};  ///< of the flat ones, either way
  std::vector<Paint> paints{};
};

/// Walls that face the windows are brighter.
LinearColour shaded(const Paint& paint, const Eigen::Vector2d& normal, double height_m) {
  const double to_window = std::abs(normal.dot(Eigen::Vector2d(0.8, 0.6)));
  const auto shade = static_cast<float>(0.7 + 0.3 * to_window - 0.04 * height_m);
  if (paint.is_wall && height_m < kSkirtingHeight) return kSkirting * shade;
  return paint.colour * shade;
}

/// a + b b^T / 12: the footprint while it moves along b.
FloorFootprint smeared(const FloorFootprint& a, float bx, float by) {
  constexpr float kBoxVariance = 1.0F / 12.0F;
  return {a.xx + kBoxVariance * bx * bx, a.xy + kBoxVariance * bx * by,
          a.yy + kBoxVariance * by * by};
}

FloorFootprint rotated(const FloorFootprint& a, float c, float s) {
  return {c * c * a.xx - 2.0F * c * s * a.xy + s * s * a.yy,
          c * s * (a.xx - a.yy) + (c * c - s * s) * a.xy,
          s * s * a.xx + 2.0F * c * s * a.xy + c * c * a.yy};
}

Skyline skyline_of(const SurfaceIndex& surfaces, const CameraView& view, const Pose2& map_T_robot,
                   const std::vector<Circle>& legs) {
  const Eigen::Vector2d origin = map_T_robot * Eigen::Vector2d(view.robot_p_camera.head<2>());
  return {surfaces,
          legs,
          origin,
          map_T_robot.yaw + view.first_bearing_rad,
          view.bearing_step_rad,
          view.bearings,
          CameraView::kFarthest};
}

}  // namespace

CameraModel true_camera(const CameraModel& model, const SimulatedCamera& options) {
  CameraModel camera = model;
  const Eigen::Vector3d angles = to_roll_pitch_yaw(model.robot_T_camera);
  const Eigen::Vector3d up(0.0, 0.0, options.height_error_m);
  camera.robot_T_camera = Pose3::from_roll_pitch_yaw(
      model.robot_T_camera.translation + up, angles.x() + options.roll_error_rad,
      angles.y() + options.pitch_error_rad, angles.z());
  return camera;
}

struct CameraRenderer::Parts {
  const SurfaceIndex& surfaces;
  std::shared_ptr<const FloorPattern> floor;
  Solids solids;
  CameraView colour;
  CameraView depth;
};

CameraRenderer::CameraRenderer(const World& world, const SurfaceIndex& surfaces,
                               const CameraModel& camera)
    : parts_(new Parts{
          surfaces,
          world.floor ? world.floor
                      : std::make_shared<const FloorPattern>(make_floor("mixed", world.seed)),
          Solids(world.plan), make_camera_view(colour_lens(camera), robot_T_colour_optical(camera)),
          make_camera_view(camera.depth, robot_T_depth_optical(camera))}) {}

CameraRenderer::CameraRenderer(CameraRenderer&&) noexcept = default;
CameraRenderer::~CameraRenderer() = default;

LightImage CameraRenderer::light(const ExposedPose& pose, const std::vector<Circle>& legs) const {
  const CameraView& view = parts_->colour;
  const Solids& solids = parts_->solids;
  const FloorPattern& floor = *parts_->floor;
  const Skyline skyline = skyline_of(parts_->surfaces, view, pose.map_T_robot, legs);
  const Eigen::Vector2d origin = pose.map_T_robot * Eigen::Vector2d(view.robot_p_camera.head<2>());
  const double c = std::cos(pose.map_T_robot.yaw);
  const double s = std::sin(pose.map_T_robot.yaw);
  const auto cf = static_cast<float>(c);
  const auto sf = static_cast<float>(s);
  const auto camera_x = static_cast<float>(view.robot_p_camera.x());
  const auto camera_y = static_cast<float>(view.robot_p_camera.y());
  const auto travelled = static_cast<float>(pose.travelled_m);
  const auto turned = static_cast<float>(pose.turned_rad);

  LightImage image{view.width, view.height, {}};
  image.pixels.resize(view.rays.size());
  for (std::size_t i = 0; i < view.rays.size(); ++i) {
    const PixelRay& ray = view.rays[i];
    const auto dx = static_cast<double>(ray.direction_x);
    const auto dy = static_cast<double>(ray.direction_y);
    const Eigen::Vector2d direction(c * dx - s * dy, s * dx + c * dy);
    const SurfaceHit hit = skyline.nearer_than(ray.flat_range_m, ray.bearing, direction);
    if (hit.surface != SurfaceHit::kNothing) {
      const Eigen::Vector2d normal =
          solids.normal_at(hit.surface, origin + hit.range_m * direction, legs);
      const double height = view.robot_p_camera.z() + static_cast<double>(ray.slope) * hit.range_m;
      const Paint paint =
          hit.surface >= Skyline::kFirstLeg ? Paint{kTrousers, false} : solids.paints[hit.surface];
      image.pixels[i] = shaded(paint, normal, height);
    } else if (ray.slope < 0.0F) {
      // A point of the floor that a pixel sees moves with the robot: v + w x p.
      const float x = camera_x + ray.flat_range_m * ray.direction_x;
      const float y = camera_y + ray.flat_range_m * ray.direction_y;
      const FloorFootprint footprint = smeared(ray.footprint, travelled - turned * y, turned * x);
      image.pixels[i] = floor.seen_over(origin + static_cast<double>(ray.flat_range_m) * direction,
                                        rotated(footprint, cf, sf));
    } else {
      image.pixels[i] = kCeilingColour;
    }
  }
  return image;
}

TrueDepth CameraRenderer::depth(const Pose2& map_T_robot, const std::vector<Circle>& legs) const {
  const CameraView& view = parts_->depth;
  const Skyline skyline = skyline_of(parts_->surfaces, view, map_T_robot, legs);
  const Eigen::Vector2d origin = map_T_robot * Eigen::Vector2d(view.robot_p_camera.head<2>());
  const double c = std::cos(map_T_robot.yaw);
  const double s = std::sin(map_T_robot.yaw);
  TrueDepth seen;
  seen.depth = {view.width, view.height, std::vector<float>(view.rays.size(), 0.0F)};
  seen.facing.assign(view.rays.size(), 0.0F);
  for (std::size_t i = 0; i < view.rays.size(); ++i) {
    const PixelRay& ray = view.rays[i];
    const auto dx = static_cast<double>(ray.direction_x);
    const auto dy = static_cast<double>(ray.direction_y);
    const Eigen::Vector2d direction(c * dx - s * dy, s * dx + c * dy);
    const SurfaceHit hit = skyline.nearer_than(ray.flat_range_m, ray.bearing, direction);
    const float horizontal_share = 1.0F / std::sqrt(1.0F + ray.slope * ray.slope);
    if (hit.surface != SurfaceHit::kNothing) {
      const Eigen::Vector2d normal =
          parts_->solids.normal_at(hit.surface, origin + hit.range_m * direction, legs);
      seen.depth.per_m[i] = 1.0F / (static_cast<float>(hit.range_m) * ray.depth_per_m);
      seen.facing[i] = horizontal_share * static_cast<float>(std::abs(normal.dot(direction)));
    } else if (static_cast<double>(ray.flat_range_m) < CameraView::kFarthest) {
      seen.depth.per_m[i] = 1.0F / (ray.flat_range_m * ray.depth_per_m);
      seen.facing[i] = horizontal_share * std::abs(ray.slope);
    }
  }
  return seen;
}

}  // namespace loopstone
