#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "loopstone/grid/grid_frame.hpp"
#include "loopstone/mapping/occupancy.hpp"
#include "report/canvas.hpp"
#include "report/map_view.hpp"
#include "report/picture_parts.hpp"

namespace loopstone {

/// The pale map that several pictures share.
struct SiteGround {
  explicit SiteGround(const OccupancyMap& map);

  MapView view;
  Image image;
};

/// A map with things on it, and below it what they mean.
class SiteSheet {
 public:
  explicit SiteSheet(SiteGround ground);
  explicit SiteSheet(const OccupancyMap& map) : SiteSheet(SiteGround(map)) {}

  [[nodiscard]] const MapView& view() const { return view_; }
  [[nodiscard]] const PictureSizes& sizes() const { return sizes_; }

  /// What a colour means.
  void add_swatch(const Colour& colour, const std::string& words);
  /// What stripes on a colour mean.
  void add_hatched(const Colour& ground, const Colour& stripes, const std::string& words);
  /// What colours between two ends mean, from a share of 0 to 1.
  void add_ramp(const std::string& from, const std::function<Colour(double)>& colour_at,
                const std::string& to);

  /// Lays colours over cells; nothing: the cell stays as it is. Where several cells share a pixel,
  /// one that has a colour shows.
  void tint(const std::function<std::optional<Colour>(Cell)>& colour_of);

  /// The picture, with what is drawn on top of the map. 8-bit RGB.
  [[nodiscard]] Image draw(const std::function<void(Canvas&)>& on_top = {}) const;

 private:
  [[nodiscard]] std::optional<Colour> colour_at(
      int x, int y, const std::function<std::optional<Colour>(Cell)>& colour_of) const;

  MapView view_;
  PictureSizes sizes_;
  int width_;
  Footer footer_;
  Image map_;
};

/// A colour between those of a ramp, which are evenly spaced; a share below 0 or above 1 is that of
/// its end.
[[nodiscard]] Colour ramp_colour(const std::vector<Colour>& ramp, double share);

}  // namespace loopstone
