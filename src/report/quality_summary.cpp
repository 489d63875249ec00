#include "report/quality_summary.hpp"

#include <fmt/format.h>

#include <cmath>

#include "loopstone/report/map_picture.hpp"
#include "report/html_parts.hpp"
#include "report/map_view.hpp"
#include "report/text.hpp"

namespace loopstone {
namespace {

/// A figure that nothing was measured for is null, not 0.
nlohmann::ordered_json known(bool is_known, double value) {
  return is_known ? nlohmann::ordered_json(value) : nlohmann::ordered_json(nullptr);
}

std::string css_class(Verdict verdict) {
  switch (verdict) {
    case Verdict::kGood:
      return "tracking";
    case Verdict::kDoubtful:
      return "doubtful";
    case Verdict::kBad:
      return "lost";
    case Verdict::kUnknown:
      break;
  }
  return "unknown";
}

std::string badge(Verdict verdict) {
  return fmt::format("<span class=\"state {}\">{}</span>", css_class(verdict),
                     verdict == Verdict::kUnknown ? "not known" : to_string(verdict));
}

/// The sentence without the verdict that it begins with: the badge beside it says that.
std::string reason_of(const MapVerdict& verdict) {
  const auto colon = verdict.sentence.find(": ");
  std::string reason =
      colon == std::string::npos ? verdict.sentence : verdict.sentence.substr(colon + 2);
  if (!reason.empty() && reason.front() >= 'a' && reason.front() <= 'z')
    reason.front() = static_cast<char>(reason.front() - 'a' + 'A');
  return reason;
}

std::string value_of(const QualityMeasure& measure) {
  if (measure.verdict == Verdict::kUnknown) return "–";
  if (measure.name == "sensor_faults") return fmt::format("{:.0f}", measure.value);
  if (measure.name.ends_with("_m") && measure.value >= 1.0) return readable(measure.value) + " m";
  if (measure.name.ends_with("_m")) return readable(100.0 * measure.value) + " cm";
  if (measure.name == "entropy_gain_nats") return fmt::format("{:+.2f} nats", measure.value);
  if (measure.name == "reduced_chi2") return fmt::format("{:.2f}", measure.value);
  return fmt::format("{:.1f} %", 100.0 * measure.value);
}

nlohmann::ordered_json contradictions_json(const MapResult& result) {
  auto list = nlohmann::ordered_json::array();
  for (const VisitContradiction& one : result.quality.contradictions) {
    list.push_back({{"x_m", one.centre().x()},
                    {"y_m", one.centre().y()},
                    {"width_m", one.high.x() - one.low.x()},
                    {"height_m", one.high.y() - one.low.y()},
                    {"first_from_s", one.first_from.seconds()},
                    {"first_to_s", one.first_to.seconds()},
                    {"second_from_s", one.second_from.seconds()},
                    {"second_to_s", one.second_to.seconds()},
                    {"wall_m", one.wall_m},
                    {"share", one.share},
                    {"apart_m", one.apart_m}});
  }
  return list;
}

/// What loose parts and open stretches have alike.
template <typename Part>
nlohmann::ordered_json part_json(const Part& part) {
  return {{"from_s", part.from.seconds()}, {"to_s", part.to.seconds()}, {"path_m", part.path_m},
          {"x_m", part.where.x()},         {"y_m", part.where.y()},     {"sigma_m", part.sigma_m}};
}

nlohmann::ordered_json loose_json(const GraphTies& ties) {
  auto list = nlohmann::ordered_json::array();
  for (const LoosePart& part : ties.loose) {
    list.push_back(part_json(part));
    list.back()["sigma_rad"] = part.sigma_rad;
    list.back()["closures"] = part.closures;
  }
  return list;
}

nlohmann::ordered_json open_json(const GraphTies& ties) {
  auto list = nlohmann::ordered_json::array();
  for (const OpenStretch& stretch : ties.open) list.push_back(part_json(stretch));
  return list;
}

/// Which part of quality.png is the map, above its legend, and where that lies.
nlohmann::ordered_json picture_json(const MapResult& result) {
  if (result.verdict.measures.empty()) return nullptr;
  const MapView view =
      view_of(result.map, result.trajectory, kQualitySidePx, MapPictureOptions{}.most_side_px);
  const double pixels_per_metre = view.pixels_per_metre();
  const Point origin = view.pixel_of(Eigen::Vector2d::Zero());
  return {{"x_m", -origin.x / pixels_per_metre},
          {"y_m", (origin.y - view.height_px) / pixels_per_metre},
          {"resolution_m", 1.0 / pixels_per_metre},
          {"width_px", view.width_px},
          {"height_px", view.height_px}};
}

}  // namespace

nlohmann::ordered_json quality_json(const MapResult& result) {
  const MapQuality& q = result.quality;
  const GraphQuality& g = result.graph_quality;
  auto measures = nlohmann::ordered_json::object();
  for (const QualityMeasure& measure : result.verdict.measures) {
    measures[measure.name] = {{"value", known(measure.verdict != Verdict::kUnknown, measure.value)},
                              {"verdict", to_string(measure.verdict)},
                              {"sentence", measure.sentence}};
  }
  const bool compared = q.walls_compared > 0;
  return {
      {"verdict", to_string(result.verdict.overall)},
      {"sentence", result.verdict.sentence},
      {"measures", measures},
      {"scans_judged", q.scans},
      {"stretches", q.visits},
      {"places", q.places.size()},
      {"places_revisited", q.places_revisited()},
      {"places_in_trouble", q.places_in_trouble()},
      {"sensor_noise_m", known(q.returns > 0, q.sensor_noise_m)},
      {"local_spread_m", known(q.returns > 0, q.local_spread_m)},
      {"walls_compared", q.walls_compared},
      {"wall_offset_m", known(compared, q.wall_offset_m)},
      {"wall_offset_worst_m", known(compared, q.wall_offset_worst_m)},
      {"doubled_share", known(compared, q.doubled_share)},
      {"entropy_nats", known(q.entropy_points > 0, q.entropy_nats)},
      {"beams_tested", q.beams_tested},
      {"held_out_returns", q.held_out_returns},
      {"graph_loops", g.loops},
      {"closures_revoked", g.closures_revoked},
      {"contradictions", contradictions_json(result)},
      {"agreeing_visits", q.agreeing.size()},
      {"variance_factor", result.ties.variance_factor},
      {"possible_error_m", result.ties.possible.m},
      {"possible_error_rad", result.ties.possible.rad},
      {"loose_parts", loose_json(result.ties)},
      {"open_stretches", open_json(result.ties)},
      {"certificate", g.certificate ? nlohmann::ordered_json(to_string(g.certificate->status))
                                    : nlohmann::ordered_json(nullptr)},
      {"picture", picture_json(result)},
  };
}

std::string html_quality(const MapResult& result, std::string_view quality_png) {
  if (result.verdict.measures.empty()) return {};
  const MapQuality& q = result.quality;
  std::string html = "<h2>How good is this map?</h2>\n<p class=\"verdict\">" +
                     badge(result.verdict.overall) + " " + escape_html(reason_of(result.verdict)) +
                     "</p>\n<p class=\"soft\">Nobody knows the truth here; what can be checked is "
                     "whether the visits to the same places agree. ";
  html += fmt::format(
      "{} of {} with walls were seen in two visits or more. What was seen once is neither good nor "
      "bad, and a map that is wrong everywhere alike can't be told from a right one.</p>\n",
      with_thousands(static_cast<std::int64_t>(q.places_revisited())),
      count_of(static_cast<std::int64_t>(q.places.size()), "place", "places"));
  html +=
      "<div class=\"scroll\"><table class=\"list\"><thead><tr><th></th><th>measure</th><th "
      "class=\"n\">value</th><th>what it says</th></tr></thead><tbody>\n";
  for (const QualityMeasure& measure : result.verdict.measures) {
    html += fmt::format("<tr><td>{}</td><td>{}</td><td class=\"n\">{}</td><td>{}</td></tr>\n",
                        badge(measure.verdict), escape_html(measure.title), value_of(measure),
                        escape_html(measure.sentence));
  }
  html += "</tbody></table></div>\n";
  if (!quality_png.empty()) {
    html += html_figure(
        html_picture(quality_png, "map", "Where visits to the same place agree and where not"),
        "Where: squares of 50 cm that hold walls. Blue: the visits put the wall in the same place; "
        "amber: 5 to 10 cm apart; pink: farther apart, or beams went through it (crosses). "
        "Frames: where two visits contradict each other over metres of wall.");
  }
  return html;
}

}  // namespace loopstone
