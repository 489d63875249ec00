#include "report/landmark_summary.hpp"

#include <fmt/format.h>

#include "loopstone/report/landmark_figures.hpp"
#include "report/html_parts.hpp"
#include "report/text.hpp"

namespace loopstone {

LandmarkFigures figures_of(const LandmarkMapping& mapping) {
  LandmarkFigures figures{.count = static_cast<std::int64_t>(mapping.landmarks.size())};
  for (const FoundLandmark& landmark : mapping.landmarks) {
    const auto count = static_cast<double>(figures.count);
    figures.sigma_mean_m += landmark.sigma_m / count;
    figures.sightings_mean += landmark.sightings / count;
    if (landmark.radius_m > 0.0) ++figures.round;
  }
  return figures;
}

nlohmann::ordered_json landmarks_json(const LandmarkMapping& mapping) {
  const LandmarkFigures of = figures_of(mapping);
  const LandmarkMappingFigures& f = mapping.figures;
  return {{"count", of.count},
          {"round", of.round},
          {"sigma_mean_m", of.sigma_mean_m},
          {"sightings_mean", of.sightings_mean},
          {"observations", f.observations},
          {"observations_used", f.used},
          {"tracks", f.tracks},
          {"tracks_recognised", f.merged},
          {"left_out_seldom_seen", f.too_few},
          {"left_out_moving", f.moving},
          {"left_out_seen_through", f.see_through},
          {"reduced_chi2", f.chi2}};
}

std::string html_landmarks(const LandmarkMapping& mapping) {
  const LandmarkFigures of = figures_of(mapping);
  const LandmarkMappingFigures& f = mapping.figures;
  std::string html = "<h2>Landmarks</h2>\n<div class=\"figures\">\n";
  html += html_key_table("Found",
                         {{"landmarks", with_thousands(of.count)},
                          {"of them round", with_thousands(of.round)},
                          {"σ among themselves, mean", readable(1e3 * of.sigma_mean_m) + " mm"},
                          {"sightings of each, mean", readable(of.sightings_mean)},
                          {"χ² a degree of freedom", readable(f.chi2)}});
  html += html_key_table("Seen", {{"bright things, or sightings", with_thousands(f.observations)},
                                  {"of them of a landmark", with_thousands(f.used)},
                                  {"followed", with_thousands(f.tracks)},
                                  {"recognised as one known", with_thousands(f.merged)},
                                  {"seen too seldom", with_thousands(f.too_few)},
                                  {"did not stay in place", with_thousands(f.moving)},
                                  {"seen through", with_thousands(f.see_through)}});
  return html + "</div>\n";
}

}  // namespace loopstone
