#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include "loopstone/geometry/pose2.hpp"
#include "loopstone/sensor/rgbd_images.hpp"
#include "loopstone/simulation/floor_plan.hpp"

namespace loopstone {

/// Red, green, blue in linear light; 1 is white.
using LinearColour = Eigen::Vector3f;

/// A letter painted on the floor. Its frame: origin at the lower left corner, x along the line of
/// text.
struct FloorLetter {
  char letter = ' ';
  Pose2 map_T_letter{};
  double height_m = 0.0;
};

/// The part of the floor that one pixel sees, as the covariance of where its light comes from
/// [m^2].
struct FloorFootprint {
  float xx = 0.0F;
  float xy = 0.0F;
  float yy = 0.0F;
};

/// The true colour of the floor: a patch of square texels that repeats in x and y, as halved and
/// halved again copies for averages over larger areas (Williams 1983, "Pyramidal parametrics").
/// Immutable, so it may be shared between threads.
class FloorPattern {
 public:
  /// \param columns, rows  texels of the patch, powers of two
  /// \param texels         row by row from y = 0 up, x from 0 up; 0 to 1 in each channel
  /// \param texel_m        size of a texel in x and y
  FloorPattern(int columns, int rows, const Eigen::Vector2d& texel_m,
               const std::vector<LinearColour>& texels, std::vector<FloorLetter> letters = {});

  /// The mean over an upright rectangle that is at least a texel wide; exact.
  [[nodiscard]] LinearColour mean_over(const Extent& rectangle) const;
  /// The mean over a square cell of any heading, by sampling it at every half texel.
  [[nodiscard]] LinearColour mean_over(const Pose2& map_T_centre, double side_m) const;
  /// What a pixel sees around a point: about the Gaussian mean over its footprint, from several
  /// samples along the footprint's longer axis (McCormack et al. 1999, "Feline"). From 1 to 12
  /// samples, about 10 ns each.
  [[nodiscard]] LinearColour seen_over(const Eigen::Vector2d& point,
                                       const FloorFootprint& footprint) const;
  /// The mean over the whole patch.
  [[nodiscard]] LinearColour mean() const;

  /// Size of the patch [m].
  [[nodiscard]] Eigen::Vector2d period_m() const;
  /// The letters that lie wholly within a rectangle, in order of the rows of text.
  [[nodiscard]] std::vector<FloorLetter> letters_in(const Extent& rectangle) const;

 private:
  using Texel = Eigen::Vector4f;  ///< the fourth is not used: four numbers are as fast as one
  struct Level {
    int columns = 0;
    int rows = 0;
    std::vector<Texel> texels{};
  };
  [[nodiscard]] static Texel bilinear(const Level& level, float u, float v);
  [[nodiscard]] Eigen::Vector2f to_texels(const Eigen::Vector2d& point) const;

  Eigen::Vector2d texel_m_;
  std::vector<Level> levels_{};
  std::vector<FloorLetter> letters_{};  ///< of one patch
};

/// The names that make_floor knows.
[[nodiscard]] const std::vector<std::string_view>& floor_names();

/// A built-in pattern of 4.096 m by 4.096 m in texels of 2 mm.
///   tiles   of 256 mm with joints, some of them dark
///   carpet  flecked, with a diamond weave
///   wood    planks of 128 mm by 1 m with grain
///   text    sentences on linoleum: letters mostly 50 mm high, some lines from 25 to 120 mm
///   mixed   a quarter of each, the text also painted on tiles
/// Throws UsageError for another name.
[[nodiscard]] FloorPattern make_floor(std::string_view name, std::uint64_t seed);

/// A picture that repeats; its lower left corner lies at the origin of the map. Throws UsageError
/// for an empty picture.
[[nodiscard]] FloorPattern make_floor(const ColourImage& picture, double width_m);

}  // namespace loopstone
