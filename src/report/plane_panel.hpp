#pragma once

#include <Eigen/Core>
#include <string>

#include "loopstone/formats/ros_map.hpp"
#include "loopstone/geometry/pose2.hpp"
#include "report/canvas.hpp"

namespace loopstone {

/// The part of a plane that is shown [m].
struct ViewBox {
  Eigen::Vector2d low = Eigen::Vector2d::Zero();
  Eigen::Vector2d high = Eigen::Vector2d::Zero();
};

/// "5 mm", "20 cm", "1 m".
[[nodiscard]] std::string readable_length(double length_m);

/// A rectangle of a canvas that shows a box of the plane: the one place where its metres become
/// pixels.
class PlanePanel {
 public:
  /// The box is centred in the rectangle; what the rectangle shows beyond the box, it shows too.
  PlanePanel(Point corner, double width_px, double height_px, const ViewBox& box,
             double pixels_per_metre);

  /// A square of this side; nothing when it lies outside.
  void dot(Canvas& canvas, const Eigen::Vector2d& point, double side_px,
           const Colour& colour) const;
  /// Free white, occupied near black, unknown grey.
  void draw_map(Canvas& canvas, const CellStates& map) const { paste(canvas, shade(map)); }
  /// The map as it lies in this rectangle, for panels that are drawn again and again.
  [[nodiscard]] Image shade(const CellStates& map) const;
  void paste(Canvas& canvas, const Image& shaded) const;
  /// An arrowhead along the pose's heading.
  void robot(Canvas& canvas, const Pose2& pose, const Colour& colour) const;
  /// Standard deviations of the position, as the ellipse that is so many times as large.
  void ellipse(Canvas& canvas, const Eigen::Vector2d& centre, const Eigen::Matrix2d& covariance,
               double times, double width_px, const Colour& colour) const;
  void frame(Canvas& canvas, const Colour& colour) const;
  /// In the lower left corner.
  void scale_bar(Canvas& canvas, double text_px, const Colour& ink, const Colour& halo) const;
  /// Suits so many points.
  [[nodiscard]] double dot_px(std::size_t points) const;
  [[nodiscard]] Point pixel_of(const Eigen::Vector2d& point) const;
  [[nodiscard]] bool shows(Point pixel) const;

 private:
  Point corner_;
  double width_px_;
  double height_px_;
  Eigen::Vector2d centre_;
  double pixels_per_metre_;
};

}  // namespace loopstone
