#include "formats/camera_lens.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "loopstone/base/hypotenuse.hpp"

namespace loopstone {
namespace {

using Coefficients = std::vector<double>;

/// A lens that is missed by more than this puts floor at wrong places.
constexpr double kMostMissPx = 3.0;

double coefficient(const Coefficients& d, std::size_t i) { return i < d.size() ? d[i] : 0.0; }

/// How far from the axis a ray is seen that would cross z = 1 at a radius. Source: OpenCV's
/// calib3d, the models of CALIB_RATIONAL_MODEL and of the namespace fisheye.
double rational_radius(const Coefficients& d, double r) {
  const double r2 = r * r;
  const double above =
      1.0 + r2 * (coefficient(d, 0) + r2 * (coefficient(d, 1) + r2 * coefficient(d, 4)));
  const double below =
      1.0 + r2 * (coefficient(d, 5) + r2 * (coefficient(d, 6) + r2 * coefficient(d, 7)));
  return r * above / below;
}

double fisheye_radius(const Coefficients& d, double r) {
  const double angle = std::atan(r);
  const double a2 = angle * angle;
  return angle * (1.0 + a2 * (coefficient(d, 0) +
                              a2 * (coefficient(d, 1) +
                                    a2 * (coefficient(d, 2) + a2 * coefficient(d, 3)))));
}

/// The greatest radius at which a corner of the picture is seen.
double corner_radius(const LensModel& lens) {
  const double x = std::max(lens.centre_x_px, lens.width_px - lens.centre_x_px);
  const double y = std::max(lens.centre_y_px, lens.height_px - lens.centre_y_px);
  return hypotenuse(x / lens.focal_x_px, y / lens.focal_y_px);
}

/// Fits k1, k2, k3 to seen(r) for r up to where the corner is seen, and says how well.
template <typename Seen>
double fit_radial(const Seen& seen, LensModel& lens) {
  constexpr int kSteps = 200;
  constexpr double kFarthest = 4.0;  // 76 deg off the axis
  const double corner = corner_radius(lens);
  std::vector<double> radii;
  for (int i = 1; i <= kSteps; ++i) {
    const double r = kFarthest * i / kSteps;
    if (!radii.empty() && (seen(r) > corner || seen(r) <= seen(radii.back()))) break;
    radii.push_back(r);
  }
  // Equal steps as far as the picture reaches.
  const double reach = radii.back();
  for (std::size_t i = 0; i < radii.size(); ++i) {
    radii[i] = reach * static_cast<double>(i + 1) / static_cast<double>(radii.size());
  }
  const auto count = static_cast<Eigen::Index>(radii.size());
  Eigen::MatrixX3d powers(count, 3);
  Eigen::VectorXd excess(count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const double r = radii[static_cast<std::size_t>(i)];
    powers.row(i) << std::pow(r, 3), std::pow(r, 5), std::pow(r, 7);
    excess[i] = seen(r) - r;
  }
  const Eigen::Vector3d k = powers.colPivHouseholderQr().solve(excess);
  lens.k1 = k[0];
  lens.k2 = k[1];
  lens.k3 = k[2];
  return (powers * k - excess).cwiseAbs().maxCoeff() * std::max(lens.focal_x_px, lens.focal_y_px);
}

void set_matrix(double fx, double fy, double cx, double cy, LensModel& lens) {
  lens.focal_x_px = fx;
  lens.focal_y_px = fy;
  lens.centre_x_px = cx;
  lens.centre_y_px = cy;
}

/// The part of the sensor that pictures show, and how many of its pixels make one.
void cut_out(const msg::CameraInfo& info, LensModel& lens) {
  const msg::RegionOfInterest& roi = info.roi;
  if (roi.width > 0 && roi.height > 0) {
    lens.centre_x_px -= roi.x_offset;
    lens.centre_y_px -= roi.y_offset;
    lens.width_px = static_cast<int>(roi.width);
    lens.height_px = static_cast<int>(roi.height);
  }
  if (info.binning_x > 1 || info.binning_y > 1) {
    lens = scaled(lens, lens.width_px / static_cast<int>(std::max(1U, info.binning_x)),
                  lens.height_px / static_cast<int>(std::max(1U, info.binning_y)));
  }
}

}  // namespace

LensModel scaled(const LensModel& lens, int width_px, int height_px) {
  LensModel other = lens;
  const double x = static_cast<double>(width_px) / lens.width_px;
  const double y = static_cast<double>(height_px) / lens.height_px;
  // The centre of the first pixel is (0, 0), its corner (-0.5, -0.5).
  other.focal_x_px *= x;
  other.focal_y_px *= y;
  other.centre_x_px = (lens.centre_x_px + 0.5) * x - 0.5;
  other.centre_y_px = (lens.centre_y_px + 0.5) * y - 0.5;
  other.width_px = width_px;
  other.height_px = height_px;
  return other;
}

ToldLens lens_of(const msg::CameraInfo& info, bool is_rectified) {
  ToldLens told;
  LensModel& lens = told.lens;
  constexpr std::uint32_t kMostSide = 1U << 16U;
  if (info.width == 0 || info.height == 0 || info.width > kMostSide || info.height > kMostSide) {
    told.fault = "its CameraInfo tells no size";
    return told;
  }
  lens.width_px = static_cast<int>(info.width);
  lens.height_px = static_cast<int>(info.height);
  const bool by_p = is_rectified && info.p[0] > 0.0;
  if (by_p) {
    set_matrix(info.p[0], info.p[5], info.p[2], info.p[6], lens);
  } else {
    set_matrix(info.k[0], info.k[4], info.k[2], info.k[5], lens);
  }
  const bool is_finite = std::isfinite(lens.centre_x_px) && std::isfinite(lens.centre_y_px) &&
                         std::ranges::all_of(info.d, [](double d) { return std::isfinite(d); });
  if (!(lens.focal_x_px > 1.0) || !(lens.focal_y_px > 1.0) || !(lens.focal_x_px < 1e6) ||
      !(lens.focal_y_px < 1e6) || !is_finite) {
    told.fault = "its CameraInfo is of a camera that was not calibrated";
    return told;
  }
  const bool is_bent = std::ranges::any_of(info.d, [](double d) { return d != 0.0; });
  const std::string& model = info.distortion_model;
  if (!by_p && is_bent) {
    if (model == "equidistant" || model == "fisheye") {
      told.worst_px = fit_radial([&](double r) { return fisheye_radius(info.d, r); }, lens);
    } else if (model == "rational_polynomial" || info.d.size() > 5) {
      told.worst_px = fit_radial([&](double r) { return rational_radius(info.d, r); }, lens);
      lens.p1 = coefficient(info.d, 2);
      lens.p2 = coefficient(info.d, 3);
    } else {
      lens.k1 = coefficient(info.d, 0);
      lens.k2 = coefficient(info.d, 1);
      lens.p1 = coefficient(info.d, 2);
      lens.p2 = coefficient(info.d, 3);
      lens.k3 = coefficient(info.d, 4);
    }
  }
  if (!(told.worst_px < kMostMissPx)) {
    told.fault = "its CameraInfo tells of a lens that can't be understood";
    return told;
  }
  cut_out(info, lens);
  return told;
}

}  // namespace loopstone
