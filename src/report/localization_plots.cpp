#include "report/localization_plots.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "loopstone/geometry/angle.hpp"
#include "report/html_parts.hpp"
#include "report/state_style.hpp"
#include "report/svg_plot.hpp"

namespace loopstone {
namespace {

using Estimate = LocalizationEstimate;

/// A plot is not wider than this many pixels.
constexpr std::size_t kMostSpans = 800;

/// Estimates that stand for one point of a plot.
struct TimeSpan {
  std::size_t first = 0;
  std::size_t end = 0;
  double time_s = 0.0;  ///< of the middle
};

class TimePlots {
 public:
  explicit TimePlots(const LocalizationResult& result)
      : start_(result.start), estimates_(result.estimates) {
    const std::size_t count = estimates_.size();
    const std::size_t spans = std::min(count, kMostSpans);
    for (std::size_t k = 0; k < spans; ++k) {
      TimeSpan span{k * count / spans, (k + 1) * count / spans};
      span.time_s = 0.5 * (time_s(span.first) + time_s(span.end - 1));
      spans_.push_back(span);
    }
    find_bands();
  }

  /// \param reduce  makes one value of a span's first and last
  template <typename ValueOf, typename Reduce>
  [[nodiscard]] PlotCurve curve(const char* label, const char* css_class, const ValueOf& value_of,
                                const Reduce& reduce) const {
    PlotCurve curve{label, css_class};
    for (const TimeSpan& span : spans_) {
      double value = value_of(estimates_[span.first]);
      for (std::size_t i = span.first + 1; i < span.end; ++i)
        value = reduce(value, value_of(estimates_[i]));
      curve.x.push_back(span.time_s);
      curve.y.push_back(value);
    }
    return curve;
  }
  template <typename ValueOf>
  [[nodiscard]] PlotCurve least(const char* label, const char* css_class,
                                const ValueOf& value_of) const {
    return curve(label, css_class, value_of, [](double a, double b) { return std::min(a, b); });
  }
  template <typename ValueOf>
  [[nodiscard]] PlotCurve most(const char* label, const char* css_class,
                               const ValueOf& value_of) const {
    return curve(label, css_class, value_of, [](double a, double b) { return std::max(a, b); });
  }

  [[nodiscard]] std::string figure(const char* y_label, std::vector<PlotCurve> curves,
                                   std::vector<double> y_shown, const char* caption) const {
    PlotSpec spec{.x_label = "time [s]", .y_label = y_label};
    spec.curves = std::move(curves);
    spec.bands = bands_;
    spec.y_shown = std::move(y_shown);
    spec.height_px = 200.0;
    return html_figure(svg_plot(std::move(spec)), caption);
  }

 private:
  [[nodiscard]] double time_s(std::size_t i) const {
    return (estimates_[i].stamp - start_).seconds();
  }
  /// The worst state of each span: a short loss must not vanish.
  void find_bands() {
    for (std::size_t k = 0; k < spans_.size(); ++k) {
      LocalizationState worst = LocalizationState::kTracking;
      for (std::size_t i = spans_[k].first; i < spans_[k].end; ++i)
        worst = std::max(worst, estimates_[i].state);
      const double begin_s = time_s(spans_[k].first);
      const double end_s =
          k + 1 < spans_.size() ? time_s(spans_[k + 1].first) : time_s(spans_[k].end - 1);
      const std::string css_class = state_css_class(worst);
      if (!bands_.empty() && bands_.back().css_class == css_class) {
        bands_.back().x_high = end_s;
      } else {
        bands_.push_back({css_class, begin_s, end_s});
      }
    }
  }

  Stamp start_;
  const std::vector<Estimate>& estimates_;
  std::vector<TimeSpan> spans_{};
  std::vector<PlotBand> bands_{};
};

double sigma_xy_m(const Estimate& e) {
  return std::sqrt(0.5 * (e.covariance(0, 0) + e.covariance(1, 1)));
}

}  // namespace

std::string localization_plots(const LocalizationResult& result) {
  if (result.estimates.size() < 2) return {};
  const TimePlots plots(result);
  std::string html = plots.figure(
      "probability",
      {plots.least("probability", "a", [](const Estimate& e) { return e.probability; })},
      {0.0, 1.0}, "Probability that the pose is within 0.2 m and 5° of the truth.");
  html += plots.figure(
      "share of the beams",
      {plots.least("explained", "a", [](const Estimate& e) { return e.evidence.explained; }),
       plots.most("through walls", "b", [](const Estimate& e) { return e.evidence.violations; }),
       plots.most("unexpected", "c", [](const Estimate& e) { return e.evidence.unexpected; })},
      {0.0, 1.0},
      "What the scans say: explained, returns that lie on a wall of the map; through walls, beams "
      "that passed where the map has one; unexpected, beams that ended well before any wall, as at "
      "people and new things.");
  html += plots.figure(
      "position [m]",
      {plots.most("spread of the particles", "a",
                  [](const Estimate& e) { return e.evidence.spread_m; }),
       plots.most("standard deviation of the pose", "b", sigma_xy_m)},
      {0.0}, "Spread of the best hypothesis' particles, and what the estimate's covariance says.");
  html += plots.figure(
      "heading [°]",
      {plots.most("spread of the particles", "a",
                  [](const Estimate& e) { return degrees(e.evidence.spread_rad); }),
       plots.most("standard deviation of the pose", "b",
                  [](const Estimate& e) { return degrees(std::sqrt(e.covariance(2, 2))); })},
      {0.0}, "The same of the heading.");
  html += plots.figure(
      "places", {plots.most("places", "a", [](const Estimate& e) { return double(e.hypotheses); })},
      {0.0, 2.0}, "Places where the robot may be; more than one: the map looks alike there.");
  html += plots.figure(
      "innovation",
      {plots.most("innovation", "a", [](const Estimate& e) { return e.evidence.innovation; })},
      {0.0, 1.0},
      "Registration against prediction, squared Mahalanobis distance by degrees of freedom, mean "
      "of the last ones: about 1 when the noise is as assumed.");
  return html;
}

}  // namespace loopstone
