// Writes pairs of scans in random rooms, for this project's matchers and others':
//   measure_make_pairs FILE BEAMS(1081|180) BIN(0..4) COUNT SEED

#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string>

#include "pairs_file.hpp"
#include "registration_pairs.hpp"

namespace loopstone::bench {
namespace {

void make(const std::string& path, int beams, std::size_t bin, int count, std::uint64_t seed) {
  const PairSensor& sensor = beams == kSensor180.beams ? kSensor180 : kSensor1081;
  std::vector<StoredPair> stored;
  for (ScanPair& pair : make_scan_pairs(sensor, kPairBins.at(bin), count, seed)) {
    stored.push_back({.target = std::move(pair.target),
                      .source = std::move(pair.source),
                      .truth = pair.target_T_source,
                      .guess = Pose2{}});
  }
  write_pairs(path, stored);
}

}  // namespace
}  // namespace loopstone::bench

int main(int argc, char** argv) {
  if (argc != 6) {
    std::fprintf(stderr, "usage: measure_make_pairs FILE BEAMS BIN COUNT SEED\n");
    return 2;
  }
  try {
    loopstone::bench::make(argv[1], std::atoi(argv[2]),
                           static_cast<std::size_t>(std::atoi(argv[3])), std::atoi(argv[4]),
                           static_cast<std::uint64_t>(std::atoll(argv[5])));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  return 0;
}
