#include <array>
#include <string_view>

#include "loopstone/formats/mrclam.hpp"
#include "refusal.hpp"

namespace {

/// The texts of the five files, parted by lines of a single '='.
std::array<std::string_view, 5> parts_of(std::string_view text) {
  std::array<std::string_view, 5> parts{};
  for (std::string_view& part : parts) {
    const std::size_t end = text.find("\n=\n");
    part = text.substr(0, end);
    if (end == text.npos) break;
    text.remove_prefix(end + 3);
  }
  return parts;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace loopstone;
  const std::string_view text = fuzz::text_of(data, size);
  const auto parts = parts_of(text);
  const std::string_view barcodes = parts[0];
  const std::string_view odometry = parts[1];
  const std::string_view measurement = parts[2];
  fuzz::expect_work_or_refusal(
      text, [&] { (void)parse_mrclam_landmarks(parts[3], "Landmark_Groundtruth.dat"); });
  fuzz::expect_work_or_refusal(
      text, [&] { (void)parse_mrclam_truth(parts[4], "Robot1_Groundtruth.dat"); });
  return fuzz::expect_work_or_refusal(text, [&] {
    const BarcodeTable table = parse_barcodes(barcodes, "Barcodes.dat");
    for (const bool strict : {false, true}) {
      const MrclamLog log = parse_mrclam_log(odometry, "Robot1_Odometry.dat", measurement,
                                             "Robot1_Measurement.dat", table, {.strict = strict});
      if (log.odometry.empty()) __builtin_trap();
    }
  });
}
