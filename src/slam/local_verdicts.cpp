#include "slam/local_verdicts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>

#include "loopstone/geometry/angle.hpp"
#include "slam/map_verdict_numbers.hpp"
#include "slam/run_clock.hpp"

namespace loopstone {
namespace {

/// So many of a kind are told one by one.
constexpr std::size_t kTold = 3;
constexpr const char* kNoTravel = "The robot did not travel.";

RunClock clock_of(const MapResult& result) {
  return RunClock(result.trajectory.empty() ? Stamp{} : result.trajectory.front().stamp);
}

bool travelled(const MapResult& result) {
  return result.statistics.path_length_m > kMapVerdict.short_travel_m;
}

std::string place(const Eigen::Vector2d& at) {
  return fmt::format("x {:.1f}, y {:.1f}", at.x(), at.y());
}

std::vector<VisitContradiction> contradictions_that_count(const MapResult& result) {
  const std::vector<double>& off_m = result.ties.contradictions_m;
  std::vector<VisitContradiction> all;
  for (std::size_t i = 0; i < result.quality.contradictions.size(); ++i) {
    const VisitContradiction& region = result.quality.contradictions[i];
    const bool moved_meanwhile = i < off_m.size() && off_m[i] <= kMapVerdict.contradicted_least_m;
    if (is_contradiction(region) && !moved_meanwhile) all.push_back(region);
  }
  std::stable_sort(all.begin(), all.end(),
                   [](const auto& a, const auto& b) { return a.wall_m > b.wall_m; });
  return all;
}

std::string told(const VisitContradiction& region, const RunClock& clock) {
  const Eigen::Vector2d size = region.high - region.low;
  return fmt::format(
      "about {} ({:.0f} x {:.0f} m) the visits {} and {} contradict each other: {:.0f} m of wall "
      "that one of them saw lie about {} off in the other, {:.0f} % of what both saw",
      place(region.centre()), size.x(), size.y(), clock.span(region.first_from, region.first_to),
      clock.span(region.second_from, region.second_to), region.wall_m,
      readable_metres(region.apart_m), 100.0 * region.share);
}

/// How far a part may be off, all but surely.
template <typename Part>
double most_m(const Part& part) {
  return kMapVerdict.sure_sigmas * part.sigma_m;
}
double most_rad(const LoosePart& part) { return kMapVerdict.sure_sigmas * part.sigma_rad; }
bool is_uncertain(const LoosePart& part) {
  return !is_right({.m = most_m(part), .rad = most_rad(part)});
}
bool is_uncertain(const OpenStretch& stretch) { return !(most_m(stretch) <= kMapVerdict.right_m); }
/// Whether its length is worse known than odometry as a rule knows it.
bool is_poorly_measured(const OpenStretch& stretch) {
  return is_uncertain(stretch) && !(most_m(stretch) <= kMapVerdict.open_share * stretch.path_m);
}

/// Whether parts lose next to nothing, whatever else the map may be off by.
bool are_negligible(std::span<const LoosePart> parts) {
  double sum_m = 0.0;
  double sum_rad = 0.0;
  for (const LoosePart& part : parts) {
    sum_m += most_m(part);
    sum_rad += most_rad(part);
  }
  return sum_m <= kMapVerdict.negligible * kMapVerdict.right_m &&
         sum_rad <= kMapVerdict.negligible * kMapVerdict.right_rad;
}

template <typename Part>
std::string span_of(const Part& part, const RunClock& clock) {
  return fmt::format("{:.0f} m of the path {}, about {},", part.path_m,
                     clock.span(part.from, part.to), place(part.where));
}

std::string by_how_much(const LoosePart& part) {
  return fmt::format("{} and {:.1f} deg (three standard deviations)", readable_metres(most_m(part)),
                     degrees(most_rad(part)));
}

std::string told(const LoosePart& part, const RunClock& clock) {
  return span_of(part, clock) +
         (part.closures == 0 ? " hang on no second visit" : " hang on a single closure") +
         ": what lies beyond may be off by " + by_how_much(part);
}

std::string told(const OpenStretch& stretch, const RunClock& clock) {
  return span_of(stretch, clock) +
         " leave one direction open to the laser: there the map may be too long or too short by " +
         readable_metres(most_m(stretch)) + " (three standard deviations)";
}

/// As a sentence.
std::string sentence_of(std::string words) {
  if (!words.empty() && words.front() >= 'a' && words.front() <= 'z')
    words.front() = static_cast<char>(words.front() - 'a' + 'A');
  return words + ".";
}

template <typename Part>
std::vector<Part> uncertain(std::vector<Part> parts) {
  std::erase_if(parts, [](const Part& part) { return !is_uncertain(part); });
  return parts;
}

template <typename Part>
void tell(const std::vector<Part>& parts, const RunClock& clock,
          std::vector<std::string>& warnings) {
  for (std::size_t i = 0; i < std::min(parts.size(), kTold); ++i)
    warnings.push_back(told(parts[i], clock));
}

}  // namespace

bool is_right(const PossibleError& error) {
  return error.m <= kMapVerdict.right_m && error.rad <= kMapVerdict.right_rad;
}

bool may_be_wrong(const MapResult& result) { return !is_right(result.ties.possible_beside); }

bool is_contradiction(const VisitContradiction& region) {
  return region.share >= kMapVerdict.contradicted_share &&
         region.wall_m > kMapVerdict.contradicted_wall_m.doubtful;
}

QualityMeasure judge_contradictions(const MapResult& result) {
  QualityMeasure measure{.name = "contradicted_wall_m", .title = "Contradictions of visits"};
  if (result.quality.beams_tested < kMapVerdict.least_beams &&
      result.quality.walls_compared < kMapVerdict.least_walls) {
    measure.sentence = "No place was seen in two visits, so there is nothing to compare.";
    return measure;
  }
  measure.verdict = Verdict::kGood;
  const auto regions = contradictions_that_count(result);
  if (regions.empty()) {
    measure.sentence = "Nowhere do two visits contradict each other over more than what moves.";
    return measure;
  }
  measure.value = regions.front().wall_m;
  measure.verdict = regions.front().wall_m > kMapVerdict.contradicted_wall_m.bad
                        ? Verdict::kBad
                        : Verdict::kDoubtful;
  measure.sentence = sentence_of(told(regions.front(), clock_of(result)));
  return measure;
}

QualityMeasure judge_loose_parts(const MapResult& result) {
  QualityMeasure measure{.name = "loose_part_m", .title = "Loose parts"};
  if (!travelled(result)) {
    measure.sentence = kNoTravel;
    return measure;
  }
  const bool compared = result.quality.walls_compared >= kMapVerdict.least_walls ||
                        result.quality.beams_tested >= kMapVerdict.least_beams;
  if (!compared && result.graph_quality.closures == result.graph_quality.closures_revoked) {
    measure.sentence = "All of the path hangs on nothing but itself: no place was seen twice.";
    return measure;
  }
  measure.verdict = Verdict::kGood;
  const auto& loose = result.ties.loose;
  const PossibleError& possible = result.ties.possible_beside;
  measure.value = possible.m;
  if (loose.empty()) {
    measure.sentence = "Two recognised places or more tie every part of the path to the rest.";
  } else if (are_negligible(loose)) {
    measure.sentence =
        "Two recognised places or more tie every part of the path to the rest, but " +
        span_of(loose.front(), clock_of(result)) + " which may be off by " +
        by_how_much(loose.front()) + ".";
  } else if (may_be_wrong(result)) {
    measure.verdict = Verdict::kDoubtful;
    measure.sentence = sentence_of(told(loose.front(), clock_of(result)));
  } else {
    measure.sentence = fmt::format(
        "What hangs on a single closure or on none puts no place off by more than {} and {:.1f} "
        "deg (best aligned, 39 of 40 times){}.",
        readable_metres(possible.m), degrees(possible.rad),
        result.ties.open.empty() ? "" : ", but for how long bare corridors are");
  }
  return measure;
}

QualityMeasure judge_open_stretches(const MapResult& result) {
  const MapStatistics& s = result.statistics;
  QualityMeasure measure{
      .name = "degenerate_travel_share",
      .title = "Degenerate travel",
      // Travel is counted scan by scan, the path from key scan to key scan: the part may come out
      // longer than the whole.
      .value =
          s.path_length_m > 0.0 ? std::min(s.degenerate_travel_m / s.path_length_m, 1.0) : 0.0};
  if (!travelled(result)) {
    measure.sentence = kNoTravel;
    return measure;
  }
  measure.verdict = Verdict::kGood;
  measure.sentence = fmt::format(
      "{:.1f} m of {:.0f} m ran where the laser leaves one direction open (bare corridors); there "
      "the map is as long as odometry says.",
      s.degenerate_travel_m, s.path_length_m);
  const std::vector<OpenStretch>& open = result.ties.open;
  if (open.empty()) return measure;
  measure.sentence += " " + sentence_of(told(open.front(), clock_of(result)));
  if (is_right(result.ties.possible)) return measure;
  measure.said_of_good = is_uncertain(open.front());
  if (std::ranges::any_of(open, is_poorly_measured)) measure.verdict = Verdict::kDoubtful;
  return measure;
}

std::vector<std::string> unexplained_contradictions(const MapResult& result) {
  std::vector<std::string> told_ones;
  for (const OdometryEpisode& episode : result.odometry_episodes) {
    const bool passing =
        episode.over && (episode.to - episode.from).seconds() <= kMapVerdict.passing_s;
    if (episode.fault != OdometryFault::kWrong || !passing) continue;
    told_ones.push_back("odometry and the laser contradict each other " +
                        clock_of(result).span(episode.from, episode.to) +
                        ", and nothing tells which of them was wrong");
  }
  return told_ones;
}

std::vector<std::string> local_warnings(const MapResult& result) {
  std::vector<std::string> warnings;
  const RunClock clock = clock_of(result);
  tell(contradictions_that_count(result), clock, warnings);
  if (judge_loose_parts(result).verdict == Verdict::kDoubtful)
    tell(uncertain(result.ties.loose), clock, warnings);
  tell(uncertain(result.ties.open), clock, warnings);
  return warnings;
}

}  // namespace loopstone
