#include "map_target.hpp"
#include "refusal.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace loopstone;
  return fuzz::expect_work_or_refusal(fuzz::text_of(data, size), [&] {
    fuzz::use_map(interpret_map(decode_image(fuzz::text_of(data, size)), {}));
  });
}
