#include "slam/break_warnings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <optional>

#include "slam/run_clock.hpp"

namespace loopstone {

namespace {

/// So many are told one by one; of the rest their number.
constexpr std::size_t kTold = 8;
/// A gap shorter than this, after which the place was recognised, is no news.
constexpr double kBriefS = 2.0;

/// How far the map puts the robot across a break from where odometry does [m].
std::optional<double> carried_m(const PathBreak& gap, const MapResult& result) {
  const auto across = [&](const Trajectory& path) -> std::optional<Pose2> {
    const auto before = path.at(gap.from);
    const auto after = path.at(gap.to);
    if (!before || !after) return {};
    return before->inverse() * *after;
  };
  const auto seen = across(result.trajectory);
  const auto told = across(result.odometry);
  if (!seen || !told) return {};
  return (seen->translation() - told->translation()).norm();
}

std::string what_was_seen(const PathBreak& gap, const MapResult& result, const RunClock& clock) {
  if (gap.cause == BreakCause::kNewDrive) {
    return "another drive begins, anywhere in the building";
  }
  const std::string when = clock.span(gap.from, gap.to);
  if (gap.cause == BreakCause::kCarried) {
    const bool is_found = gap.bridge == BreakBridge::kLaser || gap.closures > 0;
    const auto far_m = is_found ? carried_m(gap, result) : std::nullopt;
    return "the robot was carried " + (far_m ? "by about " + readable_metres(*far_m) + " " : "") +
           when +
           " while no scans came: what the laser sees then is not what it saw where odometry says "
           "that the robot stood";
  }
  if (gap.cause == BreakCause::kLifted) {
    return "the robot moved " + when +
           " while its wheels stood, as one that somebody carries: along what the laser saw it may "
           "have gone farther or less far";
  }
  if (gap.cause == BreakCause::kContradicted) {
    return "the scans " + when +
           " contradict what was seen before: the robot was carried or the laser moved, which "
           "odometry did not notice, or the surroundings changed";
  }
  const std::string gone = gap.odometry_m > 0.0
                               ? "; odometry went " + readable_metres(gap.odometry_m) + " meanwhile"
                               : "";
  return "no usable scans " + (gap.ends_log ? clock.to_the_end(gap.from) : when) + " (a gap of " +
         fmt::format("{:.1f}", (gap.to - gap.from).seconds()) + " s" + gone + ")" +
         (gap.may_be_carried() ? ", and along what it sees then the robot may have been carried"
                               : "");
}

std::string what_bridges(const PathBreak& gap) {
  if (gap.bridge == BreakBridge::kOdometry) {
    return std::string(": odometry alone carried the path ") + (gap.ends_log ? "on" : "across") +
           ", within " + readable_metres(gap.bridge_sigma_m());
  }
  if (gap.cause == BreakCause::kLifted) return "";
  if (gap.cause == BreakCause::kCarried)
    return gap.closures > 0 ? "" : ", and it was not recognised where it was put down";
  return std::string(gap.odometry_m > 0.0 ? ", but odometry was silent for a part of it"
                                          : ": nothing tells how the robot moved") +
         (gap.was_found_in_part()
              ? ", and only a part of what it saw then had been seen: it was put where that fits"
              : ", and it was not found where it had been");
}

std::string what_ties(const PathBreak& gap) {
  if (gap.cause == BreakCause::kNewDrive) {
    if (gap.closures == 0) {
      return ": it was not recognised on the map of what came before, so it is drawn beside it; it "
             "may be of another building, or show too little that is like nothing else";
    }
    return fmt::format(": {} loop closure{} it to what came before, within {}", gap.closures,
                       gap.closures == 1 ? " ties" : "s tie", readable_metres(gap.tie_sigma_m));
  }
  if (gap.bridge == BreakBridge::kLaser) return "; it was found again nearby";
  std::string bridge = what_bridges(gap);
  if (gap.ends_log) return bridge;
  if (gap.closures == 0) {
    return bridge + (gap.bridge == BreakBridge::kOdometry || gap.was_found_in_part()
                         ? "; no loop closure ties both sides"
                         : "; no loop closure ties both sides, so where they lie to one another "
                           "on the map is a guess");
  }
  return bridge + fmt::format("; {} loop closure{} both sides, within {}", gap.closures,
                              gap.closures == 1 ? " ties" : "s tie",
                              readable_metres(gap.tie_sigma_m));
}

void add_breaks(const MapResult& result, const RunClock& clock,
                std::vector<std::string>& warnings) {
  std::vector<const PathBreak*> weakest_first;
  std::vector<const PathBreak*> recognised;
  for (const PathBreak& gap : result.breaks) {
    const bool mere_gap = gap.bridge == BreakBridge::kLaser && gap.cause == BreakCause::kNoScans;
    (mere_gap ? recognised : weakest_first).push_back(&gap);
  }
  std::stable_sort(
      weakest_first.begin(), weakest_first.end(),
      [](const PathBreak* a, const PathBreak* b) { return a->tie_sigma_m > b->tie_sigma_m; });
  const std::size_t left = weakest_first.size() > kTold ? weakest_first.size() - kTold : 0;
  weakest_first.resize(weakest_first.size() - left);
  std::sort(weakest_first.begin(), weakest_first.end());  // in time order again
  for (const PathBreak* gap : weakest_first)
    warnings.push_back(what_was_seen(*gap, result, clock) + what_ties(*gap));
  if (left > 0) warnings.push_back(fmt::format("{} more gaps, tied better than these", left));
  std::erase_if(recognised,
                [](const PathBreak* gap) { return (gap->to - gap->from).seconds() < kBriefS; });
  if (recognised.empty()) return;
  const PathBreak& longest = **std::max_element(
      recognised.begin(), recognised.end(),
      [](const PathBreak* a, const PathBreak* b) { return a->to - a->from < b->to - b->from; });
  warnings.push_back(what_was_seen(longest, result, clock) +
                     (recognised.size() == 1
                          ? std::string(": the place was recognised right after it")
                          : fmt::format(" and {} shorter gaps: the place was recognised right "
                                        "after each of them",
                                        recognised.size() - 1)));
}

}  // namespace

std::vector<std::string> break_warnings(const MapResult& result) {
  std::vector<std::string> warnings;
  if (result.trajectory.empty()) return warnings;
  add_breaks(result, RunClock(result.trajectory.front().stamp), warnings);
  return warnings;
}

}  // namespace loopstone
