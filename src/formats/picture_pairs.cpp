#include "formats/picture_pairs.hpp"

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <map>
#include <tuple>

#include "loopstone/base/median.hpp"

namespace loopstone {
namespace {

constexpr Duration kAlwaysPaired{50'000'000};
constexpr Duration kNeverPaired{250'000'000};
/// Colour pictures on either side of a depth picture that may become its partner: bounds the work
/// when stamps crowd.
constexpr std::size_t kCandidates = 4;

/// The pairs made so far: which colour picture each depth picture has.
class Pairs {
 public:
  /// Takes the pair unless either picture has a partner or it would cross another pair. Streams of
  /// one camera pass each other in order: pairs that cross would mean that one of the clocks ran
  /// backwards.
  void take_if_free(std::size_t depth, std::size_t colour) {
    const auto after = colour_of_.lower_bound(depth);
    if (after != colour_of_.end() && (after->first == depth || after->second <= colour)) return;
    if (after != colour_of_.begin() && std::prev(after)->second >= colour) return;
    colour_of_.emplace_hint(after, depth, colour);
  }
  [[nodiscard]] const std::map<std::size_t, std::size_t>& colour_of() const { return colour_of_; }

 private:
  std::map<std::size_t, std::size_t> colour_of_;
};

Duration median_period(std::span<const Stamp> stamps) {
  std::vector<Duration> periods;
  for (std::size_t i = 1; i < stamps.size(); ++i) periods.push_back(stamps[i] - stamps[i - 1]);
  return median_of(periods);
}

struct Candidate {
  Duration offset;
  std::size_t depth;
  std::size_t colour;
};

std::vector<Candidate> candidates_of(std::span<const Stamp> depth, std::span<const Stamp> colour,
                                     Duration longest_offset) {
  std::vector<Candidate> candidates;
  std::size_t after = 0;  // the first colour picture that is not before the depth picture
  for (std::size_t i = 0; i < depth.size(); ++i) {
    while (after < colour.size() && colour[after] < depth[i]) ++after;
    const std::size_t first = after < kCandidates ? 0 : after - kCandidates;
    const std::size_t last = std::min(colour.size(), after + kCandidates);
    for (std::size_t j = first; j < last; ++j) {
      const Duration offset = colour[j] < depth[i] ? depth[i] - colour[j] : colour[j] - depth[i];
      if (offset <= longest_offset) candidates.push_back({offset, i, j});
    }
  }
  std::sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
    return std::tie(a.offset.nanoseconds, a.depth, a.colour) <
           std::tie(b.offset.nanoseconds, b.depth, b.colour);
  });
  return candidates;
}

}  // namespace

Duration longest_pair_offset(std::span<const Stamp> depth, std::span<const Stamp> colour) {
  const Duration slower = std::max(median_period(depth), median_period(colour));
  return std::clamp(Duration{slower.nanoseconds / 2}, kAlwaysPaired, kNeverPaired);
}

std::vector<PicturePair> pair_pictures(std::span<const Stamp> depth, std::span<const Stamp> colour,
                                       Duration longest_offset) {
  Pairs found;
  for (const Candidate& candidate : candidates_of(depth, colour, longest_offset)) {
    found.take_if_free(candidate.depth, candidate.colour);
  }
  std::vector<PicturePair> pairs(depth.size());
  for (std::size_t i = 0; i < depth.size(); ++i) pairs[i].depth = i;
  std::vector<bool> is_taken(colour.size(), false);
  for (const auto& [depth_at, colour_at] : found.colour_of()) {
    pairs[depth_at].colour = colour_at;
    is_taken[colour_at] = true;
  }
  for (std::size_t j = 0; j < colour.size(); ++j) {
    if (!is_taken[j]) pairs.push_back({std::nullopt, j});
  }
  const auto stamp = [&](const PicturePair& pair) {
    return pair.depth ? depth[*pair.depth] : colour[*pair.colour];
  };
  std::stable_sort(pairs.begin(), pairs.end(),
                   [&](const PicturePair& a, const PicturePair& b) { return stamp(a) < stamp(b); });
  return pairs;
}

}  // namespace loopstone
