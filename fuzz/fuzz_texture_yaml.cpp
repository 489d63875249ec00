#include "loopstone/formats/texture_files.hpp"
#include "refusal.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace loopstone;
  return fuzz::expect_work_or_refusal(fuzz::text_of(data, size), [&] {
    const TextureInfo info = parse_texture_yaml(fuzz::text_of(data, size));
    const GridFrame frame = info.frame(64, 48);
    (void)parse_texture_yaml(format_texture_yaml(frame, info.image, info.coverage));
    (void)format_world_file(frame);
  });
}
