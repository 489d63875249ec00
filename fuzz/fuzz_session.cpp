#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "loopstone/base/error.hpp"
#include "loopstone/formats/session_file.hpp"
#include "loopstone/slam/mapper.hpp"

namespace {

/// What a mapper takes in it must be able to give back.
void restore(const std::vector<loopstone::StateChunk>& chunks) {
  loopstone::Mapper mapper({}, {}, loopstone::Threads{1});
  mapper.restore_state(chunks);
  (void)mapper.save_state().get();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace loopstone;
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  try {
    std::vector<StateChunk> chunks = parse_session(bytes, "fuzz");
    if (format_session(chunks) != bytes) __builtin_trap();  // there is one way only to write it
    std::erase_if(chunks, [](const StateChunk& chunk) { return chunk.tag == "RUN "; });
    restore(chunks);
  } catch (const DataError&) {
    // Damage is expected to be refused, and nothing worse.
  }
  // Behind the checksums: "TAG " and the bytes of that part, the others as of a new mapper.
  constexpr std::size_t kTagBytes = 4;
  if (size < kTagBytes) return 0;
  try {
    std::vector<StateChunk> chunks = Mapper({}, {}, Threads{1}).save_state().get();
    for (StateChunk& chunk : chunks) {
      if (bytes.starts_with(chunk.tag)) chunk.bytes = bytes.substr(kTagBytes);
    }
    restore(chunks);
  } catch (const DataError&) {
    // As above.
  }
  return 0;
}
