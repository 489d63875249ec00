// How fast the colour of the floor is mapped, on one core:
//   measure_texture_speed LOG TRAJECTORY.tum [FRAMES]
// Over the first FRAMES frames (200): CPU time of map_floor_texture with pictures from files and
// with pictures already in memory, with and without the estimates of mount and clock, which cost
// the same however long the log is. Prints JSON.

#include <algorithm>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <exception>
#include <map>
#include <string>
#include <variant>
#include <vector>

#include "loopstone/formats/log_reader.hpp"
#include "loopstone/formats/rgbd_files.hpp"
#include "loopstone/formats/tum.hpp"
#include "loopstone/mapping/floor_texture.hpp"
#include "loopstone/report/peak_memory.hpp"

namespace loopstone::bench {
namespace {

double cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

double peak_memory_mb() { return 1e-6 * static_cast<double>(peak_memory_bytes()); }

/// Frames a second of CPU time, the median of three runs.
double frames_per_second(const RgbdSource& source, const Trajectory& trajectory,
                         const CameraModel& camera, const TextureOptions& options) {
  std::vector<double> rates;
  for (int run = 0; run < 3; ++run) {
    const double start = cpu_seconds();
    const FloorTexture texture = map_floor_texture(source, trajectory, camera, options, Threads{1});
    rates.push_back(static_cast<double>(texture.statistics.frames_used) / (cpu_seconds() - start));
  }
  std::sort(rates.begin(), rates.end());
  return rates[1];
}

int measure(const std::string& log, const std::string& tum, std::size_t most) {
  const auto reader = open_log(log);
  const RobotModel robot = reader->robot(RobotModel{});
  RgbdSource files;
  while (const auto message = reader->next()) {
    const auto* frame = std::get_if<RgbdFrame>(&*message);
    if (frame != nullptr && files.frames.size() < most) files.frames.push_back(*frame);
  }
  const Trajectory trajectory = read_tum(tum);
  const RgbdLoader loader(robot.camera);
  files.load = [&](const RgbdFrame& frame) { return loader.load(frame); };

  TextureOptions all;
  all.min_travel_m = 0.0;  // every frame counts
  TextureOptions mapping = all;
  mapping.correct_clock = false;
  const double from_files = frames_per_second(files, trajectory, robot.camera, all);
  const double from_files_mapping = frames_per_second(files, trajectory, robot.camera, mapping);
  const double streaming_mb = peak_memory_mb();

  std::map<std::string, RgbdImages> pictures;
  for (const RgbdFrame& frame : files.frames) pictures[frame.depth_path] = loader.load(frame);
  // What is handed out is a copy, as from a driver: 2 MB, which takes about 0.2 ms.
  const RgbdSource memory{files.frames,
                          [&](const RgbdFrame& frame) { return pictures.at(frame.depth_path); }};
  const double from_memory = frames_per_second(memory, trajectory, robot.camera, all);
  const double from_memory_mapping = frames_per_second(memory, trajectory, robot.camera, mapping);
  std::printf(
      "{\"frames\": %zu, \"from_files_per_s\": %.1f, \"from_files_without_clock_per_s\": %.1f, "
      "\"from_memory_per_s\": %.1f, \"from_memory_without_clock_per_s\": %.1f, "
      "\"streaming_peak_mb\": %.1f}\n",
      files.frames.size(), from_files, from_files_mapping, from_memory, from_memory_mapping,
      streaming_mb);
  return 0;
}

}  // namespace
}  // namespace loopstone::bench

int main(int argc, char** argv) {
  if (argc != 3 && argc != 4) {
    std::fprintf(stderr, "measure_texture_speed LOG TRAJECTORY.tum [FRAMES]\n");
    return 2;
  }
  try {
    return loopstone::bench::measure(
        argv[1], argv[2], argc == 4 ? std::strtoul(argv[3], nullptr, 10) : std::size_t{200});
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
