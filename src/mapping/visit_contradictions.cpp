#include "mapping/visit_contradictions.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <numeric>
#include <set>
#include <tuple>

#include "loopstone/base/hypotenuse.hpp"
#include "loopstone/base/median.hpp"

namespace loopstone {
namespace {

/// What two visits say about a place.
struct PlaceOfPair {
  int column = 0;
  int row = 0;
  int first = 0;  ///< the earlier stretch
  int second = 0;
  int agree = 0;
  int contradict = 0;
  float apart_m = 0.0F;  ///< sum over those that contradict

  [[nodiscard]] auto key() const { return std::tie(first, second, row, column); }
  [[nodiscard]] int evidence() const { return agree + contradict; }
  [[nodiscard]] bool contradicts() const {
    return contradict >= kVisitContradictions.least_beams &&
           contradict >= kVisitContradictions.least_share * evidence();
  }
};

int place_of(float coordinate) {
  return static_cast<int>(
      std::floor(static_cast<double>(coordinate) / kVisitContradictions.place_m));
}

PlaceOfPair seen_at(const Eigen::Vector2f& where, int a, int b, float apart_m) {
  const bool far = apart_m >= static_cast<float>(kVisitContradictions.apart_m);
  return {place_of(where.x()), place_of(where.y()), std::min(a, b),      std::max(a, b),
          far ? 0 : 1,         far ? 1 : 0,         far ? apart_m : 0.0F};
}

/// Everything that was seen, one entry a place and pair of stretches, in order.
std::vector<PlaceOfPair> places_of_pairs(std::span<const WallOffset> offsets,
                                         std::span<const BeamMeeting> meetings) {
  std::vector<PlaceOfPair> seen;
  seen.reserve(offsets.size() + meetings.size());
  for (const WallOffset& offset : offsets)
    seen.push_back(seen_at(offset.where, offset.stretch, offset.other_stretch, offset.offset_m));
  for (const BeamMeeting& meeting : meetings)
    seen.push_back(seen_at(meeting.where, meeting.stretch, meeting.wall_stretch, meeting.behind_m));
  std::stable_sort(seen.begin(), seen.end(),
                   [](const auto& a, const auto& b) { return a.key() < b.key(); });
  std::vector<PlaceOfPair> places;
  for (const PlaceOfPair& one : seen) {
    if (places.empty() || places.back().key() != one.key()) {
      places.push_back(one);
      continue;
    }
    places.back().agree += one.agree;
    places.back().contradict += one.contradict;
    places.back().apart_m += one.apart_m;
  }
  return places;
}

/// Places twice as large, and two stretches in one: neighbours of these are neighbours.
using Box = std::array<int, 4>;
int half(int value) { return value >= 0 ? value / 2 : -((1 - value) / 2); }
Box box_of(const PlaceOfPair& place) {
  return {half(place.column), half(place.row), half(place.first), half(place.second)};
}

/// Sets that grow together.
class Sets {
 public:
  explicit Sets(std::size_t count) : parent_(count) {
    std::iota(parent_.begin(), parent_.end(), std::size_t{0});
  }
  std::size_t root(std::size_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(std::size_t a, std::size_t b) {
    a = root(a);
    b = root(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<std::size_t> parent_;
};

/// Boxes that touch make a region: the number of each box.
std::map<Box, std::size_t> regions_of(const std::vector<PlaceOfPair>& places) {
  std::map<Box, std::size_t> numbers;
  for (const PlaceOfPair& place : places) {
    if (place.contradicts()) numbers.try_emplace(box_of(place), numbers.size());
  }
  Sets sets(numbers.size());
  for (const auto& [box, number] : numbers) {
    // Half of the 80 neighbours: the others find this one.
    for (int n = 41; n < 81; ++n) {
      const Box next{box[0] + n % 3 - 1, box[1] + n / 3 % 3 - 1, box[2] + n / 9 % 3 - 1,
                     box[3] + n / 27 - 1};
      const auto found = numbers.find(next);
      if (found != numbers.end()) sets.join(number, found->second);
    }
  }
  for (auto& entry : numbers) entry.second = sets.root(entry.second);
  return numbers;
}

using PlacesOfPairs = std::vector<const PlaceOfPair*>;

/// Of all that the visits of a region say about each other, the share that contradicts: in places.
double share_of(const PlacesOfPairs& region, const std::map<std::pair<int, int>, int>& said) {
  std::set<std::pair<int, int>> pairs;
  for (const PlaceOfPair* place : region) pairs.emplace(half(place->first), half(place->second));
  int all = 0;
  for (const auto& pair : pairs) all += said.at(pair);
  return static_cast<double>(region.size()) / std::max(all, 1);
}

VisitContradiction described(const PlacesOfPairs& region, const StretchTimes& times) {
  VisitContradiction found;
  std::set<std::pair<int, int>> squares;
  std::vector<float> apart_m;
  PlaceOfPair low = *region.front();
  PlaceOfPair high = low;
  for (const PlaceOfPair* place : region) {
    squares.emplace(place->row, place->column);
    apart_m.push_back(place->apart_m / static_cast<float>(place->contradict));
    low.column = std::min(low.column, place->column);
    low.row = std::min(low.row, place->row);
    low.first = std::min(low.first, place->first);
    low.second = std::min(low.second, place->second);
    high.column = std::max(high.column, place->column);
    high.row = std::max(high.row, place->row);
    high.first = std::max(high.first, place->first);
    high.second = std::max(high.second, place->second);
  }
  const double side_m = kVisitContradictions.place_m;
  found.low = side_m * Eigen::Vector2d(low.column, low.row);
  found.high = side_m * Eigen::Vector2d(high.column + 1, high.row + 1);
  const auto at = [&](int stretch) { return times[static_cast<std::size_t>(stretch)]; };
  found.first_from = at(low.first).first;
  found.first_to = at(high.first).second;
  found.second_from = at(low.second).first;
  found.second_to = at(high.second).second;
  found.wall_m = side_m * static_cast<double>(squares.size());
  found.apart_m = static_cast<double>(median_of(apart_m));
  return found;
}

/// What two stretches draw alike and what not.
struct PairOfStretches {
  int agree = 0;  ///< places
  int contradict = 0;
  Eigen::Matrix2f held = Eigen::Matrix2f::Zero();  ///< sum of normal normal^T

  [[nodiscard]] bool ties() const {
    const int all = agree + contradict;
    if (agree * kVisitContradictions.place_m < kVisitContradictions.tie_wall_m ||
        agree < kVisitContradictions.tie_share * all)
      return false;
    const float trace = held.trace();
    const float half_gap =
        0.5F * static_cast<float>(hypotenuse(held(0, 0) - held(1, 1), 2.0F * held(0, 1)));
    return 0.5F * trace - half_gap >= static_cast<float>(kVisitContradictions.tie_held) * trace;
  }
};

}  // namespace

StretchTimes stretch_times(std::span<const JudgedScan> scans) {
  StretchTimes times;
  for (const JudgedScan& scan : scans) {
    const auto stretch = static_cast<std::size_t>(scan.stretch);
    if (times.size() > stretch) {
      times[stretch].second = scan.stamp;
    } else {
      const auto before = times.empty() ? std::pair{scan.stamp, scan.stamp} : times.back();
      times.resize(stretch, before);
      times.emplace_back(scan.stamp, scan.stamp);
    }
  }
  return times;
}

std::vector<VisitContradiction> visit_contradictions(std::span<const WallOffset> offsets,
                                                     std::span<const BeamMeeting> meetings,
                                                     const StretchTimes& times) {
  const std::vector<PlaceOfPair> places = places_of_pairs(offsets, meetings);
  const auto numbers = regions_of(places);
  std::map<std::pair<int, int>, int> said;
  std::map<std::size_t, PlacesOfPairs> regions;
  for (const PlaceOfPair& place : places) {
    if (place.evidence() >= kVisitContradictions.least_beams)
      ++said[{half(place.first), half(place.second)}];
    if (place.contradicts()) regions[numbers.at(box_of(place))].push_back(&place);
  }
  std::vector<VisitContradiction> found;
  for (const auto& [number, region] : regions) {
    VisitContradiction one = described(region, times);
    if (one.wall_m < kVisitContradictions.least_wall_m) continue;
    one.share = share_of(region, said);
    found.push_back(one);
  }
  std::stable_sort(found.begin(), found.end(), [](const auto& a, const auto& b) {
    return a.wall_m * a.share > b.wall_m * b.share;
  });
  if (found.size() > static_cast<std::size_t>(kVisitContradictions.most_regions))
    found.resize(static_cast<std::size_t>(kVisitContradictions.most_regions));
  return found;
}

std::vector<VisitTie> agreeing_visits(std::span<const WallOffset> offsets,
                                      std::span<const BeamMeeting> meetings,
                                      const StretchTimes& times) {
  std::map<std::pair<int, int>, PairOfStretches> pairs;
  const auto far = [](int first, int second) {
    return (second - first) * kMapQuality.stretch_m >= kVisitContradictions.tie_way_m;
  };
  for (const WallOffset& offset : offsets) {
    const auto pair = std::minmax(offset.stretch, offset.other_stretch);
    if (far(pair.first, pair.second)) pairs[pair].held += offset.normal * offset.normal.transpose();
  }
  for (const PlaceOfPair& place : places_of_pairs(offsets, meetings)) {
    if (!far(place.first, place.second)) continue;
    PairOfStretches& pair = pairs[{place.first, place.second}];
    ++(place.contradicts() ? pair.contradict : pair.agree);
  }
  std::vector<VisitTie> ties;
  const auto middle = [&](int stretch) {
    const auto& [from, to] = times[static_cast<std::size_t>(stretch)];
    return Stamp{from.nanoseconds + (to - from).nanoseconds / 2};
  };
  for (const auto& [pair, said] : pairs) {
    if (said.ties()) ties.push_back({middle(pair.first), middle(pair.second)});
  }
  return ties;
}

}  // namespace loopstone
