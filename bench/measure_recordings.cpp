// How fast recordings are read, printed as JSON:
//   measure_recordings FILE scans   laser scans alone are wanted, and decoded
//   measure_recordings FILE all     every message is given, none decoded
//   measure_recordings FILE log     as the program reads it: topics chosen, mounts found, in order
// FILE is a bag, an MCAP, or a folder of rosbag2. One thread does everything; CPU time is that
// thread's, from opening to the end.

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>

#include "answers.hpp"
#include "formats/recording.hpp"
#include "loopstone/formats/log_reader.hpp"
#include "loopstone/report/peak_memory.hpp"

namespace loopstone::bench {
namespace {

constexpr const char* kScanType = "sensor_msgs/LaserScan";

struct Read {
  std::int64_t messages = 0;
  std::int64_t message_bytes = 0;
  std::int64_t beams = 0;  ///< of decoded scans
  std::int64_t damage = 0;
};

std::int64_t size_of(const std::filesystem::path& path) {
  if (!std::filesystem::is_directory(path)) {
    return static_cast<std::int64_t>(std::filesystem::file_size(path));
  }
  std::int64_t bytes = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(path)) {
    if (entry.is_regular_file()) bytes += static_cast<std::int64_t>(entry.file_size());
  }
  return bytes;
}

std::unique_ptr<Recording> open_recording(const std::string& path,
                                          const RecordingOptions& options) {
  if (std::filesystem::is_directory(path)) return open_rosbag2(path, options);
  std::ifstream file(path, std::ios::binary);
  std::string head(64, '\0');
  file.read(head.data(), static_cast<std::streamsize>(head.size()));
  if (is_bag(head)) return open_bag(path, options);
  if (is_mcap(head)) return open_mcap(path, options);
  if (is_sqlite(head)) return open_rosbag2(path, options);
  throw std::runtime_error(path + ": no recording");
}

RecordingOptions counting_damage(Read& read) {
  RecordingOptions options;
  options.on_damage = [&read](const Problem&) { ++read.damage; };
  return options;
}

Read read_scans(const std::string& path) {
  Read read;
  const auto recording = open_recording(path, counting_damage(read));
  recording->want([](const RecordedTopic& topic) { return topic.type == kScanType; });
  std::map<std::size_t, MessageDecoder<msg::LaserScan>> decoders;
  msg::LaserScan scan;
  while (const auto message = recording->next()) {
    auto decoder = decoders.find(message->topic);
    if (decoder == decoders.end()) {
      const RecordedTopic& topic = recording->topics().at(message->topic);
      MessageDecoder<msg::LaserScan> made(topic.format, topic.definition);
      decoder = decoders.emplace(message->topic, std::move(made)).first;
    }
    decoder->second.decode(message->bytes, scan);
    ++read.messages;
    read.message_bytes += static_cast<std::int64_t>(message->bytes.size());
    read.beams += static_cast<std::int64_t>(scan.ranges.size());
  }
  return read;
}

Read read_all(const std::string& path) {
  Read read;
  const auto recording = open_recording(path, counting_damage(read));
  while (const auto message = recording->next()) {
    ++read.messages;
    read.message_bytes += static_cast<std::int64_t>(message->bytes.size());
  }
  return read;
}

Read read_log(const std::string& path) {
  Read read;
  LogOptions options;
  options.on_problem = [&read](const LogProblem&) { ++read.damage; };
  const auto log = open_log(path, options);
  while (log->next()) ++read.messages;
  return read;
}

Read read_as(const std::string& mode, const std::string& path) {
  if (mode == "scans") return read_scans(path);
  if (mode == "all") return read_all(path);
  if (mode == "log") return read_log(path);
  throw std::runtime_error(mode + ": no such mode; scans, all and log are");
}

void measure(const std::string& path, const std::string& mode) {
  const auto start = std::chrono::steady_clock::now();
  const double cpu_start_s = thread_seconds();
  const Read read = read_as(mode, path);
  const double cpu_s = thread_seconds() - cpu_start_s;
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - start;
  const nlohmann::json json{{"cpu_s", cpu_s},
                            {"wall_s", wall.count()},
                            {"messages", read.messages},
                            {"message_bytes", read.message_bytes},
                            {"beams", read.beams},
                            {"damage", read.damage},
                            {"file_bytes", size_of(path)},
                            {"peak_memory_bytes", peak_memory_bytes()}};
  std::printf("%s\n", json.dump().c_str());
}

}  // namespace
}  // namespace loopstone::bench

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fprintf(stderr, "measure_recordings FILE scans|all|log\n");
    return 2;
  }
  try {
    loopstone::bench::measure(argv[1], argv[2]);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  return 0;
}
