// Writes pairs of scans of a recorded log, with the motion between them from relations or from a
// trajectory:
//   measure_log_pairs FILE LOG relations RELATIONS.txt SECONDS GUESS COUNT
//     pairs that relations join, at most SECONDS apart
//   measure_log_pairs FILE LOG trajectory TRAJECTORY.tum SECONDS GUESS COUNT
//     a scan and the first one at least SECONDS later
// At most COUNT pairs, evenly spread over the log. GUESS: "identity", or an odometry trajectory
// (TUM). Prints "pairs median_m median_deg" of the motions between scans.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <optional>
#include <string>
#include <vector>

#include "loopstone/formats/log_reader.hpp"
#include "loopstone/formats/relations_file.hpp"
#include "loopstone/formats/tum.hpp"
#include "loopstone/geometry/angle.hpp"
#include "loopstone/odometry/trajectory.hpp"
#include "pairs_file.hpp"

namespace loopstone::bench {
namespace {

/// Stamps of a log and of what refers to it agree to the last digit printed.
constexpr Duration kSameStamp{100'000};

std::vector<LaserScan> scans_of(const std::string& log) {
  std::vector<LaserScan> scans;
  const auto reader = open_log(log);
  while (auto message = reader->next()) {
    if (auto* scan = std::get_if<LaserScan>(&*message)) scans.push_back(std::move(*scan));
  }
  return scans;
}

const LaserScan* scan_at(const std::vector<LaserScan>& scans, Stamp stamp) {
  const auto found =
      std::lower_bound(scans.begin(), scans.end(), stamp - kSameStamp,
                       [](const LaserScan& scan, Stamp wanted) { return scan.stamp < wanted; });
  return found == scans.end() || found->stamp > stamp + kSameStamp ? nullptr : &*found;
}

/// Scans know where the lidar sat; references and odometry speak of the robot.
Pose2 between_lidars(const LaserScan& from, const LaserScan& to, const Pose2& from_T_to) {
  return from.robot_T_lidar.value_or(Pose2{}).inverse() * from_T_to *
         to.robot_T_lidar.value_or(Pose2{});
}

class PairWriter {
 public:
  PairWriter(const std::string& guess, std::size_t count) : count_(count) {
    if (guess != "identity") odometry_ = read_tum(guess);
  }

  void add(const LaserScan& target, const LaserScan& source, const Pose2& robot_motion) {
    Pose2 guess;
    if (odometry_) {
      const auto from = odometry_->at(target.stamp);
      const auto to = odometry_->at(source.stamp);
      if (!from || !to) return;
      guess = between_lidars(target, source, from->inverse() * *to);
    }
    pairs_.push_back({target, source, between_lidars(target, source, robot_motion), guess});
  }

  void finish(const std::string& path) {
    std::vector<StoredPair> chosen;
    const std::size_t count = std::min(count_, pairs_.size());
    for (std::size_t i = 0; i < count; ++i) {
      chosen.push_back(std::move(pairs_[i * pairs_.size() / count]));
    }
    pairs_ = std::move(chosen);
    write_pairs(path, pairs_);
    std::vector<double> metres;
    std::vector<double> degrees;
    for (const StoredPair& pair : pairs_) {
      metres.push_back(pair.truth.translation().norm());
      degrees.push_back(std::abs(pair.truth.yaw) * 180.0 / kPi);
    }
    std::printf("%zu %.4f %.4f\n", pairs_.size(), median(metres), median(degrees));
  }

 private:
  static double median(std::vector<double>& values) {
    if (values.empty()) return 0.0;
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
  }
  std::size_t count_;
  std::optional<Trajectory> odometry_{};
  std::vector<StoredPair> pairs_{};
};

void from_relations(PairWriter& writer, const std::vector<LaserScan>& scans,
                    const std::string& path, double seconds) {
  for (const Relation& relation : read_relations(path)) {
    const double apart_s = std::abs((relation.to - relation.from).seconds());
    const LaserScan* target = scan_at(scans, relation.from);
    const LaserScan* source = scan_at(scans, relation.to);
    if (apart_s <= seconds && target != nullptr && source != nullptr) {
      writer.add(*target, *source, relation.from_T_to);
    }
  }
}

void from_trajectory(PairWriter& writer, const std::vector<LaserScan>& scans,
                     const std::string& path, double seconds) {
  const Trajectory trajectory = read_tum(path);
  for (std::size_t i = 0; i + 1 < scans.size(); ++i) {
    std::size_t j = i + 1;
    while (j < scans.size() && (scans[j].stamp - scans[i].stamp).seconds() < seconds) ++j;
    if (j == scans.size()) break;
    if ((scans[j].stamp - scans[i].stamp).seconds() > seconds + 1.0) continue;  // a gap in the log
    const auto from = trajectory.nearest(scans[i].stamp, kSameStamp);
    const auto to = trajectory.nearest(scans[j].stamp, kSameStamp);
    if (from && to) writer.add(scans[i], scans[j], from->inverse() * *to);
  }
}

void make(char** argv) {
  const std::string kind = argv[3];
  PairWriter writer(argv[6], std::stoul(argv[7]));
  auto scans = scans_of(argv[2]);
  std::stable_sort(scans.begin(), scans.end(),
                   [](const LaserScan& a, const LaserScan& b) { return a.stamp < b.stamp; });
  if (kind == "relations") {
    from_relations(writer, scans, argv[4], std::atof(argv[5]));
  } else {
    from_trajectory(writer, scans, argv[4], std::atof(argv[5]));
  }
  writer.finish(argv[1]);
}

}  // namespace
}  // namespace loopstone::bench

int main(int argc, char** argv) {
  if (argc != 8) {
    std::fprintf(
        stderr,
        "usage: measure_log_pairs FILE LOG relations|trajectory REFERENCE SECONDS GUESS COUNT\n");
    return 2;
  }
  try {
    loopstone::bench::make(argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  return 0;
}
