#pragma once

#include <string>
#include <vector>

namespace loopstone {

/// A curve of a plot. NaN in y breaks the line.
struct PlotCurve {
  std::string label;
  std::string
      css_class;  ///< "a", "b", ...: the page's style sheet gives it its colour, light or dark
  std::vector<double> x{};
  std::vector<double> y{};
};

/// A stretch of the x axis that is shaded: a tint behind the curves and a strip above them.
struct PlotBand {
  std::string css_class;
  double x_low = 0.0;
  double x_high = 0.0;
};

struct PlotSpec {
  std::string x_label;
  std::string y_label;
  std::vector<PlotCurve> curves{};
  std::vector<PlotBand> bands{};
  std::vector<double> y_shown{};  ///< values that the y axis reaches whatever the curves do
  double width_px = 860.0;
  double height_px = 220.0;
  bool equal_axes = false;  ///< a metre is as long in x as in y; the height follows from the data
};

/// An <svg> element without scripts or references, styled by classes, with axes, grid, and a legend
/// when there are several curves. Empty text when no curve has two points.
[[nodiscard]] std::string svg_plot(PlotSpec spec);

/// Round values from low to high, about `count` of them.
[[nodiscard]] std::vector<double> round_ticks(double low, double high, int count);

}  // namespace loopstone
