#include <cstddef>
#include <cstdint>
#include <string_view>

#include "loopstone/formats/options_file.hpp"
#include "loopstone/formats/robot_file.hpp"
#include "loopstone/odometry/odometry_options.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text{reinterpret_cast<const char*>(data), size};
  loopstone::OdometryOptions options;
  const auto entries = loopstone::list_options(options);
  (void)loopstone::apply_toml(entries, text, "options.toml");
  (void)loopstone::apply_assignment(entries, text);
  try {
    (void)loopstone::parse_robot(text, "robot.toml");
  } catch (const loopstone::OptionsError&) {
    // Damage is expected to be refused, and nothing worse.
  }
  return 0;
}
