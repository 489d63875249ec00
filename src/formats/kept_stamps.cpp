#include "formats/kept_stamps.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>

namespace loopstone {
namespace {

// Stamps beyond 145 years are rubbish; below, their differences fit in 64 bits, too.
constexpr double kMostSeconds = 4.6e9;

std::string refusal(double seconds, std::optional<Stamp> kept_before) {
  if (!std::isfinite(seconds)) return "the stamp is not finite";
  char text[120];
  if (!(std::abs(seconds) < kMostSeconds)) {
    std::snprintf(text, sizeof text, "the stamp %g s is impossible", seconds);
  } else if (!kept_before || seconds > kept_before->seconds()) {
    std::snprintf(text, sizeof text, "the stamp lies ahead of those after it");
  } else if (Stamp::from_seconds(seconds) == *kept_before) {
    std::snprintf(text, sizeof text, "a record with the same stamp came before");
  } else {
    std::snprintf(text, sizeof text, "the stamp goes back by %.6f s",
                  kept_before->seconds() - seconds);
  }
  return text;
}

}  // namespace

KeptStamps keep_increasing(std::span<const double> seconds) {
  std::vector<std::int64_t> tails;  // tails[k]: end of the best increasing run of length k + 1
  std::vector<std::int64_t> previous(seconds.size(), -1);
  const auto stamp_at = [&](std::int64_t index) {
    return Stamp::from_seconds(seconds[static_cast<std::size_t>(index)]);
  };
  for (std::size_t i = 0; i < seconds.size(); ++i) {
    if (!(std::abs(seconds[i]) < kMostSeconds)) continue;
    const Stamp stamp = Stamp::from_seconds(seconds[i]);
    const auto place =
        std::lower_bound(tails.begin(), tails.end(), stamp,
                         [&](std::int64_t index, Stamp value) { return stamp_at(index) < value; });
    if (place != tails.begin()) previous[i] = *(place - 1);
    const auto index = static_cast<std::int64_t>(i);
    if (place == tails.end()) {
      tails.push_back(index);
    } else if (stamp_at(*place) != stamp) {  // of equal stamps the first record stays
      *place = index;
    }
  }

  KeptStamps kept;
  kept.indices.resize(tails.size());
  std::int64_t index = tails.empty() ? -1 : tails.back();
  for (auto place = kept.indices.rbegin(); place != kept.indices.rend(); ++place) {
    *place = index;
    index = previous[static_cast<std::size_t>(index)];
  }
  std::optional<Stamp> last;
  std::size_t next = 0;
  for (std::size_t i = 0; i < seconds.size(); ++i) {
    if (next < kept.indices.size() && kept.indices[next] == static_cast<std::int64_t>(i)) {
      last = Stamp::from_seconds(seconds[i]);
      kept.stamps.push_back(*last);
      ++next;
    } else {
      kept.refused.push_back({static_cast<std::int64_t>(i), refusal(seconds[i], last), {}});
    }
  }
  return kept;
}

}  // namespace loopstone
