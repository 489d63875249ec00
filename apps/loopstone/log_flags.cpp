#include "log_flags.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>

#include "loopstone/base/error.hpp"
#include "loopstone/formats/log_format_words.hpp"
#include "parse_pose.hpp"
#include "word_flag.hpp"

namespace loopstone::app {
namespace {

/// Those that a user may name.
constexpr std::array<TopicRole, 6> kNamedRoles{TopicRole::kLaser, TopicRole::kOdometry,
                                               TopicRole::kImu,   TopicRole::kWheels,
                                               TopicRole::kDepth, TopicRole::kColour};

std::pair<TopicRole, std::string> parse_topic(const std::string& text) {
  const std::size_t mark = text.find('=');
  const auto role = find_word<TopicRole>(text.substr(0, mark));
  if (mark == std::string::npos || !role ||
      std::ranges::find(kNamedRoles, *role) == kNamedRoles.end()) {
    std::vector<std::string> roles;
    for (const TopicRole known : kNamedRoles) roles.emplace_back(to_string(known));
    throw UsageError(
        fmt::format("--topic {}: ROLE=NAME was expected, such as laser=/scan; a role is {}", text,
                    listed(roles, "or")));
  }
  const std::string name = text.substr(mark + 1);
  return {*role, name == "none" ? "" : name};
}

HeightRange parse_slice(const std::string& text) {
  const std::vector<double> heights = parse_numbers("--slice", text);
  if (heights.size() != 2 || heights[0] >= heights[1]) {
    throw UsageError("--slice " + text +
                     ": two heights in metres were expected, the lower first: "
                     "0.1,0.4");
  }
  return {heights[0], heights[1]};
}

}  // namespace

void add_log_flags(CLI::App& command, LogFlags& flags) {
  command.add_flag("--strict", flags.strict, "a broken record is an error, not skipped");
  add_word_flag(command, "--stamps", flags.stamps,
                "whose time counts: the messages' own, the recorder's, or the order alone");
  command
      .add_option("--topic", flags.topics,
                  "of a recording with topics: which plays a role (laser, odometry, imu, wheels, "
                  "depth, colour); several lasers all count, NAME none leaves a role empty")
      ->type_name("ROLE=NAME")
      ->allow_extra_args(false);
  command
      .add_option("--base-frame", flags.base_frame,
                  "the robot's frame in tf (default: that of odometry, base_footprint, base_link)")
      ->type_name("FRAME");
  add_word_flag(command, "--echo", flags.echo, "of lasers with several echoes a beam");
  command
      .add_option(
          "--slice", flags.slice,
          "of point clouds: what lies between two heights in the robot's frame [m] (default: "
          "about the scanner's height)")
      ->type_name("LOW,HIGH");
}

void add_truth_topic_flag(CLI::App& command, std::string& topic, const std::string& meaning) {
  command.add_option("--truth-topic", topic, meaning)->type_name("NAME");
}

TopicOptions topic_options(const LogFlags& flags) {
  TopicOptions options{
      .base_frame = flags.base_frame, .echo = flags.echo, .pictures = flags.pictures};
  for (const std::string& text : flags.topics) options.named.push_back(parse_topic(text));
  if (!flags.slice.empty()) options.slice = parse_slice(flags.slice);
  return options;
}

std::string log_flags_comment(const LogFlags& flags) {
  std::string text;
  const auto add = [&](const std::string& flag, const std::string& value) {
    text += "# " + flag + " " + value + "\n";
  };
  if (flags.stamps != StampUse::kAuto) add("--stamps", std::string(to_string(flags.stamps)));
  for (const std::string& topic : flags.topics) add("--topic", topic);
  if (!flags.base_frame.empty()) add("--base-frame", flags.base_frame);
  if (flags.echo != EchoUse::kFirst) add("--echo", std::string(to_string(flags.echo)));
  if (!flags.slice.empty()) add("--slice", flags.slice);
  return text;
}

void tell_choices(const LogReader& log, const AppContext& context) {
  for (const std::string& choice : log.choices()) context.note(choice);
}

}  // namespace loopstone::app
