#include <algorithm>
#include <cmath>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "loopstone/formats/session_file.hpp"
#include "loopstone/slam/mapper.hpp"
#include "refusal.hpp"

namespace {

using loopstone::ImuSample;
using loopstone::LaserScan;
using loopstone::MapOptions;
using loopstone::Mapper;
using loopstone::OdometryPose;
using loopstone::Stamp;
using loopstone::StateChunk;
using loopstone::Threads;

/// Submaps that are full after a few scans.
MapOptions options() {
  MapOptions options;
  options.front_end.submap_length_m = 0.5;
  options.map.resolution_m = 0.25;
  return options;
}

/// A robot that drives towards a wall, between two others.
void drive(Mapper& mapper, int from, int to) {
  for (int i = from; i < to; ++i) {
    const Stamp stamp{i * 100'000'000LL};
    LaserScan scan{.stamp = stamp,
                   .angle_min_rad = -1.5,
                   .angle_increment_rad = 0.1,
                   .range_min_m = 0.1,
                   .range_max_m = 10.0};
    for (std::size_t beam = 0; beam < 31; ++beam) {
      const double angle = -1.5 + 0.1 * static_cast<double>(beam);
      const double aside = 1.5 / std::max(0.01, std::abs(std::sin(angle)));
      const double ahead = (4.0 - 0.2 * i) / std::max(0.01, std::cos(angle));
      scan.ranges_m.push_back(static_cast<float>(std::min(aside, ahead)));
    }
    mapper.add(OdometryPose{stamp, {0.2 * i, 0.0, 0.0}});
    mapper.add(ImuSample{stamp, {0.0, 0.0, 0.01}});
    mapper.add(scan);
  }
}

/// Of a mapper that saw half of the drive.
std::vector<StateChunk> saved_run() {
  Mapper mapper({}, options(), Threads{1});
  drive(mapper, 0, 12);
  return mapper.save_state().get();
}

/// What a mapper takes in it must be able to give back, and to go on from to a map.
void restore(std::span<const StateChunk> chunks, std::string_view bytes) {
  loopstone::fuzz::expect_work_or_refusal(bytes, [&] {
    Mapper mapper({}, options(), Threads{1});
    mapper.restore_state(chunks);
    (void)mapper.save_state().get();
    if (!loopstone::fuzz::goes_on()) return;
    drive(mapper, 12, 16);
    (void)mapper.finish();
  });
}

/// Behind the checksums: the first byte chooses a part of a good state; then come three bytes for
/// each byte of it that changes (position, value), and what is left over tells by how much it is
/// shorter.
void restore_edited(std::string_view edits) {
  static const std::vector<StateChunk> good = saved_run();
  if (edits.empty()) return;
  const auto number = [&](std::size_t i) { return static_cast<std::uint8_t>(edits[i]); };
  std::vector<StateChunk> chunks = good;
  std::string& bytes = chunks[number(0) % chunks.size()].bytes;
  std::size_t at = 1;
  for (; at + 3 <= edits.size(); at += 3) {
    const std::size_t position = std::size_t{256} * number(at) + number(at + 1);
    bytes[position % bytes.size()] = edits[at + 2];
  }
  if (at < edits.size())
    bytes.resize(bytes.size() - std::min<std::size_t>(bytes.size(), number(at)));
  restore(chunks, edits);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view bytes = loopstone::fuzz::text_of(data, size);
  loopstone::fuzz::expect_work_or_refusal(bytes, [&] {
    const std::vector<StateChunk> chunks = loopstone::parse_session(bytes, "fuzz");
    if (loopstone::format_session(chunks) != bytes)
      __builtin_trap();  // there is one way only to write it
    restore(chunks, bytes);
  });
  restore_edited(bytes);
  return 0;
}
