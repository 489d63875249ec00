#include "parse_pose.hpp"

#include <algorithm>
#include <cmath>

#include "loopstone/base/error.hpp"
#include "loopstone/geometry/angle.hpp"

namespace loopstone::app {

std::vector<double> parse_numbers(const std::string& flag, const std::string& text) {
  std::vector<double> numbers;
  std::size_t begin = 0;
  while (begin <= text.size()) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    const std::string word = text.substr(begin, end - begin);
    std::size_t used = 0;
    try {
      numbers.push_back(std::stod(word, &used));
    } catch (const std::exception&) {
      used = 0;
    }
    if (used == 0 || used != word.size() || !std::isfinite(numbers.back())) {
      throw UsageError(flag + " " + text + ": '" + word + "' is no number");
    }
    begin = end + 1;
  }
  return numbers;
}

Pose2 parse_pose2(const std::string& flag, const std::string& text) {
  const std::vector<double> v = parse_numbers(flag, text);
  if (v.size() != 3) throw UsageError(flag + " " + text + ": must be X,Y,YAW [m, m, rad]");
  return {v[0], v[1], wrap_angle(v[2])};
}

}  // namespace loopstone::app
