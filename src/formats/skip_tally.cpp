#include "formats/skip_tally.hpp"

#include <algorithm>
#include <cstddef>
#include <string_view>

namespace loopstone {
namespace {

constexpr std::size_t kMostReasons = 32;

bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// "the stamp goes back by # s": what reasons of the same kind have in common.
std::string pattern_of(std::string_view reason) {
  std::string pattern;
  for (std::size_t i = 0; i < reason.size(); ++i) {
    if (reason[i] == '\'') {
      const std::size_t end = reason.find('\'', i + 1);
      i = end == reason.npos ? reason.size() : end;
      pattern += '#';
    } else if (is_digit(reason[i])) {
      while (i + 1 < reason.size() && (is_digit(reason[i + 1]) || reason[i + 1] == '.')) ++i;
      pattern += '#';
    } else {
      pattern += reason[i];
    }
  }
  return pattern;
}

}  // namespace

void SkipTally::add(const LogProblem& problem) {
  ++skipped_.records;
  if (problem.is_scan) ++skipped_.scans;
  std::string pattern = pattern_of(problem.reason);
  const auto known = std::find(patterns_.begin(), patterns_.end(), pattern);
  if (known != patterns_.end()) {
    ++skipped_.reasons[static_cast<std::size_t>(known - patterns_.begin())].records;
  } else if (patterns_.size() < kMostReasons) {
    patterns_.push_back(std::move(pattern));
    skipped_.reasons.push_back({problem.reason, problem.location, 1});
  }
}

}  // namespace loopstone
