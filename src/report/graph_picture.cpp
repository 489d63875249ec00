#include "loopstone/report/graph_picture.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include "loopstone/base/error.hpp"
#include "report/canvas.hpp"
#include "report/picture_parts.hpp"
#include "report/plane_panel.hpp"

namespace loopstone {

namespace {

const Colour kSetAside = hex_colour(0xdc2626);
const Colour kLandmark = hex_colour(0x047857);
/// An edge that fits costs about its three degrees of freedom; from here on it stands out.
constexpr double kNoticedChi2 = 11.3;  // 1 % of the edges of a right model

std::size_t index(NodeId node) { return static_cast<std::size_t>(node.index); }

bool is_step(const RelativePoseEdge& edge) {
  return edge.kind == EdgeKind::kOdometry || std::abs(edge.to.index - edge.from.index) == 1;
}

/// Light grey for what fits, darker up to ink for what is far off: the path has all the colours.
Colour closure_colour(double chi2) {
  const double share = std::clamp(std::log10(std::max(chi2, 1e-9) / kNoticedChi2) / 2.0, 0.0, 1.0);
  const Colour fits = hex_colour(0x94a3b8, 0.6);
  const Colour strained = hex_colour(0x111827, 0.9);
  const auto mix = [share](double a, double b) { return a + share * (b - a); };
  return {mix(fits.red, strained.red), mix(fits.green, strained.green),
          mix(fits.blue, strained.blue), mix(fits.alpha, strained.alpha)};
}

ViewBox box_of(std::span<const Pose2> poses) {
  ViewBox box{poses.front().translation(), poses.front().translation()};
  for (const Pose2& pose : poses) {
    box.low = box.low.cwiseMin(pose.translation());
    box.high = box.high.cwiseMax(pose.translation());
  }
  const double size = std::max((box.high - box.low).maxCoeff(), 1e-6);
  const Eigen::Vector2d middle = 0.5 * (box.low + box.high);
  const Eigen::Vector2d half =
      (0.5 * (box.high - box.low)).cwiseMax(0.2 * size) + Eigen::Vector2d::Constant(0.06 * size);
  return {middle - half, middle + half};
}

double side_of(const ViewBox& box) { return (box.high - box.low).maxCoeff(); }

/// Both in one frame, unless that would leave little of the smaller one.
void share_frame(ViewBox& a, ViewBox& b) {
  constexpr double kMuchLarger = 1.6;
  const ViewBox both{a.low.cwiseMin(b.low), a.high.cwiseMax(b.high)};
  if (side_of(both) < kMuchLarger * std::min(side_of(a), side_of(b))) a = b = both;
}

class GraphDrawing {
 public:
  GraphDrawing(const GraphScene& scene, const GraphPictureOptions& options, double line_px)
      : scene_(scene), options_(options), line_px_(line_px) {}

  void draw(Canvas& canvas, const PlanePanel& panel, std::span<const Pose2> poses,
            bool after) const {
    draw_closures(canvas, panel, poses, false);
    draw_path(canvas, panel, poses);
    if (after) draw_closures(canvas, panel, poses, true);
    if (after) {
      for (const Eigen::Vector2d& landmark : scene_.graph->landmarks) {
        canvas.disc(panel.pixel_of(landmark), 2.2 * line_px_, kLandmark, 0.6 * line_px_, kPaper);
      }
    }
    panel.robot(canvas, poses.front(), time_colour(0.0));
  }

  [[nodiscard]] std::size_t set_aside() const {
    return static_cast<std::size_t>(
        std::count_if(scene_.weights.begin(), scene_.weights.end(),
                      [this](double weight) { return weight < options_.set_aside_below; }));
  }

 private:
  [[nodiscard]] bool is_set_aside(std::size_t edge) const {
    return edge < scene_.weights.size() && scene_.weights[edge] < options_.set_aside_below;
  }
  void draw_path(Canvas& canvas, const PlanePanel& panel, std::span<const Pose2> poses) const {
    const double last = std::max(1.0, static_cast<double>(poses.size()) - 1.0);
    for (const RelativePoseEdge& edge : scene_.graph->edges) {
      if (!is_step(edge)) continue;
      canvas.line({panel.pixel_of(poses[index(edge.from)].translation()),
                   panel.pixel_of(poses[index(edge.to)].translation())},
                  line_px_, time_colour(edge.from.index / last));
    }
  }
  void draw_closures(Canvas& canvas, const PlanePanel& panel, std::span<const Pose2> poses,
                     bool those_set_aside) const {
    for (std::size_t i = 0; i < scene_.graph->edges.size(); ++i) {
      const RelativePoseEdge& edge = scene_.graph->edges[i];
      if (is_step(edge) || is_set_aside(i) != those_set_aside) continue;
      const Pose2& from = poses[index(edge.from)];
      const Pose2& to = poses[index(edge.to)];
      const std::vector<Point> line{panel.pixel_of(from.translation()),
                                    panel.pixel_of(to.translation())};
      if (those_set_aside) {
        canvas.dashed_line(line, line_px_, kSetAside, 4.0 * line_px_, 3.0 * line_px_);
      } else {
        canvas.line(line, 0.55 * line_px_, closure_colour(edge_chi2(edge, from, to)));
      }
    }
  }

  const GraphScene& scene_;
  const GraphPictureOptions& options_;
  double line_px_;
};

void add_legend(Footer& footer, const GraphScene& scene, std::size_t set_aside, double text_px,
                double line_px) {
  const double length = 5.0 * text_px;
  footer.add("start", length, "end", [=](Canvas& canvas, Point at) {
    constexpr int kSteps = 40;
    for (int i = 0; i < kSteps; ++i) {
      canvas.fill_rectangle({at.x + length * i / kSteps, at.y - 0.22 * text_px},
                            length / kSteps + 0.6, 0.44 * text_px, time_colour((i + 0.5) / kSteps));
    }
  });
  const auto closure = [=](double chi2) {
    return [=](Canvas& canvas, Point at) {
      canvas.line({at, {at.x + 2.0 * text_px, at.y}}, 1.2 * line_px, closure_colour(chi2));
    };
  };
  footer.add("", 2.0 * text_px, "closure that fits", closure(1.0));
  footer.add("", 2.0 * text_px, fmt::format("strained (chi2 {:g} and more)", 100.0 * kNoticedChi2),
             closure(100.0 * kNoticedChi2));
  if (set_aside > 0) {
    footer.add("", 2.0 * text_px, fmt::format("{} set aside", set_aside),
               [=](Canvas& canvas, Point at) {
                 canvas.dashed_line({at, {at.x + 2.0 * text_px, at.y}}, 1.2 * line_px, kSetAside,
                                    4.0 * line_px, 3.0 * line_px);
               });
  }
  if (!scene.graph->landmarks.empty()) {
    footer.add("", text_px, "landmark", [=](Canvas& canvas, Point at) {
      canvas.disc({at.x + 0.4 * text_px, at.y}, 0.3 * text_px, kLandmark, 0.0, kPaper);
    });
  }
}

}  // namespace

Image draw_graph_picture(const GraphScene& scene, const GraphPictureOptions& options) {
  const std::vector<Pose2>& after = scene.graph->poses;
  if (after.empty()) throw UsageError("a picture of a pose graph needs poses");
  if (scene.before.size() != after.size()) {
    throw UsageError("a picture of a pose graph needs as many poses before as after");
  }
  ViewBox boxes[] = {box_of(scene.before), box_of(after)};
  share_frame(boxes[0], boxes[1]);

  const double text = std::clamp(options.panel_px / 50.0, 11.0, 26.0);
  const double line_px = std::clamp(options.panel_px / 500.0, 1.0, 3.0);
  const double gap = 1.2 * text;
  // Each box fills its panel as far as its shape allows; both panels have the shape of the larger
  // need.
  double scales[2];
  Eigen::Vector2d needed = Eigen::Vector2d::Zero();
  for (std::size_t i = 0; i < 2; ++i) {
    scales[i] = options.panel_px / side_of(boxes[i]);
    needed = needed.cwiseMax((boxes[i].high - boxes[i].low) * scales[i]);
  }
  const GraphDrawing drawing(scene, options, line_px);
  Footer footer(PictureSizes(options.panel_px), 2.0 * needed.x() + 3.0 * gap);
  add_legend(footer, scene, drawing.set_aside(), text, line_px);

  const double top = 3.0 * text;
  Canvas canvas(static_cast<int>(std::ceil(2.0 * needed.x() + 3.0 * gap)),
                static_cast<int>(std::ceil(top + needed.y() + gap + footer.height())), kPaper);
  for (std::size_t i = 0; i < 2; ++i) {
    const bool is_after = i == 1;
    const Point corner{gap + (is_after ? needed.x() + gap : 0.0), top};
    const PlanePanel panel(corner, needed.x(), needed.y(), boxes[i], scales[i]);
    canvas.text({corner.x, 1.9 * text}, is_after ? scene.after_title : scene.before_title,
                1.15 * text, kInk, 0.0, FontWeight::kBold);
    canvas.fill_rectangle(corner, needed.x(), needed.y(), hex_colour(0xf8fafc));
    canvas.clip(corner, needed.x(), needed.y());
    drawing.draw(canvas, panel, is_after ? after : scene.before, is_after);
    canvas.unclip();
    panel.scale_bar(canvas, text, kInk, kPaper);
    panel.frame(canvas, kHairline);
  }
  footer.draw(canvas, top + needed.y() + 0.5 * gap);
  return canvas.image();
}

}  // namespace loopstone
