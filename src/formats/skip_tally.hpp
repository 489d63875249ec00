#pragma once

#include <string>
#include <vector>

#include "loopstone/formats/left_out.hpp"

namespace loopstone {

/// Counts skipped records by their reasons; bounded memory.
class SkipTally {
 public:
  void add(const LogProblem& problem);
  [[nodiscard]] const SkippedRecords& skipped() const { return skipped_; }

 private:
  SkippedRecords skipped_;
  std::vector<std::string> patterns_;  // of skipped_.reasons: figures and quoted words taken out
};

}  // namespace loopstone
