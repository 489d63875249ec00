#include "loopstone/report/map_picture.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <initializer_list>

#include "report/canvas.hpp"
#include "report/map_view.hpp"
#include "report/path_line.hpp"
#include "report/picture_parts.hpp"
#include "report/text.hpp"

namespace loopstone {
namespace {

const Colour kClosure = hex_colour(0x059669);
const Colour kLandmark = hex_colour(0xb45309);

void draw_loop_closures(const MapResult& result, const MapView& view, const PictureSizes& sizes,
                        Canvas& canvas) {
  const auto& poses = result.graph.poses;
  const auto exists = [&](NodeId node) {
    return node.index >= 0 && static_cast<std::size_t>(node.index) < poses.size();
  };
  // Hundreds of them must not hide the map.
  const auto count = std::count_if(result.loop_closures.begin(), result.loop_closures.end(),
                                   [](const LoopClosure& closure) { return closure.stands(); });
  const double alpha = std::clamp(
      0.55 * std::sqrt(50.0 / static_cast<double>(std::max<std::int64_t>(count, 1))), 0.1, 0.55);
  for (const LoopClosure& closure : result.loop_closures) {
    if (!closure.stands() || !exists(closure.from) || !exists(closure.to)) continue;
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

/// From start to end in the colours of the path.
void add_time_ramp(Footer& footer, const PictureSizes& sizes, double duration_s) {
  const double length = 6.0 * sizes.text;
  const double height = 0.5 * sizes.text;
  footer.add("path, 0 s", length, readable_time(duration_s), [=](Canvas& canvas, Point at) {
    constexpr int kSteps = 48;
    for (int i = 0; i < kSteps; ++i) {
      canvas.fill_rectangle({at.x + length * i / kSteps, at.y - 0.5 * height},
                            length / kSteps + 0.6, height, time_colour((i + 0.5) / kSteps));
    }
  });
}

void add_loop_closures(Footer& footer, const PictureSizes& sizes, std::int64_t count) {
  const double length = 1.8 * sizes.text;
  footer.add("", length, count == 1 ? "1 loop closure" : with_thousands(count) + " loop closures",
             [=](Canvas& canvas, Point at) {
               const Point to{at.x + length, at.y};
               canvas.line({at, to}, 0.8 * sizes.path, kClosure);
               for (const Point& end : {at, to})
                 canvas.disc(end, 0.17 * sizes.text, kClosure, 0.0, kClosure);
             });
}

void draw_landmark(Point at, const PictureSizes& sizes, Canvas& canvas) {
  canvas.disc(at, 1.1 * sizes.path, kLandmark, 0.3 * sizes.path, kPaper);
}

void add_landmarks(Footer& footer, const PictureSizes& sizes, std::size_t count) {
  footer.add(
      "", 0.8 * sizes.text,
      count == 1 ? "1 landmark" : with_thousands(static_cast<std::int64_t>(count)) + " landmarks",
      [=](Canvas& canvas, Point at) {
        draw_landmark({at.x + 0.4 * sizes.text, at.y}, sizes, canvas);
      });
}

}  // namespace

Image draw_map_picture(const MapResult& result, const MapPictureOptions& options,
                       std::span<const FoundLandmark> landmarks) {
  const MapView view =
      view_of(result.map, result.trajectory, options.target_side_px, options.most_side_px);
  const PictureSizes sizes(std::max(view.width_px, view.height_px));
  // A tall, narrow map still has room for the scale bar and the axes.
  const int width = std::max(view.width_px, static_cast<int>(16.0 * sizes.text));
  Footer footer(sizes, width);
  footer.add_scale_bar(view.pixels_per_metre());
  footer.add_axes();
  if (options.trajectory) add_time_ramp(footer, sizes, result.statistics.duration_s);
  const auto accepted = std::count_if(result.loop_closures.begin(), result.loop_closures.end(),
                                      [](const LoopClosure& closure) { return closure.stands(); });
  if (options.loop_closures && accepted > 0) add_loop_closures(footer, sizes, accepted);
  if (!landmarks.empty()) add_landmarks(footer, sizes, landmarks.size());

  Canvas canvas(width, view.height_px + static_cast<int>(footer.height()), kUnseenGround);
  canvas.paste(shade_map(result.map, view), 0, 0);
  if (options.loop_closures) draw_loop_closures(result, view, sizes, canvas);
  if (options.trajectory && !result.trajectory.empty()) {
    std::vector<Stamp> begins;
    for (const MappedDrive& drive : result.drives) begins.push_back(drive.begins);
    draw_path_line(result.trajectory, view, sizes.path, canvas, begins);
    for (const Trajectory& drive : result.trajectories()) {
      if (!drive.empty())
        draw_start_and_end(drive.front().pose, drive.back().pose, view, sizes, canvas);
    }
  }
  for (const FoundLandmark& landmark : landmarks)
    draw_landmark(view.pixel_of(landmark.position), sizes, canvas);
  footer.draw(canvas, view.height_px);
  return canvas.image();
}

}  // namespace loopstone
