#include "report/plane_panel.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "geometry/symmetric_matrix.hpp"
#include "loopstone/geometry/angle.hpp"
#include "report/map_view.hpp"
#include "report/round_length.hpp"

namespace loopstone {

std::string readable_length(double length_m) {
  if (length_m < 0.01) return fmt::format("{:g} mm", length_m * 1e3);
  if (length_m < 1.0) return fmt::format("{:g} cm", length_m * 1e2);
  return fmt::format("{:g} m", length_m);
}

PlanePanel::PlanePanel(Point corner, double width_px, double height_px, const ViewBox& box,
                       double pixels_per_metre)
    : corner_(corner),
      width_px_(width_px),
      height_px_(height_px),
      centre_(0.5 * (box.low + box.high)),
      pixels_per_metre_(pixels_per_metre) {}

Point PlanePanel::pixel_of(const Eigen::Vector2d& point) const {
  const Eigen::Vector2d offset = (point - centre_) * pixels_per_metre_;
  return {corner_.x + 0.5 * width_px_ + offset.x(), corner_.y + 0.5 * height_px_ - offset.y()};
}

bool PlanePanel::shows(Point pixel) const {
  return pixel.x >= corner_.x && pixel.y >= corner_.y && pixel.x <= corner_.x + width_px_ &&
         pixel.y <= corner_.y + height_px_;
}

void PlanePanel::dot(Canvas& canvas, const Eigen::Vector2d& point, double side_px,
                     const Colour& colour) const {
  const Point pixel = pixel_of(point);
  if (!shows(pixel)) return;
  canvas.fill_rectangle({pixel.x - 0.5 * side_px, pixel.y - 0.5 * side_px}, side_px, side_px,
                        colour);
}

Image PlanePanel::shade(const CellStates& map) const {
  const double left = std::ceil(corner_.x);
  const double top = std::ceil(corner_.y);
  Image image = make_image(static_cast<int>(width_px_), static_cast<int>(height_px_), 3);
  std::uint8_t* pixel = image.bytes.data();
  // A pixel is as dark as the darkest cell under it, so that walls stay when cells are smaller than
  // pixels.
  const double pixel_m = 1.0 / pixels_per_metre_;
  const int reach = static_cast<int>(pixel_m / map.frame().resolution);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x, pixel += 3) {
      const Eigen::Vector2d offset(left + x + 0.5 - corner_.x - 0.5 * width_px_,
                                   corner_.y + 0.5 * height_px_ - top - y - 0.5);
      const Cell cell = map.frame().cell_of(centre_ + offset * pixel_m);
      std::int8_t state = kUnknownCell;
      for (int r = 0; r <= reach; ++r) {
        for (int c = 0; c <= reach; ++c) {
          state = std::max(state, map.value_or({cell.column + c, cell.row + r}, kUnknownCell));
        }
      }
      const Rgb colour = cell_rgb(state);
      std::copy(colour.begin(), colour.end(), pixel);
    }
  }
  return image;
}

void PlanePanel::paste(Canvas& canvas, const Image& shaded) const {
  canvas.paste(shaded, static_cast<int>(std::ceil(corner_.x)),
               static_cast<int>(std::ceil(corner_.y)));
}

void PlanePanel::robot(Canvas& canvas, const Pose2& pose, const Colour& colour) const {
  const Point at = pixel_of(pose.translation());
  if (!shows(at)) return;
  const double size = std::clamp(0.022 * std::max(width_px_, height_px_), 7.0, 22.0);
  const double c = std::cos(pose.yaw);
  const double s = std::sin(pose.yaw);
  const auto corner = [&](double forward, double left) -> Point {
    return {at.x + size * (c * forward - s * left), at.y - size * (s * forward + c * left)};
  };
  canvas.polygon({corner(1.2, 0.0), corner(-0.8, 0.75), corner(-0.4, 0.0), corner(-0.8, -0.75)},
                 colour, 1.5, hex_colour(0xffffff));
}

void PlanePanel::ellipse(Canvas& canvas, const Eigen::Vector2d& centre,
                         const Eigen::Matrix2d& covariance, double times, double width_px,
                         const Colour& colour) const {
  const auto axes = symmetric_eigen(covariance);
  const Eigen::Vector2d half = times * axes.values.cwiseMax(0.0).cwiseSqrt();
  constexpr int kCorners = 48;
  std::vector<Point> outline;
  for (int i = 0; i <= kCorners; ++i) {
    const double angle = 2.0 * kPi * i / kCorners;
    const Eigen::Vector2d offset(half.x() * std::cos(angle), half.y() * std::sin(angle));
    outline.push_back(pixel_of(centre + axes.vectors * offset));
  }
  canvas.line(outline, width_px, colour);
}

void PlanePanel::frame(Canvas& canvas, const Colour& colour) const {
  const double right = corner_.x + width_px_;
  const double bottom = corner_.y + height_px_;
  canvas.line({corner_, {right, corner_.y}, {right, bottom}, {corner_.x, bottom}, corner_}, 1.0,
              colour);
}

void PlanePanel::scale_bar(Canvas& canvas, double text_px, const Colour& ink,
                           const Colour& halo) const {
  const double length_m = round_down(0.3 * width_px_ / pixels_per_metre_);
  const double length_px = length_m * pixels_per_metre_;
  const Point from{corner_.x + text_px, corner_.y + height_px_ - text_px};
  const Point to{from.x + length_px, from.y};
  canvas.line({from, to}, 0.45 * text_px, halo);
  canvas.line({from, to}, 0.2 * text_px, ink);
  canvas.text_with_halo({0.5 * (from.x + to.x), from.y - 0.5 * text_px}, readable_length(length_m),
                        text_px, ink, halo, 0.5);
}

double PlanePanel::dot_px(std::size_t points) const {
  return std::clamp(240.0 / std::sqrt(static_cast<double>(points) + 1.0), 1.2, 5.0);
}

}  // namespace loopstone
