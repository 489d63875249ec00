#include "loopstone/slam/map_verdict.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "loopstone/slam/map_result.hpp"
#include "slam/local_verdicts.hpp"
#include "slam/map_verdict_numbers.hpp"
#include "slam/run_clock.hpp"
#include "slam/sensor_faults.hpp"

namespace loopstone {
namespace {

/// What the limits mean and how they were checked: docs/quality.md.
Verdict against(const VerdictLimits& limits, double value) {
  if (!(value <= limits.bad)) return Verdict::kBad;
  return value <= limits.doubtful ? Verdict::kGood : Verdict::kDoubtful;
}

std::string number(double value, int digits) {
  return std::isfinite(value) ? fmt::format("{:.{}f}", value, digits) : "n/a";
}
std::string centimetres(double metres) { return number(100.0 * metres, 1) + " cm"; }
std::string percent(double share) { return number(100.0 * share, share < 0.0995 ? 1 : 0) + " %"; }

constexpr const char* kSeenOnce =
    "No place was seen in two visits, so there is nothing to compare.";

constexpr const char* kNoTravel = "The robot did not travel.";

/// With nothing to judge by.
QualityMeasure unknown(QualityMeasure measure, const char* why) {
  measure.sentence = why;
  return measure;
}

QualityMeasure wall_thickness(const MapQuality& q) {
  QualityMeasure measure{
      .name = "wall_thickness_m", .title = "Wall thickness", .value = q.wall_thickness_m};
  if (q.walls_compared < kMapVerdict.least_walls) return unknown(std::move(measure), kSeenOnce);
  measure.verdict = against(kMapVerdict.doubled_share, q.doubled_share);
  measure.sentence = "The same wall lies " + centimetres(q.wall_offset_m) +
                     " apart in two visits (5 of 100: more than " +
                     centimetres(q.wall_offset_worst_m) + "); the scanner's own noise is " +
                     centimetres(q.sensor_noise_m) + ". " + percent(q.doubled_share) +
                     " of the walls are drawn twice, more than " +
                     number(100.0 * kMapQuality.doubled_m, 0) + " cm apart.";
  return measure;
}

QualityMeasure entropy(const MapQuality& q) {
  QualityMeasure measure{
      .name = "entropy_gain_nats", .title = "Mean map entropy", .value = q.entropy_gain_nats};
  if (q.entropy_points < kMapVerdict.least_entropy_points)
    return unknown(std::move(measure), kSeenOnce);
  measure.verdict = against(kMapVerdict.entropy_gain_nats, q.entropy_gain_nats);
  measure.sentence = "The mean map entropy is " + number(q.entropy_nats, 2) + " nats, " +
                     number(q.entropy_gain_nats, 2) +
                     " more than that of single stretches of travel: the map is " +
                     number(std::exp(q.entropy_gain_nats), 1) + " times as blurred as they are.";
  return measure;
}

QualityMeasure violations(const MapQuality& q) {
  QualityMeasure measure{
      .name = "free_space_violations", .title = "Free-space violations", .value = q.crossed_share};
  if (q.beams_tested < kMapVerdict.least_beams) return unknown(std::move(measure), kSeenOnce);
  measure.verdict = against(kMapVerdict.crossed_share, q.crossed_share);
  measure.sentence = percent(q.crossed_share) +
                     " of the beams that met a wall of another visit went through it. What moved "
                     "between the visits (doors, chairs, people) counts as well.";
  return measure;
}

QualityMeasure held_out(const MapQuality& q) {
  QualityMeasure measure{.name = "held_out_agreement",
                         .title = "Agreement of held-out scans",
                         .value = q.held_out_agreement};
  if (q.held_out_returns < kMapVerdict.least_returns) return unknown(std::move(measure), kSeenOnce);
  measure.verdict = against(kMapVerdict.missed_share, 1.0 - q.held_out_agreement);
  measure.sentence = "The other visits foretell " + percent(q.held_out_agreement) +
                     " of the returns of scans that were held out, where they had looked.";
  return measure;
}

QualityMeasure loops(const GraphQuality& g) {
  QualityMeasure measure{
      .name = "reduced_chi2", .title = "Chi-square of the loops", .value = g.reduced_chi2};
  if (g.loops < 1 || g.closures < 1)
    return unknown(std::move(measure),
                   "No loop was closed, so drift was neither measured nor corrected.");
  const double revoked = static_cast<double>(g.closures_revoked) / g.closures;
  measure.verdict = std::max(against(kMapVerdict.reduced_chi2, g.reduced_chi2),
                             against(kMapVerdict.revoked_share, revoked));
  measure.sentence = "The loops close with " + number(g.reduced_chi2, 2) +
                     " times the squared error that the graph's own covariances promise; " +
                     std::to_string(g.closures_revoked) + " of " + std::to_string(g.closures) +
                     " closures contradicted the others and were revoked.";
  return measure;
}

QualityMeasure certified(const GraphQuality& g) {
  QualityMeasure measure{
      .name = "certified_shift_m", .title = "Certified", .value = g.certified_shift_m};
  if (!g.certificate)
    return unknown(std::move(measure),
                   g.loops < 1 ? "Without loops the graph has one solution: nothing to prove."
                               : "The graph is too large to be certified in passing.");
  if (!g.is_proven()) {
    measure.verdict = Verdict::kDoubtful;
    measure.sentence = "It was not proven that the graph's solution is the best one there is (" +
                       std::string(to_string(g.certificate->status)) + ").";
    return measure;
  }
  const bool near = g.certified_shift_m <= kMapVerdict.certified_near_m;
  measure.verdict = near ? Verdict::kGood : Verdict::kDoubtful;
  const std::string best = g.certificate->certified()
                               ? "The graph's best solution is known and proven"
                               : "No solution of the graph is better by more than " +
                                     number(g.certificate->optimality_gap, 2) +
                                     " of chi-square than one that is known, which is proven";
  measure.sentence = best + "; the solver that begins there arrives within " +
                     centimetres(g.certified_shift_m) +
                     " of the one that was found. Surfaces that scans share " +
                     "moved it by another " + centimetres(g.adjusted_shift_m) + " at most.";
  return measure;
}

/// Scans that the laser did not hold stand where odometry says, whatever ties both sides.
bool may_be_off_between(const PathBreak& gap, const Trajectory& path) {
  if ((gap.to - gap.from).seconds() < kMapVerdict.bridged_s) return false;
  const auto& poses = path.poses();
  const auto first = std::ranges::upper_bound(poses, gap.from, {}, &StampedPose2::stamp);
  const auto end = std::ranges::lower_bound(first, poses.end(), gap.to, {}, &StampedPose2::stamp);
  // Two standard deviations, half of which are left in the middle.
  return end - first >= kMapVerdict.bridged_scans &&
         !is_right({.m = gap.bridge_sigma_m(), .rad = std::sqrt(gap.covariance(2, 2))});
}

bool was_in_hands(const PathBreak& gap) {
  return gap.cause == BreakCause::kCarried || gap.cause == BreakCause::kLifted;
}

QualityMeasure breaks(const MapResult& result) {
  QualityMeasure measure{.name = "break_tie_m", .title = "Breaks of the path"};
  if (result.breaks.empty() && !(result.statistics.path_length_m > kMapVerdict.short_travel_m))
    return unknown(std::move(measure), kNoTravel);
  const bool is_map_right = !may_be_wrong(result);
  measure.verdict = Verdict::kGood;
  std::int64_t untied = 0;
  std::int64_t count = 0;
  double between_m = 0.0;
  for (const PathBreak& gap : result.breaks) {
    const bool between = may_be_off_between(gap, result.trajectory);
    if (between) {
      measure.verdict = std::max(measure.verdict, Verdict::kDoubtful);
      between_m = std::max(between_m, gap.bridge_sigma_m());
    }
    if (gap.bridge == BreakBridge::kLaser && !was_in_hands(gap) && !between) continue;
    ++count;
    const bool guessed = gap.bridge == BreakBridge::kNothing && gap.closures == 0;
    // One closure by itself may be wrong. What the bridge loses is in what the whole map may be off
    // by, but for what no key scan follows, and for where somebody may have carried the robot:
    // walls along which that was are seen to agree all the same.
    const bool is_harmless = is_map_right && !gap.ends_log &&
                             gap.bridge == BreakBridge::kOdometry && !gap.may_be_carried();
    const bool tied =
        gap.closures > 1 || is_harmless || gap.bridge_sigma_m() <= kMapVerdict.break_tie_m.doubtful;
    if (!tied) ++untied;
    // Where a robot was carried to, or went far with nothing to tell how, a likeness of places is
    // all that ties the sides, and closures between places that are alike agree with one another.
    const bool is_told = gap.bridge != BreakBridge::kNothing ||
                         (gap.closures > 1 && gap.bridge_sigma_m() <= kMapVerdict.untold_m);
    const bool sure = tied && !was_in_hands(gap) && is_told;
    measure.value = std::max(measure.value, gap.tie_sigma_m);
    Verdict alone = against(kMapVerdict.break_tie_m, gap.tie_sigma_m);
    if (guessed) alone = std::max(alone, Verdict::kDoubtful);
    if (is_harmless) alone = Verdict::kGood;
    measure.verdict =
        std::max({measure.verdict, alone, sure ? Verdict::kGood : Verdict::kDoubtful});
  }
  if (count == 0) {
    measure.sentence = "The laser saw every part of the path join the one before.";
    return measure;
  }
  measure.sentence =
      std::to_string(count) + (count == 1 ? " time" : " times") +
      " the laser lost the path for a while; the sides are tied within " +
      readable_metres(measure.value) + " by odometry or loop closures" +
      (untied > 0 ? ", " + std::to_string(untied) + " of them by nothing that was seen twice."
                  : ".");
  if (between_m > 0.0)
    measure.sentence += " Meanwhile the path may be off by " + readable_metres(between_m) + ".";
  return measure;
}

QualityMeasure sensors(const MapResult& result) {
  // What may be the laser's fault or odometry's. What was not used is not on the map.
  std::vector<std::string> faults = sensor_faults(result);
  for (std::string& fault : unexplained_contradictions(result)) faults.push_back(std::move(fault));
  QualityMeasure measure{.name = "sensor_faults",
                         .title = "Sensors",
                         .verdict = faults.empty() ? Verdict::kGood : Verdict::kDoubtful};
  for (std::string& fault : unused_scans(result)) faults.push_back(std::move(fault));
  measure.value = static_cast<double>(faults.size());
  if (faults.empty() && !(result.statistics.path_length_m > kMapVerdict.short_travel_m)) {
    measure.verdict = Verdict::kUnknown;
    measure.sentence = kNoTravel;
    return measure;
  }
  if (faults.empty()) {
    measure.sentence = "Nothing in the scans or in odometry speaks against the laser.";
    return measure;
  }
  for (const std::string& fault : faults) {
    std::string sentence = fault;
    sentence.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(fault.front())));
    measure.sentence += (measure.sentence.empty() ? "" : " ") + sentence + ".";
  }
  return measure;
}

/// Of the measures that name a place.
bool names_a_place(const QualityMeasure& measure) {
  return measure.name == "contradicted_wall_m" || measure.name == "loose_part_m";
}

std::string overall_sentence(Verdict overall, bool compared,
                             const std::vector<QualityMeasure>& measures) {
  std::string culprits;
  std::string where;
  for (const QualityMeasure& measure : measures) {
    const bool speaks = measure.verdict == overall || measure.verdict == Verdict::kDoubtful;
    if (speaks && where.empty() && names_a_place(measure)) where = " " + measure.sentence;
    if (measure.verdict != overall) continue;
    std::string title = measure.title;
    title.front() = static_cast<char>(std::tolower(static_cast<unsigned char>(title.front())));
    culprits += (culprits.empty() ? "" : ", ") + title;
  }
  switch (overall) {
    case Verdict::kGood: {
      std::string sentence = "Good: wherever places were seen in two visits, the visits agree.";
      for (const QualityMeasure& measure : measures)
        if (measure.said_of_good) sentence += " " + measure.sentence;
      return sentence;
    }
    case Verdict::kDoubtful:
      return "Doubtful: look at " + culprits + "." + where;
    case Verdict::kBad:
      return "Bad: look at " + culprits + "." + where;
    case Verdict::kUnknown:
      break;
  }
  return compared ? "Not known."
                  : "Not known: no place was seen in two visits, so nothing tells how far the map "
                    "drifted.";
}

/// The worst of what is known.
void conclude(MapVerdict& verdict) {
  Verdict worst = Verdict::kUnknown;
  for (const QualityMeasure& measure : verdict.measures) worst = std::max(worst, measure.verdict);
  // That the graph agrees with itself is no evidence about the walls: without two visits nothing is
  // called good.
  const bool compared = verdict.measures[0].verdict != Verdict::kUnknown ||
                        verdict.measures[2].verdict != Verdict::kUnknown;
  verdict.overall = worst == Verdict::kGood && !compared ? Verdict::kUnknown : worst;
  verdict.sentence = overall_sentence(verdict.overall, compared, verdict.measures);
}

}  // namespace

MapVerdict judge_map(const MapResult& result) {
  const MapQuality& quality = result.quality;
  MapVerdict verdict;
  verdict.measures = {wall_thickness(quality),
                      entropy(quality),
                      violations(quality),
                      held_out(quality),
                      judge_contradictions(result),
                      loops(result.graph_quality),
                      certified(result.graph_quality),
                      judge_loose_parts(result),
                      judge_open_stretches(result),
                      breaks(result),
                      sensors(result)};
  conclude(verdict);
  return verdict;
}

void judge_left_out(MapVerdict& verdict, double share) {
  if (verdict.measures.empty()) return;
  QualityMeasure measure{.name = "log_left_out_share",
                         .title = "Left out of the log",
                         .value = share,
                         .verdict = against(kMapVerdict.left_out_share, share)};
  measure.sentence = share > 0.0
                         ? percent(share) + " of the log could not be used, as its warnings say."
                         : "All of the log was used.";
  verdict.measures.push_back(std::move(measure));
  conclude(verdict);
}

}  // namespace loopstone
