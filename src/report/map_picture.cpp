#include "loopstone/report/map_picture.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "report/canvas.hpp"
#include "report/map_view.hpp"
#include "report/round_length.hpp"
#include "report/text.hpp"

namespace loopstone {
namespace {

const Colour kInk = hex_colour(0x1f2937);
const Colour kPaper = hex_colour(0xffffff);
const Colour kClosure = hex_colour(0x059669);
const Colour kStart = hex_colour(0x16a34a);
const Colour kEnd = hex_colour(0xdc2626);

/// Lengths in pixels that suit the size of the picture.
struct Sizes {
  explicit Sizes(int side_px)
      : text(std::clamp(side_px / 70.0, 13.0, 34.0)),
        path(text / 9.0),
        marker(text * 0.5),
        padding(text * 1.1) {}
  double text;
  double path;
  double marker;
  double padding;
};

void draw_path(const Trajectory& trajectory, const MapView& view, const Sizes& sizes,
               Canvas& canvas) {
  if (trajectory.size() < 2) return;
  const double duration_s = (trajectory.back().stamp - trajectory.front().stamp).seconds();
  constexpr int kColours = 96;
  std::vector<Point> run;
  int run_colour = 0;
  const auto finish_run = [&] {
    canvas.line(run, sizes.path, time_colour((run_colour + 0.5) / kColours));
    if (!run.empty()) run = {run.back()};
  };
  for (const StampedPose2& stamped : trajectory.poses()) {
    const double share =
        duration_s > 0.0 ? (stamped.stamp - trajectory.front().stamp).seconds() / duration_s : 0.0;
    const int colour = std::min(static_cast<int>(share * kColours), kColours - 1);
    if (colour != run_colour) {
      finish_run();
      run_colour = colour;
    }
    const Point point = view.pixel_of(stamped.pose.translation());
    if (run.empty() || std::hypot(point.x - run.back().x, point.y - run.back().y) > 0.7)
      run.push_back(point);
  }
  finish_run();
}

void draw_loop_closures(const MapResult& result, const MapView& view, const Sizes& sizes,
                        Canvas& canvas) {
  const auto& poses = result.graph.poses;
  const auto exists = [&](NodeId node) {
    return node.index >= 0 && static_cast<std::size_t>(node.index) < poses.size();
  };
  // Hundreds of them must not hide the map.
  const auto count = std::count_if(result.loop_closures.begin(), result.loop_closures.end(),
                                   [](const LoopClosure& closure) { return closure.accepted; });
  const double alpha = std::clamp(
      0.55 * std::sqrt(50.0 / static_cast<double>(std::max<std::int64_t>(count, 1))), 0.1, 0.55);
  for (const LoopClosure& closure : result.loop_closures) {
    if (!closure.accepted || !exists(closure.from) || !exists(closure.to)) continue;
    const Point from =
        view.pixel_of(poses[static_cast<std::size_t>(closure.from.index)].translation());
    const Point to = view.pixel_of(poses[static_cast<std::size_t>(closure.to.index)].translation());
    Colour line = kClosure;
    line.alpha = alpha;
    canvas.line({from, to}, 0.45 * sizes.path, line);
    for (const Point& end : {from, to})
      canvas.disc(end, 0.75 * sizes.path, kClosure, 0.0, kClosure);
  }
}

void draw_marks(const Trajectory& trajectory, const MapView& view, const Sizes& sizes,
                Canvas& canvas) {
  if (trajectory.empty()) return;
  const Pose2& first = trajectory.front().pose;
  const Pose2& last = trajectory.back().pose;
  const Point start = view.pixel_of(first.translation());
  const Point end = view.pixel_of(last.translation());
  const double r = sizes.marker;
  // The start is an arrowhead along the first heading, the end a square.
  const auto ahead = [&](double forward, double left) -> Point {
    const double c = std::cos(first.yaw);
    const double s = std::sin(first.yaw);
    return {start.x + r * (c * forward - s * left), start.y - r * (s * forward + c * left)};
  };
  const double edge = 0.25 * r;
  canvas.polygon({{end.x - 0.8 * r, end.y - 0.8 * r},
                  {end.x + 0.8 * r, end.y - 0.8 * r},
                  {end.x + 0.8 * r, end.y + 0.8 * r},
                  {end.x - 0.8 * r, end.y + 0.8 * r}},
                 kEnd, edge, kPaper);
  canvas.polygon({ahead(1.6, 0.0), ahead(-1.0, 1.0), ahead(-0.5, 0.0), ahead(-1.0, -1.0)}, kStart,
                 edge, kPaper);
  // Labels go to opposite sides when the two places coincide.
  const bool close = std::hypot(start.x - end.x, start.y - end.y) < 4.0 * sizes.text;
  const bool start_above = !close || start.y <= end.y;
  const auto label = [&](Point at, const char* words, const Colour& colour, bool above) {
    at.y += above ? -1.6 * r : 1.6 * r + 0.75 * sizes.text;
    const double edge_px = 1.6 * sizes.text;
    at.x = std::clamp(at.x, edge_px, std::max(edge_px, view.width_px - edge_px));
    at.y = std::clamp(at.y, sizes.text, std::max(sizes.text, view.height_px - 0.4 * sizes.text));
    canvas.text_with_halo(at, words, 0.95 * sizes.text, colour, kPaper, 0.5);
  };
  label(start, "start", kStart, start_above);
  label(end, "end", kEnd, close && !start_above);
}

/// A strip below the map. Each item is drawn at x and returns the width it took.
class Footer {
 public:
  Footer(Canvas& canvas, const Sizes& sizes, double top, double width)
      : canvas_(canvas), sizes_(sizes), top_(top), width_(width) {
    canvas_.fill_rectangle({0.0, top}, width, height(sizes), kPaper);
    canvas_.line({{0.0, top}, {width, top}}, 1.0, hex_colour(0xb6bdc8));
  }
  static double height(const Sizes& sizes) { return 3.2 * sizes.text; }

  void scale_bar(double pixels_per_metre) {
    const double length_m =
        round_down(std::max(0.16 * width_, 3.0 * sizes_.text) / pixels_per_metre);
    const double length = length_m * pixels_per_metre;
    const double y = line_y() + 0.25 * sizes_.text;
    canvas_.line({{x_, y - 0.35 * sizes_.text},
                  {x_, y},
                  {x_ + length, y},
                  {x_ + length, y - 0.35 * sizes_.text}},
                 0.13 * sizes_.text, kInk);
    canvas_.text({x_ + 0.5 * length, y - 0.45 * sizes_.text}, fmt::format("{:g} m", length_m),
                 sizes_.text, kInk, 0.5);
    x_ += length + 2.0 * sizes_.text;
  }

  void axes() {
    const double size = 1.5 * sizes_.text;
    const Point corner{x_ + 0.4 * sizes_.text, line_y() + 0.55 * sizes_.text};
    arrow(corner, {corner.x + size, corner.y});
    arrow(corner, {corner.x, corner.y - size});
    canvas_.text({corner.x + size + 0.35 * sizes_.text, corner.y + 0.3 * sizes_.text}, "x",
                 sizes_.text, kInk);
    canvas_.text({corner.x + 0.4 * sizes_.text, corner.y - size + 0.3 * sizes_.text}, "y",
                 sizes_.text, kInk);
    x_ += size + 3.4 * sizes_.text;
  }

  void time_ramp(double duration_s) {
    const std::string last = readable_time(duration_s);
    const double length = 6.0 * sizes_.text;
    const double words =
        canvas_.text_width("path, 0 s", sizes_.text) + canvas_.text_width(last, sizes_.text);
    if (!fits(length + words + sizes_.text)) return;
    canvas_.text({x_, text_y()}, "path, 0 s", sizes_.text, kInk);
    x_ += canvas_.text_width("path, 0 s", sizes_.text) + 0.5 * sizes_.text;
    constexpr int kSteps = 48;
    for (int i = 0; i < kSteps; ++i) {
      canvas_.fill_rectangle({x_ + length * i / kSteps, line_y() - 0.25 * sizes_.text},
                             length / kSteps + 0.6, 0.5 * sizes_.text,
                             time_colour((i + 0.5) / kSteps));
    }
    x_ += length + 0.5 * sizes_.text;
    canvas_.text({x_, text_y()}, last, sizes_.text, kInk);
    x_ += canvas_.text_width(last, sizes_.text) + 2.0 * sizes_.text;
  }

  void loop_closures(std::int64_t count) {
    const std::string words =
        count == 1 ? "1 loop closure" : with_thousands(count) + " loop closures";
    if (!fits(canvas_.text_width(words, sizes_.text) + 3.0 * sizes_.text)) return;
    const double y = line_y();
    const Point from{x_, y};
    const Point to{x_ + 1.8 * sizes_.text, y};
    canvas_.line({from, to}, 0.8 * sizes_.path, kClosure);
    for (const Point& end : {from, to})
      canvas_.disc(end, 0.17 * sizes_.text, kClosure, 0.0, kClosure);
    x_ = to.x + 0.6 * sizes_.text;
    canvas_.text({x_, text_y()}, words, sizes_.text, kInk);
    x_ += canvas_.text_width(words, sizes_.text) + 2.0 * sizes_.text;
  }

 private:
  [[nodiscard]] bool fits(double length) const { return x_ + length <= width_ - sizes_.padding; }
  [[nodiscard]] double line_y() const { return top_ + 0.5 * height(sizes_); }
  [[nodiscard]] double text_y() const { return line_y() + 0.36 * sizes_.text; }

  void arrow(Point from, Point to) {
    canvas_.line({from, to}, 0.11 * sizes_.text, kInk);
    const double length = std::hypot(to.x - from.x, to.y - from.y);
    const Point u{(to.x - from.x) / length * 0.4 * sizes_.text,
                  (to.y - from.y) / length * 0.4 * sizes_.text};
    canvas_.polygon({{to.x + 0.5 * u.x, to.y + 0.5 * u.y},
                     {to.x - u.x - 0.6 * u.y, to.y - u.y + 0.6 * u.x},
                     {to.x - u.x + 0.6 * u.y, to.y - u.y - 0.6 * u.x}},
                    kInk, 0.0, kInk);
  }

  Canvas& canvas_;
  const Sizes& sizes_;
  double top_;
  double width_;
  double x_ = sizes_.padding;
};

}  // namespace

Image draw_map_picture(const MapResult& result, const MapPictureOptions& options) {
  const MapView view =
      view_of(result.map, result.trajectory, options.target_side_px, options.most_side_px);
  const Sizes sizes(std::max(view.width_px, view.height_px));
  // A tall, narrow map still has room for the scale bar and the axes.
  const int width = std::max(view.width_px, static_cast<int>(16.0 * sizes.text));
  const int height = view.height_px + static_cast<int>(Footer::height(sizes));
  Canvas canvas(width, height, hex_colour(0xd9dde3));
  canvas.paste(shade_map(result.map, view), 0, 0);
  if (options.loop_closures) draw_loop_closures(result, view, sizes, canvas);
  if (options.trajectory) draw_path(result.trajectory, view, sizes, canvas);
  if (options.trajectory) draw_marks(result.trajectory, view, sizes, canvas);

  Footer footer(canvas, sizes, view.height_px, width);
  footer.scale_bar(view.pixels_per_metre());
  footer.axes();
  if (options.trajectory) footer.time_ramp(result.statistics.duration_s);
  const auto accepted = std::count_if(result.loop_closures.begin(), result.loop_closures.end(),
                                      [](const LoopClosure& closure) { return closure.accepted; });
  if (options.loop_closures && accepted > 0) footer.loop_closures(accepted);
  return canvas.image();
}

}  // namespace loopstone
