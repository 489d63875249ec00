#pragma once

#include <functional>
#include <string>
#include <vector>

#include "loopstone/geometry/pose2.hpp"
#include "report/canvas.hpp"
#include "report/map_view.hpp"

// What the pictures of a whole map have in common: sizes, marks, the strip with scale bar and
// legend below.

namespace loopstone {

inline const Colour kInk = hex_colour(0x1f2937);
inline const Colour kPaper = hex_colour(0xffffff);
inline const Colour kHairline = hex_colour(0xb6bdc8);

/// Lengths in pixels that suit the size of the picture.
struct PictureSizes {
  explicit PictureSizes(int side_px);
  double text;
  double path;
  double marker;
  double padding;
};

/// An arrowhead along the heading where the path begins, a square where it ends, and their names.
void draw_start_and_end(const Pose2& first, const Pose2& last, const MapView& view,
                        const PictureSizes& sizes, Canvas& canvas);

/// The strip below a map: items from left to right, in as many rows as they need.
class Footer {
 public:
  Footer(const PictureSizes& sizes, double width);

  void add_scale_bar(double pixels_per_metre);
  void add_axes();
  /// What a colour means.
  void add_swatch(const Colour& colour, const std::string& words);
  /// Words, a symbol, words; both words may be empty. `draw` gets the left end of the symbol, at
  /// half its height.
  void add(const std::string& before, double symbol_width, const std::string& after,
           std::function<void(Canvas&, Point)> draw);

  [[nodiscard]] double height() const;
  void draw(Canvas& canvas, double top) const;

 private:
  struct Item {
    double left;
    int row;
    std::function<void(Canvas&, Point)> draw;
  };
  /// The next free place of this width.
  void place(double width, std::function<void(Canvas&, Point)> draw);

  PictureSizes sizes_;
  double width_;
  double x_;
  int row_ = 0;
  std::vector<Item> items_{};
};

}  // namespace loopstone
