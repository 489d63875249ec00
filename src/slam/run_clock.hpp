#pragma once

#include <fmt/format.h>

#include <string>

#include "loopstone/base/stamp.hpp"

namespace loopstone {

/// Times as warnings tell them: seconds since the first scan.
class RunClock {
 public:
  explicit RunClock(Stamp start) : start_(start) {}
  [[nodiscard]] std::string span(Stamp from, Stamp to) const {
    return fmt::format("from {:.1f} to {:.1f} s", (from - start_).seconds(),
                       (to - start_).seconds());
  }

  [[nodiscard]] std::string to_the_end(Stamp from) const {
    return fmt::format("from {:.1f} s to the end", (from - start_).seconds());
  }

 private:
  Stamp start_;
};

[[nodiscard]] inline std::string readable_metres(double value) {
  return value < 0.995 ? fmt::format("{:.0f} cm", 100.0 * value) : fmt::format("{:.1f} m", value);
}

}  // namespace loopstone
