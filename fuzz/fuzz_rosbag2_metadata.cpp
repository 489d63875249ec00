#include "formats/rosbag2_metadata.hpp"
#include "refusal.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace loopstone;
  return fuzz::expect_work_or_refusal(fuzz::text_of(data, size), [&] {
    // What it says of topics can be written and read again.
    const Rosbag2Metadata metadata = parse_rosbag2_metadata(fuzz::text_of(data, size));
    Rosbag2Contents contents;
    contents.storage = "sqlite3";
    contents.file = metadata.files.empty() ? "a_0.db3" : metadata.files.front();
    for (const auto& [name, count] : metadata.messages) {
      contents.topics.push_back({name, "std_msgs/msg/String", "", false, count});
    }
    const Rosbag2Metadata again = parse_rosbag2_metadata(format_rosbag2_metadata(contents));
    if (again.messages != metadata.messages || again.files.front() != contents.file) {
      __builtin_trap();
    }
  });
}
