#include "recording_target.hpp"

namespace {

/// Messages, and the sum of their bytes.
struct Sum {
  std::int64_t messages = 0;
  std::uint64_t bytes = 0;
  bool operator==(const Sum&) const = default;
};

Sum read_all(loopstone::Recording& recording, loopstone::fuzz::PlacedMessages& placed) {
  Sum sum;
  while (const auto message = recording.next()) {
    if (message->topic >= recording.topics().size()) __builtin_trap();
    ++sum.messages;
    placed.add(*message);
    for (const char c : message->bytes) sum.bytes += static_cast<unsigned char>(c);
  }
  return sum;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace loopstone;
  const std::string_view bytes = fuzz::text_of(data, size);
  return fuzz::expect_work_or_refusal(bytes, [&] {
    RecordingOptions options;
    options.memory.ceiling_bytes = std::uint64_t{1} << 25;
    options.on_damage = [&bytes](const Problem& problem) {
      fuzz::expect_own_words(std::runtime_error(problem.reason), bytes);
    };
    const auto recording = read_sqlite_log(bytes, options);
    fuzz::PlacedMessages placed;
    const Sum first = read_all(*recording, placed);
    recording->rewind();
    if (read_all(*recording, placed) != first) __builtin_trap();
    placed.ask(*recording, true);
  });
}
