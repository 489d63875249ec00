#pragma once

#include <string>
#include <vector>

#include "loopstone/devices/scanner.hpp"

namespace loopstone::test {

[[nodiscard]] inline std::vector<LaserScan> scans_of(loopstone::Scanner& scanner, int count) {
  std::vector<LaserScan> scans;
  for (int i = 0; i < count; ++i) scans.push_back(scanner.next().value());
  return scans;
}

[[nodiscard]] inline std::string error_of(auto&& action) {
  try {
    action();
  } catch (const DeviceError& error) {
    return error.what();
  }
  return "nothing was wrong";
}

}  // namespace loopstone::test
