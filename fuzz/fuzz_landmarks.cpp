#include "loopstone/formats/landmark_file.hpp"
#include "loopstone/localization/constellation_search.hpp"
#include "refusal.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace loopstone;
  return fuzz::expect_work_or_refusal(fuzz::text_of(data, size), [&] {
    // What was read can be written and read again, and searched.
    const auto landmarks = parse_landmarks(fuzz::text_of(data, size), "landmarks.csv");
    if (parse_landmarks(format_landmarks(landmarks)).size() != landmarks.size()) __builtin_trap();
    constexpr std::size_t kFew = 100;
    if (!fuzz::goes_on() || landmarks.size() > kFew) return;
    const LandmarkMap map(landmarks);
    const std::vector seen{observed(3.0, 0.0, 0.1, 0.02), observed(4.0, 1.0, 0.1, 0.02),
                           observed(2.0, -2.0, 0.1, 0.02)};
    (void)ConstellationIndex(map, 20.0).search(seen, {});
  });
}
