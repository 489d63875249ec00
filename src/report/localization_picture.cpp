#include "loopstone/report/localization_picture.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <string>
#include <vector>

#include "loopstone/base/hypotenuse.hpp"
#include "report/canvas.hpp"
#include "report/localization_figures.hpp"
#include "report/map_view.hpp"
#include "report/picture_parts.hpp"
#include "report/state_style.hpp"
#include "report/text.hpp"

namespace loopstone {
namespace {

constexpr LocalizationState kStates[] = {LocalizationState::kTracking, LocalizationState::kDoubtful,
                                         LocalizationState::kLost};
const Colour kSearch = hex_colour(0x6d28d9);
const Colour kJump = hex_colour(0x6b7280);

/// States differ by more than colour: LOST is dotted, DOUBTFUL thick.
void draw_stretch(Canvas& canvas, const std::vector<Point>& points, LocalizationState state,
                  double width) {
  const Colour colour = state_colour(state);
  if (state == LocalizationState::kLost) {
    canvas.dashed_line(points, 1.2 * width, colour, 0.01, 2.4 * width);
  } else {
    canvas.line(points, state == LocalizationState::kDoubtful ? 1.6 * width : width, colour);
  }
}

void draw_magnifier(Canvas& canvas, Point centre, double radius) {
  const auto draw = [&](double width, const Colour& colour) {
    canvas.ring(centre, radius, width, colour);
    canvas.line({{centre.x + 0.75 * radius, centre.y + 0.75 * radius},
                 {centre.x + 1.7 * radius, centre.y + 1.7 * radius}},
                1.3 * width, colour);
  };
  draw(0.75 * radius, kPaper);
  draw(0.36 * radius, kSearch);
}

class MapOfPath {
 public:
  MapOfPath(const LocalizationResult& result, const MapView& view, const PictureSizes& sizes,
            Canvas& canvas)
      : result_(result), view_(view), sizes_(sizes), canvas_(canvas) {}

  void particles(const std::vector<std::size_t>& snapshots) {
    for (const std::size_t i : snapshots) {
      const std::vector<Pose2>& cloud = result_.snapshots[i].particles;
      Colour colour = kParticleColour;
      colour.alpha =
          std::clamp(8.0 / std::sqrt(static_cast<double>(cloud.size()) + 1.0), 0.12, 0.8);
      const double side = 0.16 * sizes_.text;
      for (const Pose2& particle : cloud) {
        const Point at = view_.pixel_of(particle.translation());
        if (at.x < 0.0 || at.y < 0.0 || at.x > view_.width_px || at.y > view_.height_px) continue;
        canvas_.fill_rectangle({at.x - 0.5 * side, at.y - 0.5 * side}, side, side, colour);
      }
    }
  }

  void path() {
    const auto& estimates = result_.estimates;
    const auto jumps = [&](std::size_t i) { return is_jump(estimates[i - 1], estimates[i]); };
    const std::vector<StateRun> runs = state_runs(estimates, jumps);
    for (const StateRun& run : runs) {
      if (run.first == 0 || !jumps(run.first)) continue;
      canvas_.dashed_line({pixel(run.first - 1), pixel(run.first)}, 0.5 * width(), kJump,
                          1.2 * width(), 1.5 * width());
    }
    for (const StateRun& run : runs) {
      if (run.state != LocalizationState::kLost)
        canvas_.line(points_of(run), 2.2 * width(), hex_colour(0xffffff, 0.75));
    }
    // What matters most lies on top.
    for (const LocalizationState state : kStates) {
      for (const StateRun& run : runs) {
        if (run.state == state) draw_stretch(canvas_, points_of(run), state, width());
      }
    }
  }

  void searches() {
    std::vector<Point> drawn;
    for (const LocalizationSearch& search : result_.searches) {
      const LocalizationEstimate* estimate = estimate_at(result_, search.stamp);
      if (estimate == nullptr) continue;
      const Point at = view_.pixel_of(estimate->map_T_robot.translation());
      const bool there = std::any_of(drawn.begin(), drawn.end(), [&](const Point& other) {
        return hypotenuse(at.x - other.x, at.y - other.y) < 0.6 * sizes_.text;
      });
      if (there) continue;
      drawn.push_back(at);
      draw_magnifier(canvas_, at, 0.42 * sizes_.text);
    }
  }

  /// A dot and the time where a cloud is shown; times that would hide another are left out.
  void times(const std::vector<std::size_t>& snapshots) {
    std::vector<Point> labels;
    for (const std::size_t i : snapshots) {
      const BeliefSnapshot& snapshot = result_.snapshots[i];
      const Point at = view_.pixel_of(snapshot.estimate.map_T_robot.translation());
      canvas_.disc(at, 0.2 * sizes_.text, kPaper, 0.09 * sizes_.text, kParticleColour);
      const bool hidden = std::any_of(labels.begin(), labels.end(), [&](const Point& other) {
        return std::abs(at.x - other.x) < 4.0 * sizes_.text &&
               std::abs(at.y - other.y) < 1.1 * sizes_.text;
      });
      if (hidden) continue;
      labels.push_back(at);
      const double time_s = (snapshot.stamp - result_.start).seconds();
      const double edge = 2.0 * sizes_.text;
      const Point label{std::clamp(at.x, edge, std::max(edge, view_.width_px - edge)),
                        std::max(at.y - 0.55 * sizes_.text, sizes_.text)};
      canvas_.text_with_halo(label, fmt::format("{:.0f} s", time_s), 0.8 * sizes_.text,
                             kParticleColour, kPaper, 0.5);
    }
  }

 private:
  [[nodiscard]] double width() const { return 1.4 * sizes_.path; }
  [[nodiscard]] Point pixel(std::size_t i) const {
    return view_.pixel_of(result_.estimates[i].map_T_robot.translation());
  }
  /// Up to the next run, so that colours meet.
  [[nodiscard]] std::vector<Point> points_of(const StateRun& run) const {
    std::vector<Point> points{pixel(run.first)};
    const auto& estimates = result_.estimates;
    const std::size_t next = run.last + 1;
    const bool joins = next < estimates.size() && !is_jump(estimates[run.last], estimates[next]);
    for (std::size_t i = run.first + 1; i <= (joins ? next : run.last); ++i) {
      const Point point = pixel(i);
      if (hypotenuse(point.x - points.back().x, point.y - points.back().y) > 0.7)
        points.push_back(point);
    }
    if (points.size() == 1) points.push_back(points.front());  // a dot
    return points;
  }

  const LocalizationResult& result_;
  const MapView& view_;
  const PictureSizes& sizes_;
  Canvas& canvas_;
};

/// Of `count` things at most `most`, first and last among them.
std::vector<std::size_t> spread_over(std::size_t count, int most) {
  std::vector<std::size_t> chosen;
  const auto wanted = std::min(count, static_cast<std::size_t>(std::max(most, 0)));
  for (std::size_t k = 0; k < wanted; ++k)
    chosen.push_back(wanted == 1 ? 0 : k * (count - 1) / (wanted - 1));
  return chosen;
}

std::int64_t jumps_of(const LocalizationResult& result) {
  std::int64_t count = 0;
  for (std::size_t i = 1; i < result.estimates.size(); ++i)
    count += is_jump(result.estimates[i - 1], result.estimates[i]) ? 1 : 0;
  return count;
}

void add_legend(Footer& footer, const LocalizationResult& result, const PictureSizes& sizes,
                bool has_clouds) {
  const LocalizationFigures figures = figures_of(result);
  const double text = sizes.text;
  for (const LocalizationState state : kStates) {
    footer.add("", 2.2 * text,
               fmt::format("{} {:.1f} %", to_string(state), 100.0 * figures.share(state)),
               [=](Canvas& canvas, Point at) {
                 draw_stretch(canvas, {at, {at.x + 2.2 * text, at.y}}, state, 0.22 * text);
               });
  }
  if (has_clouds) {
    footer.add("", 1.6 * text, "particles at the times shown", [=](Canvas& canvas, Point at) {
      constexpr double kDots[][2] = {{0.1, -0.2}, {0.5, 0.3},   {0.8, -0.4}, {1.0, 0.05},
                                     {1.4, 0.3},  {0.45, -0.5}, {1.3, -0.25}};
      for (const auto& [right, down] : kDots)
        canvas.fill_rectangle({at.x + right * text, at.y + down * text}, 0.2 * text, 0.2 * text,
                              kParticleColour);
    });
  }
  if (!result.searches.empty()) {
    const auto count = static_cast<std::int64_t>(result.searches.size());
    footer.add("", 1.2 * text,
               count == 1 ? "search of the map" : with_thousands(count) + " searches of the map",
               [=](Canvas& canvas, Point at) {
                 draw_magnifier(canvas, {at.x + 0.45 * text, at.y - 0.1 * text}, 0.42 * text);
               });
  }
  if (const std::int64_t jumps = jumps_of(result); jumps > 0) {
    footer.add("", 2.2 * text,
               jumps == 1 ? "jump of the pose" : with_thousands(jumps) + " jumps of the pose",
               [=](Canvas& canvas, Point at) {
                 canvas.dashed_line({at, {at.x + 2.2 * text, at.y}}, 0.09 * text, kJump,
                                    0.25 * text, 0.3 * text);
               });
  }
}

}  // namespace

Image draw_localization_picture(const LocalizationResult& result,
                                const Grid<std::int8_t>& occupancy,
                                const LocalizationPictureOptions& options) {
  const MapView view =
      view_of(occupancy, result.trajectory(), options.target_side_px, options.most_side_px);
  const PictureSizes sizes(std::max(view.width_px, view.height_px));
  const int width = std::max(view.width_px, static_cast<int>(20.0 * sizes.text));
  const std::vector<std::size_t> clouds =
      result.estimates.empty() ? std::vector<std::size_t>{}
                               : spread_over(result.snapshots.size(), options.most_clouds);
  Footer footer(sizes, width);
  footer.add_scale_bar(view.pixels_per_metre());
  footer.add_axes();
  if (!result.estimates.empty()) add_legend(footer, result, sizes, !clouds.empty());

  Canvas canvas(width, view.height_px + static_cast<int>(footer.height()), kUnseenGround);
  canvas.paste(shade_map(occupancy, view), 0, 0);
  canvas.clip({0.0, 0.0}, view.width_px, view.height_px);
  MapOfPath map(result, view, sizes, canvas);
  if (!result.estimates.empty()) {
    map.particles(clouds);
    map.path();
    map.times(clouds);
    map.searches();
    draw_start_and_end(result.estimates.front().map_T_robot, result.estimates.back().map_T_robot,
                       view, sizes, canvas);
  }
  canvas.unclip();
  footer.draw(canvas, view.height_px);
  return canvas.image();
}

}  // namespace loopstone
