#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "loopstone/report/localization_picture.hpp"
#include "report/canvas.hpp"
#include "report/map_view.hpp"
#include "report/picture_parts.hpp"
#include "report/plane_panel.hpp"
#include "report/state_style.hpp"
#include "report/text.hpp"

namespace loopstone {
namespace {

/// More labels hide the map; the least probable places go without.
constexpr std::size_t kMostLabels = 6;

/// The part of a map where something is known.
ViewBox known_box(const CellStates& map) {
  const MapView view = view_of(map, Trajectory{}, 1000, 1000);
  const GridFrame& frame = view.frame;
  const auto corner = [&](int column, int row) -> Eigen::Vector2d {
    return frame.origin + frame.resolution * Eigen::Vector2d(column, row);
  };
  return {corner(view.low.column, view.low.row), corner(view.high.column + 1, view.high.row + 1)};
}

/// A rectangle of the picture.
struct Area {
  double left = 0.0;
  double top = 0.0;
  double width = 0.0;
  double height = 0.0;
};

PlanePanel panel_of(const Area& area, const ViewBox& box) {
  const Eigen::Vector2d size = (box.high - box.low).cwiseMax(1e-3);
  return {{area.left, area.top},
          area.width,
          area.height,
          box,
          std::min(area.width / size.x(), area.height / size.y())};
}

ViewBox box_around(const Eigen::Vector2d& centre, double side_m) {
  const Eigen::Vector2d half = Eigen::Vector2d::Constant(0.5 * side_m);
  return {centre - half, centre + half};
}

/// True when a close-up around the estimate would leave out much of the belief.
bool is_wide(const BeliefSnapshot& snapshot, double close_up_m) {
  const Eigen::Vector2d centre = snapshot.estimate.map_T_robot.translation();
  const auto outside = [&](const Pose2& pose) {
    return (pose.translation() - centre).cwiseAbs().maxCoeff() > 0.5 * close_up_m;
  };
  const auto strays = std::count_if(snapshot.particles.begin(), snapshot.particles.end(), outside);
  const bool elsewhere = std::any_of(
      snapshot.hypotheses.begin(), snapshot.hypotheses.end(), [&](const auto& hypothesis) {
        return hypothesis.probability > 0.02 && outside(hypothesis.map_T_robot);
      });
  return elsewhere || 20 * strays > static_cast<std::ptrdiff_t>(snapshot.particles.size());
}

std::string percent(double share) { return fmt::format("{:.0f} %", 100.0 * share); }

}  // namespace

struct BeliefPainter::Layout {
  const CellStates& map;
  Stamp start;
  BeliefPictureOptions options;
  double text = 12.0;
  int width = 0;
  int height = 0;
  ViewBox known;
  Area whole;     // of the whole map; not drawn when its width is 0
  Area close_up;  // or the only one
  Image shaded;   // the whole map, as it lies in its area

  Layout(const CellStates& occupancy, Stamp start_stamp, const BeliefPictureOptions& how);

  [[nodiscard]] double header_px() const { return 2.6 * text; }
  [[nodiscard]] double footer_px() const { return options.whole_map ? 2.2 * text : 0.0; }
  void draw_header(Canvas& canvas, const BeliefSnapshot& snapshot) const;
  void draw_footer(Canvas& canvas) const;
  void draw_belief(Canvas& canvas, const Area& area, const PlanePanel& panel,
                   const BeliefSnapshot& snapshot, bool close) const;
};

BeliefPainter::Layout::Layout(const CellStates& occupancy, Stamp start_stamp,
                              const BeliefPictureOptions& how)
    : map(occupancy), start(start_stamp), options(how), known(known_box(occupancy)) {
  // Even sides: video encoders want them.
  width = std::max(options.width_px, 240) / 2 * 2;
  text = std::clamp(width / (options.whole_map ? 64.0 : 30.0), 11.0, 30.0);
  const double gap = options.whole_map ? std::round(0.7 * text) : 0.0;
  const double top = std::round(header_px());
  double side = width * 0.8;
  if (options.whole_map) {
    const Eigen::Vector2d size = (known.high - known.low).cwiseMax(1e-3);
    // The close-up is a square, the whole map beside it as high: widths add up where the map's
    // shape allows.
    side = std::round(
        std::clamp((width - 3.0 * gap) / (1.0 + size.x() / size.y()), 0.3 * width, 0.5 * width));
    whole = {gap, top, width - 3.0 * gap - side, side};
    close_up = {whole.left + whole.width + gap, top, side, side};
  } else {
    side = std::round(side);
    close_up = {0.0, top, static_cast<double>(width), side};
    whole = close_up;
  }
  height = 2 * static_cast<int>(std::ceil(0.5 * (top + side + footer_px())));
  shaded = panel_of(whole, known).shade(map);
}

void BeliefPainter::Layout::draw_header(Canvas& canvas, const BeliefSnapshot& snapshot) const {
  const LocalizationEstimate& estimate = snapshot.estimate;
  const std::string state(to_string(estimate.state));
  const double base = 0.5 * header_px() + 0.36 * text;
  const double chip = text_width(state, text, FontWeight::kBold) + 1.2 * text;
  double x = options.whole_map ? whole.left : 0.6 * text;
  canvas.fill_rectangle({x, 0.5 * header_px() - 0.8 * text}, chip, 1.6 * text,
                        state_colour(estimate.state));
  canvas.text({x + 0.6 * text, base}, state, text, state_text_colour(estimate.state), 0.0,
              FontWeight::kBold);
  x += chip + 0.8 * text;
  canvas.text({x, base}, fmt::format("{:.1f} s", (snapshot.stamp - start).seconds()), text, kInk);
  x += (options.whole_map ? 6.0 : 4.2) * text;
  // The probability as a bar, so that it can be followed from picture to picture.
  const std::string words = options.whole_map ? "probability  " : "prob. ";
  canvas.text({x, base}, words, text, kInk);
  x += text_width(words, text);
  const double bar = (options.whole_map ? 8.0 : 4.0) * text;
  const double bar_top = 0.5 * header_px() - 0.35 * text;
  canvas.fill_rectangle({x, bar_top}, bar, 0.7 * text, hex_colour(0xe5e7eb));
  canvas.fill_rectangle({x, bar_top}, bar * std::clamp(estimate.probability, 0.0, 1.0), 0.7 * text,
                        state_colour(estimate.state));
  x += bar + 0.5 * text;
  canvas.text({x, base}, percent(estimate.probability), text, kInk);
  const auto places = static_cast<std::int64_t>(snapshot.hypotheses.size());
  const double right = width - (options.whole_map ? whole.left : 0.6 * text);
  std::string counts = with_thousands(places) + (places == 1 ? " place" : " places");
  if (options.whole_map) {
    counts +=
        ", " + with_thousands(static_cast<std::int64_t>(snapshot.particles.size())) + " particles";
  }
  canvas.text({right, base}, counts, text, hex_colour(0x5b6675), 1.0);
}

void BeliefPainter::Layout::draw_footer(Canvas& canvas) const {
  const double base = height - 0.5 * footer_px() + 0.36 * text;
  double x = whole.left;
  const auto entry = [&](const std::string& words, const Colour& colour, bool is_ring) {
    const Point at{x + 0.4 * text, base - 0.33 * text};
    if (is_ring) {
      canvas.ring(at, 0.36 * text, 0.16 * text, colour);
    } else {
      canvas.disc(at, 0.26 * text, colour, 0.0, colour);
    }
    x += 1.2 * text;
    canvas.text({x, base}, words, 0.9 * text, kInk);
    x += text_width(words, 0.9 * text) + 1.8 * text;
  };
  entry("particle", kParticleColour, false);
  entry("place where the robot may be, and how probably", hex_colour(0x6d28d9), true);
  entry("scan, seen from the estimate", kScanColour, false);
}

void BeliefPainter::Layout::draw_belief(Canvas& canvas, const Area& area, const PlanePanel& panel,
                                        const BeliefSnapshot& snapshot, bool close) const {
  canvas.clip({area.left, area.top}, area.width, area.height);
  const LocalizationEstimate& estimate = snapshot.estimate;
  for (const Eigen::Vector2f& point : snapshot.points) {
    panel.dot(canvas, estimate.map_T_robot * point.cast<double>(),
              close ? 0.26 * text : 0.12 * text, kScanColour);
  }
  panel.robot(canvas, estimate.map_T_robot, state_colour(estimate.state));
  Colour particle_colour = kParticleColour;
  particle_colour.alpha =
      std::clamp(12.0 / std::sqrt(static_cast<double>(snapshot.particles.size()) + 1.0), 0.15, 0.9);
  for (const Pose2& particle : snapshot.particles) {
    panel.dot(canvas, particle.translation(), 0.2 * text, particle_colour);
    if (!close) continue;
    const Point from = panel.pixel_of(particle.translation());
    if (!panel.shows(from)) continue;
    canvas.line({from,
                 {from.x + 0.7 * text * std::cos(particle.yaw),
                  from.y - 0.7 * text * std::sin(particle.yaw)}},
                0.07 * text, particle_colour);
  }
  const Colour place = hex_colour(0x6d28d9);
  for (std::size_t i = 0; i < snapshot.hypotheses.size(); ++i) {
    const LocalizationHypothesis& hypothesis = snapshot.hypotheses[i];
    const Point at = panel.pixel_of(hypothesis.map_T_robot.translation());
    if (!panel.shows(at) || (close && snapshot.hypotheses.size() == 1)) continue;
    const double radius = 0.75 * text;
    canvas.ring(at, radius, 0.3 * text, kPaper);
    canvas.ring(at, radius, 0.15 * text, place);
    if (i >= kMostLabels || snapshot.hypotheses.size() == 1) continue;
    const double x = std::clamp(at.x, area.left + 1.6 * text, area.left + area.width - 1.6 * text);
    const double above = at.y - 1.1 * text;
    const bool fits = above - text > area.top;
    canvas.text_with_halo({x, fits ? above : at.y + 1.9 * text}, percent(hypothesis.probability),
                          0.85 * text, place, kPaper, 0.5);
  }
  if (close) {
    panel.ellipse(canvas, estimate.map_T_robot.translation(),
                  estimate.covariance.topLeftCorner<2, 2>(), 2.0, 0.14 * text,
                  state_colour(estimate.state));
  }
  panel.scale_bar(canvas, 0.9 * text, kInk, kPaper);
  canvas.unclip();
  panel.frame(canvas, kHairline);
}

BeliefPainter::BeliefPainter(const Grid<std::int8_t>& occupancy, Stamp start,
                             const BeliefPictureOptions& options)
    : layout_(std::make_unique<const Layout>(occupancy, start, options)) {}
BeliefPainter::~BeliefPainter() = default;
BeliefPainter::BeliefPainter(BeliefPainter&&) noexcept = default;
BeliefPainter& BeliefPainter::operator=(BeliefPainter&&) noexcept = default;

Image BeliefPainter::draw(const BeliefSnapshot& snapshot) const {
  const Layout& layout = *layout_;
  Canvas canvas(layout.width, layout.height, kPaper);
  layout.draw_header(canvas, snapshot);
  const bool wide = is_wide(snapshot, layout.options.close_up_m);
  if (layout.options.whole_map || wide) {
    const PlanePanel panel = panel_of(layout.whole, layout.known);
    panel.paste(canvas, layout.shaded);
    layout.draw_belief(canvas, layout.whole, panel, snapshot, false);
  }
  if (layout.options.whole_map || !wide) {
    const PlanePanel panel = panel_of(
        layout.close_up,
        box_around(snapshot.estimate.map_T_robot.translation(), layout.options.close_up_m));
    panel.draw_map(canvas, layout.map);
    layout.draw_belief(canvas, layout.close_up, panel, snapshot, true);
  }
  if (layout.options.whole_map) layout.draw_footer(canvas);
  return canvas.image();
}

}  // namespace loopstone
