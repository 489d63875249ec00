#include "report/path_line.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "loopstone/base/hypotenuse.hpp"

namespace loopstone {

void draw_path_line(const Trajectory& trajectory, const MapView& view, double width_px,
                    Canvas& canvas, std::span<const Stamp> lifted) {
  if (trajectory.size() < 2) return;
  const double duration_s = (trajectory.back().stamp - trajectory.front().stamp).seconds();
  constexpr int kColours = 96;
  std::vector<Point> run;
  int run_colour = 0;
  const auto finish_run = [&] {
    canvas.line(run, width_px, time_colour((run_colour + 0.5) / kColours));
    if (!run.empty()) run = {run.back()};
  };
  for (const StampedPose2& stamped : trajectory.poses()) {
    if (std::ranges::find(lifted, stamped.stamp) != lifted.end()) {
      finish_run();
      run.clear();
    }
    const double share =
        duration_s > 0.0 ? (stamped.stamp - trajectory.front().stamp).seconds() / duration_s : 0.0;
    const int colour = std::min(static_cast<int>(share * kColours), kColours - 1);
    if (colour != run_colour) {
      finish_run();
      run_colour = colour;
    }
    const Point point = view.pixel_of(stamped.pose.translation());
    if (run.empty() || hypotenuse(point.x - run.back().x, point.y - run.back().y) > 0.7)
      run.push_back(point);
  }
  finish_run();
}

}  // namespace loopstone
