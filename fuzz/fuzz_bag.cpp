#include "recording_target.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace loopstone;
  return fuzz::expect_work_or_refusal(
      fuzz::text_of(data, size), [&] { fuzz::use_recording(fuzz::text_of(data, size), read_bag); });
}
