#include "loopstone/report/map_folder.hpp"
#include "refusal.hpp"

// Tables of a finished map: what `loopstone view` reads.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace loopstone;
  const std::string_view text = fuzz::text_of(data, size);
  const int answer = fuzz::expect_work_or_refusal(text, [&] { (void)parse_closure_csv(text); });
  const Trajectory trajectory({{Stamp{1'000'000'000}, {}}, {Stamp{2'000'000'000}, {1, 0, 0}}});
  (void)fuzz::expect_work_or_refusal(text, [&] { (void)parse_covariance_csv(text, trajectory); });
  return answer;
}
