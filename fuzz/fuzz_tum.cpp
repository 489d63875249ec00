#include "loopstone/evaluation/trajectory_error.hpp"
#include "loopstone/formats/tum.hpp"
#include "refusal.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace loopstone;
  return fuzz::expect_work_or_refusal(fuzz::text_of(data, size), [&] {
    const Trajectory read = parse_tum(fuzz::text_of(data, size));
    const Trajectory again = parse_tum(format_tum(read));
    if (again.size() != read.size() || again.front().stamp != read.front().stamp) __builtin_trap();
    (void)absolute_error(read, again, Alignment::kSe2);
    (void)relative_error(read, again, 1.0, Spacing::kMetres);
    (void)relative_error(read, again, 0.5, Spacing::kSeconds);
    (void)read.path_length_m();
  });
}
