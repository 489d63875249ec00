#include "loopstone/formats/options_file.hpp"
#include "loopstone/formats/robot_file.hpp"
#include "loopstone/slam/map_options.hpp"
#include "refusal.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace loopstone;
  const std::string_view text = fuzz::text_of(data, size);
  MapOptions options;
  const auto entries = list_options(options);
  const auto expect_words = [&](std::vector<OptionProblem> problems) {
    if (!problems.empty()) fuzz::expect_own_words(OptionsError(std::move(problems)), text);
  };
  expect_words(apply_toml(entries, text, "options.toml"));
  expect_words(apply_assignment(entries, text));
  // What was taken can be written and read again.
  if (!apply_toml(entries, options_to_toml(entries), "again.toml").empty()) __builtin_trap();
  return fuzz::expect_work_or_refusal(text, [&] {
    const RobotModel robot = parse_robot(text, "robot.toml");
    (void)parse_robot(robot_to_toml(robot), "again.toml");
  });
}
