#include "formats/rosbag2_metadata.hpp"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cstddef>
#include <set>

#include "loopstone/base/error.hpp"

namespace loopstone {
namespace {

/// A text of 4 MB tells of tens of thousands of files or topics.
constexpr std::size_t kMostBytes = std::size_t{1} << 22;
constexpr int kMostDepth = 64;

int depth_of_brackets(std::string_view text) {
  int depth = 0;
  int deepest = 0;
  for (const char c : text) {
    if (c == '[' || c == '{') deepest = std::max(deepest, ++depth);
    if ((c == ']' || c == '}') && depth > 0) --depth;
  }
  return deepest;
}

std::string scalar(const YAML::Node& node) { return node.IsScalar() ? node.Scalar() : ""; }

/// What a map has under a key; an undefined node when it is none.
YAML::Node at(const YAML::Node& node, const char* key) {
  return node.IsMap() ? node[key] : YAML::Node(YAML::NodeType::Undefined);
}

std::string small_letters(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  });
  return text;
}

void read_topics(const YAML::Node& topics, Rosbag2Metadata& metadata) {
  if (!topics.IsDefined() || !topics.IsSequence()) return;
  std::set<std::string> twice;
  for (const YAML::Node& topic : topics) {
    std::int64_t count = 0;
    const YAML::Node described = at(topic, "topic_metadata");
    const YAML::Node messages = at(topic, "message_count");
    if (!described.IsDefined() || !messages.IsDefined() || !messages.IsScalar()) continue;
    if (!YAML::convert<std::int64_t>::decode(messages, count) || count < 0) continue;
    const YAML::Node name = at(described, "name");
    if (!name.IsDefined() || !name.IsScalar()) continue;
    if (!metadata.messages.emplace(name.Scalar(), count).second) twice.insert(name.Scalar());
  }
  for (const std::string& name : twice) metadata.messages.erase(name);
}

Rosbag2Metadata metadata_of(const YAML::Node& root, const std::string& path) {
  const YAML::Node info = at(root, "rosbag2_bagfile_information");
  if (!info.IsDefined() || !info.IsMap()) {
    throw DataError({path}, "does not describe a recording; expected rosbag2_bagfile_information");
  }
  Rosbag2Metadata metadata;
  const auto text = [&info](const char* key) {
    const YAML::Node node = at(info, key);
    return node.IsDefined() ? scalar(node) : std::string();
  };
  const YAML::Node version = at(info, "version");
  if (version.IsDefined() && version.IsScalar()) {
    YAML::convert<int>::decode(version, metadata.version);
  }
  metadata.storage = text("storage_identifier");
  metadata.compression_mode = small_letters(text("compression_mode"));
  if (metadata.compression_mode == "none") metadata.compression_mode.clear();
  metadata.compression_format = small_letters(text("compression_format"));
  const YAML::Node files = at(info, "relative_file_paths");
  if (files.IsDefined() && files.IsSequence()) {
    for (const YAML::Node& file : files) {
      if (file.IsScalar() && !file.Scalar().empty()) metadata.files.push_back(file.Scalar());
    }
  }
  read_topics(at(info, "topics_with_message_count"), metadata);
  return metadata;
}

/// In double quotes, for any text.
std::string quoted(std::string_view text) {
  std::string result = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      result += '\\';
      result += c;
    } else if (byte < 0x20 || byte == 0x7F) {
      result += fmt::format("\\x{:02X}", byte);
    } else {
      result += c;
    }
  }
  return result + '"';
}

/// Plain, as rosbag2 writes names of topics and types, where no reader can take it for anything
/// else.
std::string word(std::string_view text) {
  const bool is_plain =
      !text.empty() &&
      (text.front() == '/' || text.find('/') != text.npos || text.starts_with("RIHS") ||
       text.find(".db3") != text.npos || text.find(".mcap") != text.npos) &&
      std::all_of(text.begin(), text.end(), [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
               c == '/' || c == '_' || c == '.';
      });
  return is_plain ? std::string(text) : quoted(text);
}

/// \param indent  of the dash before each profile
std::string qos_lines(bool latched, int indent) {
  constexpr const char* kForever = "sec: 9223372036\n{0}    nsec: 854775807\n";
  const std::string forever = fmt::format(fmt::runtime(kForever), std::string(indent, ' '));
  std::string lines;
  const auto line = [&](const char* before, const std::string& text) {
    lines += std::string(indent, ' ') + before + text;
  };
  line("- ", "history: keep_last\n");
  line("  ", latched ? "depth: 1\n" : "depth: 10\n");
  line("  ", "reliability: reliable\n");
  line("  ", latched ? "durability: transient_local\n" : "durability: volatile\n");
  for (const char* name : {"deadline", "lifespan"}) {
    line("  ", fmt::format("{}:\n", name));
    line("    ", forever);
  }
  line("  ", "liveliness: automatic\n");
  line("  ", "liveliness_lease_duration:\n");
  line("    ", forever);
  line("  ", "avoid_ros_namespace_conventions: false\n");
  return lines;
}

/// \param indent  spaces before each line
std::string format_information(const Rosbag2Contents& contents, int indent) {
  const std::string in(static_cast<std::size_t>(indent), ' ');
  const std::int64_t start = contents.messages > 0 ? contents.first.nanoseconds : 0;
  const std::int64_t length =
      contents.messages > 0 ? (contents.last - contents.first).nanoseconds : 0;
  std::string text = fmt::format(
      "{0}version: 9\n{0}storage_identifier: {1}\n{0}duration:\n{0}  nanoseconds: {2}\n"
      "{0}starting_time:\n{0}  nanoseconds_since_epoch: {3}\n{0}message_count: {4}\n",
      in, contents.storage, length, start, contents.messages);
  text += in + (contents.topics.empty() ? "topics_with_message_count: []\n"
                                        : "topics_with_message_count:\n");
  for (const auto& topic : contents.topics) {
    text += fmt::format(
        "{0}  - topic_metadata:\n{0}      name: {1}\n{0}      type: {2}\n"
        "{0}      serialization_format: cdr\n{0}      offered_qos_profiles:\n{3}"
        "{0}      type_description_hash: {4}\n{0}    message_count: {5}\n",
        in, word(topic.name), word(topic.type), qos_lines(topic.latched, indent + 8),
        word(topic.hash), topic.messages);
  }
  text += fmt::format(
      "{0}compression_format: \"\"\n{0}compression_mode: \"\"\n{0}relative_file_paths:\n"
      "{0}  - {1}\n{0}files:\n{0}  - path: {1}\n{0}    starting_time:\n"
      "{0}      nanoseconds_since_epoch: {2}\n{0}    duration:\n{0}      nanoseconds: {3}\n"
      "{0}    message_count: {4}\n{0}custom_data: ~\n{0}ros_distro: loopstone\n",
      in, word(contents.file), start, length, contents.messages);
  return text;
}

}  // namespace

Rosbag2Metadata parse_rosbag2_metadata(std::string_view text, const std::string& path) {
  if (text.size() > kMostBytes || depth_of_brackets(text) > kMostDepth) {
    throw DataError({path}, "does not describe a recording: it is too long or too deeply nested");
  }
  try {
    return metadata_of(YAML::Load(std::string(text)), path);
  } catch (const YAML::Exception& error) {
    Location where{path};
    if (!error.mark.is_null()) where.line = error.mark.line + 1;
    throw DataError(where, "is no valid YAML from here on");
  }
}

std::string format_rosbag2_metadata(const Rosbag2Contents& contents) {
  return "rosbag2_bagfile_information:\n" + format_information(contents, 2);
}

std::string format_inner_rosbag2_metadata(const Rosbag2Contents& contents) {
  std::string text = format_information(contents, 0);
  text.pop_back();
  return text;
}

std::string format_qos_profiles(bool latched) {
  std::string text = qos_lines(latched, 0);
  text.pop_back();
  return text;
}

}  // namespace loopstone
