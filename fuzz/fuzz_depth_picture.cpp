#include "loopstone/formats/rgbd_files.hpp"
#include "loopstone/sensor/camera_geometry.hpp"
#include "refusal.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace loopstone;
  static const DepthEncoding encoding;
  static const auto table = inverse_depth_table(encoding);
  const std::string_view bytes = fuzz::text_of(data, size);
  fuzz::expect_work_or_refusal(bytes, [&] { (void)decode_depth(bytes, encoding, table); });
  return fuzz::expect_work_or_refusal(bytes, [&] { (void)decode_colour(bytes); });
}
