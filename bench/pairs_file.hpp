#pragma once

#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "loopstone/geometry/pose2.hpp"
#include "loopstone/sensor/laser_scan.hpp"

// Pairs of scans on disk, so that every matcher, ours and others', gets the same ones. A file is
// nothing but doubles of this machine: the number of pairs, then for each pair
//   truth x y yaw, guess x y yaw                                             (target_T_source)
//   target: beams, angle_min_rad, angle_increment_rad, range_max_m, ranges
//           (inf: no return, NaN: bad)
//   source: the same
namespace loopstone::bench {

struct StoredPair {
  LaserScan target;
  LaserScan source;
  Pose2 truth;  ///< target_T_source
  Pose2 guess;
};

namespace detail {

inline void append(std::vector<double>& numbers, const LaserScan& scan) {
  numbers.insert(numbers.end(), {static_cast<double>(scan.ranges_m.size()), scan.angle_min_rad,
                                 scan.angle_increment_rad, scan.range_max_m});
  for (const float range : scan.ranges_m) numbers.push_back(range);
}

inline void append(std::vector<double>& numbers, const Pose2& pose) {
  numbers.insert(numbers.end(), {pose.x, pose.y, pose.yaw});
}

class NumberFile {
 public:
  explicit NumberFile(const std::string& path) : path_(path), file_(path, std::ios::binary) {}

  double next() {
    double number = 0.0;
    if (!file_.read(reinterpret_cast<char*>(&number), sizeof number)) {
      throw std::runtime_error(path_ + ": ends early");
    }
    return number;
  }
  Pose2 pose() {
    const double x = next();
    const double y = next();
    return {x, y, next()};
  }
  LaserScan scan() {
    LaserScan scan;
    scan.ranges_m.resize(static_cast<std::size_t>(next()));
    scan.angle_min_rad = next();
    scan.angle_increment_rad = next();
    scan.range_max_m = next();
    for (float& range : scan.ranges_m) range = static_cast<float>(next());
    return scan;
  }

 private:
  std::string path_;
  std::ifstream file_;
};

}  // namespace detail

inline void write_pairs(const std::string& path, const std::vector<StoredPair>& pairs) {
  std::ofstream file(path, std::ios::binary);
  std::vector<double> numbers{static_cast<double>(pairs.size())};
  for (const StoredPair& pair : pairs) {
    detail::append(numbers, pair.truth);
    detail::append(numbers, pair.guess);
    detail::append(numbers, pair.target);
    detail::append(numbers, pair.source);
    file.write(reinterpret_cast<const char*>(numbers.data()),
               static_cast<std::streamsize>(numbers.size() * sizeof(double)));
    numbers.clear();
  }
  if (!file.flush()) throw std::runtime_error(path + ": can't be written");
}

[[nodiscard]] inline std::vector<StoredPair> read_pairs(const std::string& path) {
  detail::NumberFile file(path);
  std::vector<StoredPair> pairs(static_cast<std::size_t>(file.next()));
  for (StoredPair& pair : pairs) {
    pair.truth = file.pose();
    pair.guess = file.pose();
    pair.target = file.scan();
    pair.source = file.scan();
  }
  return pairs;
}

}  // namespace loopstone::bench
