#include "loopstone/report/match_picture.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <vector>

#include "loopstone/base/error.hpp"
#include "loopstone/registration/point_index.hpp"
#include "report/canvas.hpp"
#include "report/picture_parts.hpp"
#include "report/plane_panel.hpp"
#include "report/round_length.hpp"
#include "report/text.hpp"

namespace loopstone {
namespace {

const Colour kTarget = hex_colour(0x8b95a5);
const Colour kGuess = hex_colour(0x2563eb);
/// Many points tell no more than these, and take long to draw.
constexpr std::size_t kMostPoints = 60'000;

/// Which coordinates of a point run to the right and up, and what the view is called.
struct Projection {
  int right;
  int up;
  const char* name;
};

template <int kDimension>
std::vector<Projection> projections() {
  if constexpr (kDimension == 2) {
    return {{0, 1, ""}};
  } else {
    return {{0, 1, "from above"}, {0, 2, "from the side"}, {1, 2, "from the front"}};
  }
}

const char* axis_name(int axis) { return axis == 0 ? "x" : axis == 1 ? "y" : "z"; }

/// Green on the surface, over amber to red far from it.
Colour residual_colour(double share) {
  static const Colour kStops[] = {hex_colour(0x059669), hex_colour(0x84cc16), hex_colour(0xf59e0b),
                                  hex_colour(0xdc2626)};
  const double position = std::clamp(share, 0.0, 1.0) * 3.0;
  const auto i = std::min<std::size_t>(static_cast<std::size_t>(position), 2);
  const double t = position - static_cast<double>(i);
  const auto mix = [t](double a, double b) { return a + t * (b - a); };
  return {mix(kStops[i].red, kStops[i + 1].red), mix(kStops[i].green, kStops[i + 1].green),
          mix(kStops[i].blue, kStops[i + 1].blue), 1.0};
}

template <int kDimension>
struct Prepared {
  using Point = Eigen::Matrix<double, kDimension, 1>;

  std::vector<Point> target{};
  std::vector<Point> before{};
  std::vector<Point> after{};
  std::vector<double>
      residuals_m{};  ///< of `after`; infinite when there is nothing to compare with
  double far_m = 1.0;
};

template <typename Point>
std::vector<Point> finite_points(std::span<const Point> points) {
  std::vector<Point> kept;
  const std::size_t step = std::max<std::size_t>(1, points.size() / kMostPoints);
  for (std::size_t i = 0; i < points.size(); i += step) {
    if (points[i].allFinite()) kept.push_back(points[i]);
  }
  return kept;
}

template <int kDimension>
Prepared<kDimension> prepare(const MatchScene<kDimension>& scene, double far_m) {
  using Point = Eigen::Matrix<double, kDimension, 1>;
  Prepared<kDimension> prepared;
  prepared.target = finite_points<Point>(scene.target);
  const std::vector<Point> source = finite_points<Point>(scene.source);
  if (source.empty()) throw UsageError("a picture of a match needs points");
  // Distances are those to all target points, not only to those that are drawn.
  const PointIndex<kDimension> index(std::vector<Point>(scene.target.begin(), scene.target.end()));
  for (const Point& point : source) {
    prepared.before.push_back(scene.guess_target_T_source * point);
    prepared.after.push_back(scene.target_T_source * point);
    const auto nearest = index.nearest(prepared.after.back(), HUGE_VAL);
    prepared.residuals_m.push_back(nearest ? nearest->distance_m : HUGE_VAL);
  }
  prepared.far_m = far_m;
  if (far_m <= 0.0) {
    std::vector<double> sorted = prepared.residuals_m;
    const auto at = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
    std::nth_element(sorted.begin(), at, sorted.end());
    prepared.far_m = std::isfinite(*at) ? round_up(std::max(6.0 * *at, 1e-6)) : 1.0;
  }
  return prepared;
}

/// The box that holds nearly everything; a few strays do not blow up the picture.
template <int kDimension>
ViewBox box_of(const Prepared<kDimension>& prepared, const Projection& view, bool with_target) {
  std::array<std::vector<double>, 2> coordinates;
  const auto add = [&](const auto& points) {
    for (const auto& point : points) {
      coordinates[0].push_back(point(view.right));
      coordinates[1].push_back(point(view.up));
    }
  };
  add(prepared.before);
  add(prepared.after);
  if (with_target) add(prepared.target);
  ViewBox box;
  for (std::size_t axis = 0; axis < 2; ++axis) {
    std::vector<double>& values = coordinates[axis];
    std::sort(values.begin(), values.end());
    const std::size_t cut = values.size() / 400;
    box.low(static_cast<Eigen::Index>(axis)) = values[cut];
    box.high(static_cast<Eigen::Index>(axis)) = values[values.size() - 1 - cut];
  }
  const double size = std::max((box.high - box.low).maxCoeff(), 1e-6);
  const Eigen::Vector2d margin = Eigen::Vector2d::Constant(0.06 * size);
  // Nothing gets thinner than a quarter of the longer side.
  const Eigen::Vector2d middle = 0.5 * (box.low + box.high);
  const Eigen::Vector2d half = (0.5 * (box.high - box.low)).cwiseMax(0.125 * size);
  return {middle - half - margin, middle + half + margin};
}

template <int kDimension>
void draw_panel(Canvas& canvas, const PlanePanel& panel, const Prepared<kDimension>& prepared,
                const MatchScene<kDimension>& scene, const Projection& view, bool after) {
  if constexpr (kDimension == 2) {
    if (scene.map != nullptr) panel.draw_map(canvas, *scene.map);
  }
  const double dot = panel.dot_px(prepared.after.size());
  const auto flat = [&](const auto& point) {
    return Eigen::Vector2d(point(view.right), point(view.up));
  };
  if (scene.map == nullptr) {
    for (const auto& point : prepared.target) panel.dot(canvas, flat(point), dot, kTarget);
  }
  const auto& points = after ? prepared.after : prepared.before;
  for (std::size_t i = 0; i < points.size(); ++i) {
    panel.dot(canvas, flat(points[i]), dot,
              after ? residual_colour(prepared.residuals_m[i] / prepared.far_m) : kGuess);
  }
  if constexpr (kDimension == 2) {
    if (scene.shows_robot) {
      panel.robot(canvas, after ? scene.target_T_source : scene.guess_target_T_source,
                  after ? kInk : kGuess);
    }
  }
  panel.frame(canvas, kHairline);
}

/// What the colours mean, from left to right along the bottom.
class Legend {
 public:
  Legend(Canvas& canvas, double x, double y, double text_px)
      : canvas_(canvas), x_(x), y_(y), text_px_(text_px) {}

  void entry(const std::string& words, const Colour& colour) {
    canvas_.disc({x_ + 0.4 * text_px_, y_ - 0.33 * text_px_}, 0.33 * text_px_, colour, 0.0, colour);
    x_ += 1.1 * text_px_;
    write(words);
  }
  void ramp(double far_m) {
    constexpr int kSteps = 48;
    const double length = 7.0 * text_px_;
    write("source after: 0", 0.5);
    for (int i = 0; i < kSteps; ++i) {
      canvas_.fill_rectangle({x_ + length * i / kSteps, y_ - 0.6 * text_px_}, length / kSteps + 0.6,
                             0.55 * text_px_, residual_colour((i + 0.5) / kSteps));
    }
    x_ += length + 0.5 * text_px_;
    write(readable_length(far_m) + " and more from the target");
  }

 private:
  void write(const std::string& words, double space = 1.6) {
    canvas_.text({x_, y_}, words, text_px_, kInk);
    x_ += text_width(words, text_px_) + space * text_px_;
  }

  Canvas& canvas_;
  double x_;
  double y_;
  double text_px_;
};

}  // namespace

template <int kDimension>
Image draw_match_picture(const MatchScene<kDimension>& scene, const MatchPictureOptions& options) {
  const Prepared<kDimension> prepared = prepare(scene, options.far_m);
  const std::vector<Projection> views = projections<kDimension>();
  // A map goes on far beyond what the scan saw.
  const bool with_target = scene.map == nullptr;
  std::vector<ViewBox> boxes;
  Eigen::Vector2d largest = Eigen::Vector2d::Zero();
  for (const Projection& view : views) {
    boxes.push_back(box_of(prepared, view, with_target));
    largest = largest.cwiseMax(boxes.back().high - boxes.back().low);
  }
  const double panel_px = kDimension == 2 ? options.panel_px : 0.72 * options.panel_px;
  const double scale = panel_px / largest.maxCoeff();  // pixels a metre, the same everywhere
  const double text = std::clamp(options.panel_px / 50.0, 12.0, 28.0);
  const double gap = 1.2 * text;
  const double width = std::max(largest.x() * scale, 22.0 * text);

  double height = 3.2 * text;
  for (const ViewBox& box : boxes) height += (box.high.y() - box.low.y()) * scale + gap;
  const double footer_top = height;
  height += 4.2 * text;
  Canvas canvas(static_cast<int>(std::ceil(2.0 * width + 3.0 * gap)),
                static_cast<int>(std::ceil(height)), kPaper);
  const auto left_of = [&](bool after) { return gap + (after ? width + gap : 0.0); };
  canvas.text({left_of(false), 2.0 * text}, scene.before, 1.15 * text, kInk, 0.0,
              FontWeight::kBold);
  canvas.text({left_of(true), 2.0 * text}, scene.after, 1.15 * text, kInk, 0.0, FontWeight::kBold);

  double top = 3.2 * text;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const double panel_height = (boxes[i].high.y() - boxes[i].low.y()) * scale;
    for (const bool after : {false, true}) {
      const PlanePanel panel({left_of(after), top}, width, panel_height, boxes[i], scale);
      draw_panel(canvas, panel, prepared, scene, views[i], after);
      const std::string axes = fmt::format("{}{}{} to the right, {} up", views[i].name,
                                           *views[i].name != '\0' ? ": " : "",
                                           axis_name(views[i].right), axis_name(views[i].up));
      canvas.text_with_halo({left_of(after) + 0.6 * text, top + 1.3 * text}, axes, 0.85 * text,
                            kInk, kPaper);
      if (after == false) panel.scale_bar(canvas, text, kInk, kPaper);
    }
    top += panel_height + gap;
  }
  Legend legend(canvas, gap, footer_top + 1.4 * text, text);
  legend.entry(scene.map != nullptr ? "map: walls" : "target",
               scene.map != nullptr ? kInk : kTarget);
  legend.entry("source before", kGuess);
  Legend(canvas, gap, footer_top + 3.2 * text, text).ramp(prepared.far_m);
  return canvas.image();
}

template Image draw_match_picture<2>(const MatchScene<2>&, const MatchPictureOptions&);
template Image draw_match_picture<3>(const MatchScene<3>&, const MatchPictureOptions&);

}  // namespace loopstone
