#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "plan/plan_numbers.hpp"
#include "plan/wall_line.hpp"

namespace loopstone {

namespace {

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

std::optional<Eigen::Vector2d> meeting_of(const WallLine& a, const WallLine& b) {
  const double sine = cross(a.along, b.along);
  if (std::abs(sine) < std::sin(radians(kPlan.corner_deg))) return std::nullopt;
  return a.at(cross(b.centre - a.centre, b.along) / sine);
}

/// One line's end meets another one's beginning.
struct Meeting {
  double distance_m = 0.0;
  int ends = 0;    ///< its `to` is there
  int begins = 0;  ///< its `from` is there
  Eigen::Vector2d corner{0.0, 0.0};
};

std::vector<Meeting> find_meetings(const std::vector<WallLine>& lines, double corner_m) {
  std::vector<Meeting> meetings;
  const int count = static_cast<int>(lines.size());
  for (int a = 0; a < count; ++a) {
    const WallLine& ends = lines[static_cast<std::size_t>(a)];
    const Eigen::Vector2d end = ends.at(ends.high_m);
    for (int b = 0; b < count; ++b) {
      if (a == b) continue;
      const WallLine& begins = lines[static_cast<std::size_t>(b)];
      const Eigen::Vector2d begin = begins.at(begins.low_m);
      if ((end - begin).norm() > 2.0 * corner_m) continue;
      const auto corner = meeting_of(ends, begins);
      if (!corner) continue;
      const double off = std::max((*corner - end).norm(), (*corner - begin).norm());
      if (off <= corner_m) meetings.push_back({off, a, b, *corner});
    }
  }
  std::stable_sort(meetings.begin(), meetings.end(),
                   [](const Meeting& x, const Meeting& y) { return x.distance_m < y.distance_m; });
  return meetings;
}

/// Where an end that met no other one runs against a line, or a little past it: there it ends.
std::optional<Meeting> wall_before(const std::vector<WallLine>& lines, std::size_t i,
                                   const Eigen::Vector2d& end, double corner_m) {
  std::optional<Meeting> nearest;
  for (std::size_t k = 0; k < lines.size(); ++k) {
    if (k == i) continue;
    const auto corner = meeting_of(lines[i], lines[k]);
    if (!corner) continue;
    const double along = lines[k].along_of(*corner);
    const double off = (*corner - end).norm();
    if (along < lines[k].low_m || along > lines[k].high_m || off > 0.5 * corner_m) continue;
    if (nearest && nearest->distance_m <= off) continue;
    nearest = Meeting{off, static_cast<int>(k), 0, *corner};
  }
  return nearest;
}

void end_at_walls(const std::vector<WallLine>& lines, double corner_m, JoinedSegments& joined) {
  for (std::size_t i = 0; i < lines.size(); ++i) {
    PlanSegment& segment = joined.segments[i];
    for (const bool at_to : {true, false}) {
      if ((at_to ? joined.at_to[i] : joined.at_from[i]).segment >= 0) continue;
      const auto wall = wall_before(lines, i, at_to ? segment.to : segment.from, corner_m);
      const Eigen::Vector2d other = at_to ? segment.from : segment.to;
      if (!wall || (wall->corner - other).norm() < 0.5 * segment.length_m()) continue;
      (at_to ? segment.to : segment.from) = wall->corner;
      (at_to ? segment.sigma_to_m : segment.sigma_from_m) =
          lines[static_cast<std::size_t>(wall->ends)].sigma_across_m;
    }
  }
}

}  // namespace

// Free space is on the left of every segment, so at a corner one of them ends and the other begins;
// walls are walked with the room on the left: concave corners (of a room) turn left.
JoinedSegments join_corners(const std::vector<WallLine>& lines, double corner_m,
                            double end_sigma_m) {
  JoinedSegments joined;
  joined.at_from.resize(lines.size());
  joined.at_to.resize(lines.size());
  for (const WallLine& line : lines) {
    joined.segments.push_back({.from = line.at(line.low_m),
                               .to = line.at(line.high_m),
                               .sigma_across_m = line.sigma_across_m,
                               .sigma_yaw_rad = line.sigma_yaw_rad,
                               .sigma_from_m = end_sigma_m,
                               .sigma_to_m = end_sigma_m,
                               .squared = line.squared});
  }
  for (const Meeting& meeting : find_meetings(lines, corner_m)) {
    const auto a = static_cast<std::size_t>(meeting.ends);
    const auto b = static_cast<std::size_t>(meeting.begins);
    if (joined.at_to[a].segment >= 0 || joined.at_from[b].segment >= 0) continue;
    // A line must not be turned round by its corners.
    if (lines[a].along_of(meeting.corner) <= lines[a].along_of(joined.segments[a].from) ||
        lines[b].along_of(meeting.corner) >= lines[b].along_of(joined.segments[b].to)) {
      continue;
    }
    const double sine = cross(lines[a].along, lines[b].along);
    joined.at_to[a] = {meeting.begins, sine < 0.0};
    joined.at_from[b] = {meeting.ends, sine < 0.0};
    joined.segments[a].to = meeting.corner;
    joined.segments[b].from = meeting.corner;
    joined.segments[a].sigma_to_m = lines[b].sigma_across_m / std::abs(sine);
    joined.segments[b].sigma_from_m = lines[a].sigma_across_m / std::abs(sine);
  }
  end_at_walls(lines, corner_m, joined);
  return joined;
}

}  // namespace loopstone
