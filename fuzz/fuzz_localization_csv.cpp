#include "loopstone/formats/localization_csv.hpp"
#include "refusal.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace loopstone;
  return fuzz::expect_work_or_refusal(fuzz::text_of(data, size), [&] {
    // What was read can be written and read again.
    const auto estimates = parse_localization_csv(fuzz::text_of(data, size));
    (void)parse_localization_csv(format_localization_csv(estimates));
  });
}
