#include "report/svg_plot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <iterator>
#include <limits>

#include "report/text.hpp"

namespace loopstone {
namespace {

constexpr double kLeft = 62.0;
constexpr double kRight = 14.0;
constexpr double kTop = 14.0;
constexpr double kBottom = 40.0;
constexpr double kLegend = 20.0;

struct Span {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();

  void include(double value) {
    if (!std::isfinite(value)) return;
    low = std::min(low, value);
    high = std::max(high, value);
  }
  [[nodiscard]] bool empty() const { return !(low <= high); }
  [[nodiscard]] double size() const { return high - low; }
  void widen(double share) {
    const double by = size() > 0.0 ? share * size() : std::max(0.5, 0.1 * std::abs(low));
    low -= by;
    high += by;
  }
  void grow_to(double wanted) {
    const double by = std::max(0.0, 0.5 * (wanted - size()));
    low -= by;
    high += by;
  }
};

class Plot {
 public:
  explicit Plot(PlotSpec spec) : spec_(std::move(spec)) {
    for (const PlotCurve& curve : spec_.curves) {
      for (std::size_t i = 0; i < curve.x.size(); ++i) {
        if (!std::isfinite(curve.x[i]) || !std::isfinite(curve.y[i])) continue;
        ++points_;
        x_.include(curve.x[i]);
        y_.include(curve.y[i]);
      }
    }
    if (points_ == 0) return;
    for (const double y : spec_.y_shown) y_.include(y);
  }

  [[nodiscard]] bool empty() const { return points_ < 2 || x_.empty() || y_.empty(); }

  [[nodiscard]] std::string draw() {
    top_ = kTop + (spec_.curves.size() > 1 ? kLegend : 0.0);
    fit_axes();
    out_ = fmt::format(
        "<svg class=\"plot\" viewBox=\"0 0 {:.0f} {:.0f}\" role=\"img\" aria-label=\"{} over "
        "{}\">\n",
        spec_.width_px, spec_.height_px, escape_html(spec_.y_label), escape_html(spec_.x_label));
    draw_bands();
    draw_axes();
    for (const PlotCurve& curve : spec_.curves) draw_curve(curve);
    draw_legend();
    return out_ + "</svg>\n";
  }

 private:
  void fit_axes() {
    const double inner_width = spec_.width_px - kLeft - kRight;
    if (!spec_.equal_axes) {
      if (!(x_.size() > 0.0)) x_.widen(0.0);
      y_.widen(0.06);
      return;
    }
    x_.widen(0.03);
    y_.widen(0.03);
    // Between a letterbox and a square; the axis with room to spare grows.
    const double inner_height =
        std::clamp(inner_width * y_.size() / x_.size(), 0.25 * inner_width, 0.8 * inner_width);
    const double metres_per_px = std::max(x_.size() / inner_width, y_.size() / inner_height);
    x_.grow_to(metres_per_px * inner_width);
    y_.grow_to(metres_per_px * inner_height);
    spec_.height_px = inner_height + top_ + kBottom;
  }

  [[nodiscard]] double px(double x) const {
    return kLeft + (x - x_.low) / x_.size() * (spec_.width_px - kLeft - kRight);
  }
  [[nodiscard]] double py(double y) const {
    return spec_.height_px - kBottom -
           (y - y_.low) / y_.size() * (spec_.height_px - kBottom - top_);
  }

  void draw_bands() {
    for (const PlotBand& band : spec_.bands) {
      const double left = px(std::max(band.x_low, x_.low));
      const double width = std::max(0.8, px(std::min(band.x_high, x_.high)) - left);
      fmt::format_to(std::back_inserter(out_),
                     "<rect class=\"band {0}\" x=\"{1:.1f}\" y=\"{2:.1f}\" width=\"{3:.1f}\" "
                     "height=\"{4:.1f}\"/><rect class=\"strip {0}\" x=\"{1:.1f}\" y=\"{5:.1f}\" "
                     "width=\"{3:.1f}\" height=\"5\"/>\n",
                     band.css_class, left, top_, width, spec_.height_px - kBottom - top_,
                     top_ - 8.0);
    }
  }

  void draw_axes() {
    const auto out = std::back_inserter(out_);
    const double bottom = spec_.height_px - kBottom;
    const double right = spec_.width_px - kRight;
    for (const double x : round_ticks(x_.low, x_.high, 8)) {
      fmt::format_to(
          out,
          "<path class=\"grid\" d=\"M{0:.1f} {1:.1f}V{2:.1f}\"/><text x=\"{0:.1f}\" y=\"{3:.1f}\" "
          "text-anchor=\"middle\">{4:g}</text>\n",
          px(x), bottom, top_, bottom + 15.0, x);
    }
    for (const double y :
         round_ticks(y_.low, y_.high, std::max(3, static_cast<int>((bottom - top_) / 45.0)))) {
      fmt::format_to(
          out,
          "<path class=\"grid\" d=\"M{0:.1f} {1:.1f}H{2:.1f}\"/><text x=\"{3:.1f}\" y=\"{4:.1f}\" "
          "text-anchor=\"end\">{5:g}</text>\n",
          kLeft, py(y), right, kLeft - 6.0, py(y) + 4.0, y);
    }
    fmt::format_to(out, "<path class=\"axis\" d=\"M{:.1f} {:.1f}V{:.1f}H{:.1f}\"/>\n", kLeft, top_,
                   bottom, right);
    fmt::format_to(out, "<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"middle\">{}</text>\n",
                   0.5 * (kLeft + right), spec_.height_px - 6.0, escape_html(spec_.x_label));
    fmt::format_to(
        out,
        "<text transform=\"translate(14 {:.1f}) rotate(-90)\" text-anchor=\"middle\">{}</text>\n",
        0.5 * (top_ + bottom), escape_html(spec_.y_label));
  }

  void draw_curve(const PlotCurve& curve) {
    std::string path;
    const auto out = std::back_inserter(path);
    bool pen_down = false;
    double last_x = 0.0;
    double last_y = 0.0;
    for (std::size_t i = 0; i < curve.x.size(); ++i) {
      if (!std::isfinite(curve.x[i]) || !std::isfinite(curve.y[i])) {
        pen_down = false;
        continue;
      }
      const double x = px(curve.x[i]);
      const double y = py(curve.y[i]);
      if (pen_down && std::abs(x - last_x) < 0.4 && std::abs(y - last_y) < 0.4) continue;
      fmt::format_to(out, "{}{:.1f} {:.1f}", pen_down ? "L" : "M", x, y);
      pen_down = true;
      last_x = x;
      last_y = y;
    }
    fmt::format_to(std::back_inserter(out_), "<path class=\"curve {}\" d=\"{}\"/>\n",
                   curve.css_class, path);
  }

  void draw_legend() {
    if (spec_.curves.size() < 2) return;
    double x = kLeft;
    for (const PlotCurve& curve : spec_.curves) {
      fmt::format_to(std::back_inserter(out_),
                     "<path class=\"curve {}\" d=\"M{:.1f} 14H{:.1f}\"/><text x=\"{:.1f}\" "
                     "y=\"18\">{}</text>\n",
                     curve.css_class, x, x + 22.0, x + 28.0, escape_html(curve.label));
      x += 52.0 + 6.6 * static_cast<double>(curve.label.size());
    }
  }

  PlotSpec spec_;
  Span x_{};
  Span y_{};
  std::size_t points_ = 0;
  double top_ = kTop;
  std::string out_{};
};

}  // namespace

std::vector<double> round_ticks(double low, double high, int count) {
  std::vector<double> ticks;
  const double rough = (high - low) / std::max(1, count);
  if (!(rough > 0.0) || !std::isfinite(rough)) return ticks;
  const double power = std::pow(10.0, std::floor(std::log10(rough)));
  double step = 10.0 * power;
  for (const double factor : {5.0, 2.0, 1.0}) {
    if (factor * power >= rough * 0.999) step = factor * power;
  }
  const double first = std::ceil(low / step - 1e-9);
  for (double k = first; k * step <= high + 1e-9 * step; k += 1.0)
    ticks.push_back(k == 0.0 ? 0.0 : k * step);
  return ticks;
}

std::string svg_plot(PlotSpec spec) {
  Plot plot(std::move(spec));
  return plot.empty() ? std::string() : plot.draw();
}

}  // namespace loopstone
