#pragma once

#include <optional>
#include <string>
#include <vector>

#include "app.hpp"
#include "loopstone/formats/log_reader.hpp"
#include "loopstone/formats/topic_options.hpp"

namespace loopstone::app {

/// How a log is to be understood, as the user said.
struct LogFlags {
  bool strict = false;
  StampUse stamps = StampUse::kAuto;
  std::vector<std::string> topics{};  ///< "ROLE=NAME"
  std::string base_frame{};
  EchoUse echo = EchoUse::kFirst;
  std::string slice{};    ///< "LOW,HIGH"
  bool pictures = false;  ///< not said by the user: the command has a use for them
};

/// --strict, --stamps, --topic, --base-frame, --echo, --slice.
void add_log_flags(CLI::App& command, LogFlags& flags);
/// --truth-topic.
void add_truth_topic_flag(CLI::App& command, std::string& topic, const std::string& meaning);

/// Throws UsageError for a role, heights or a frame that can't be.
[[nodiscard]] TopicOptions topic_options(const LogFlags& flags);

/// What of the flags changes what is read, as lines of a comment: nothing when they are the
/// defaults. Runs with other flags are other runs.
[[nodiscard]] std::string log_flags_comment(const LogFlags& flags);

/// Tells the user what was chosen in a log that left a choice.
void tell_choices(const LogReader& log, const AppContext& context);

}  // namespace loopstone::app
