#include "formats/byte_source.hpp"
#include "formats/mcap_stream.hpp"
#include "recording_target.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace loopstone;
  const std::string_view text = fuzz::text_of(data, size);
  const int answer =
      fuzz::expect_work_or_refusal(text, [&] { fuzz::use_recording(text, read_mcap); });
  // As it comes over a network, which leads nowhere but forward.
  (void)fuzz::expect_work_or_refusal(text, [&] {
    const auto stream = stream_mcap(memory_byte_source(text), "a stream", {}, {});
    stream->survey_is_over();
    while (const auto message = stream->next()) {
      if (message->topic >= stream->topics().size()) __builtin_trap();
    }
  });
  return answer;
}
