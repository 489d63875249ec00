#include "loopstone/formats/log_format_words.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <span>

namespace loopstone {
namespace {

std::vector<std::string> strings_of(std::span<const std::string_view> words) {
  return {words.begin(), words.end()};
}

std::string packed_text(const LogFormat& format) {
  if (format.packings.empty()) return {};
  return ", also " + listed(strings_of(format.packings), "and");
}

std::string described(const LogFormat& format) {
  std::string text = std::string(format.noun) + packed_text(format);
  if (format.has_sets) {
    text += fmt::format("; DIR#{0} names set {0}", LogTarget::kDefaultSet);
  }
  return text;
}

std::string folder_meaning(const LogFormat& format) {
  std::string text = fmt::format("a folder is {}", format.noun);
  if (format.has_sets) {
    text += fmt::format(", FOLDER#21 its set 21 ({} without a number)", LogTarget::kDefaultSet);
  }
  return text;
}

std::string kinds_text(const LogContents& contents) {
  std::vector<std::string> kinds;
  for (const MessageKind& kind : message_kinds()) {
    if (contents.*kind.held) kinds.emplace_back(kind.name);
  }
  return listed(kinds, "and");
}

std::string details_text(const LogContents& contents) {
  std::string text = contents.lidars == 1 ? "one laser" : fmt::format("{} lasers", contents.lidars);
  text += contents.beams_change ? ", beams may change" : ", the same beams in all scans";
  if (contents.beam_times) text += "; the time between beams";
  if (contents.intensities) text += "; how bright echoes are";
  if (contents.lidar_mount) text += "; the laser's mount";
  const auto error_ns = contents.stamp_error.nanoseconds;
  if (contents.single_precision) text += "; angles as 32-bit numbers";
  text += error_ns == 0 ? "; stamps exact" : fmt::format("; stamps within {} ns", error_ns);
  return text;
}

nlohmann::ordered_json contents_json(const LogContents& contents) {
  auto json = nlohmann::ordered_json::object();
  for (const MessageKind& kind : message_kinds()) {
    std::string key(kind.name);
    std::replace(key.begin(), key.end(), ' ', '_');
    json[key] = contents.*kind.held;
  }
  json["lasers"] = contents.lidars;
  json["beams_may_change"] = contents.beams_change;
  json["time_between_beams"] = contents.beam_times;
  json["intensities"] = contents.intensities;
  json["laser_mount"] = contents.lidar_mount;
  json["single_precision"] = contents.single_precision;
  json["stamp_error_ns"] = contents.stamp_error.nanoseconds;
  return json;
}

}  // namespace

std::string listed(const std::vector<std::string>& words, std::string_view last) {
  std::string text;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (i > 0) text += i + 1 < words.size() ? ", " : fmt::format(" {} ", last);
    text += words[i];
  }
  return text;
}

std::vector<std::string> writable_log_formats(bool LogContents::*needed) {
  std::vector<std::string> names;
  for (const LogFormat& format : log_formats()) {
    const bool has_place = needed == nullptr || format.holds.*needed;
    if (format.can_be_written() && has_place) names.emplace_back(format.name);
  }
  return names;
}

std::string what_a_log_is() {
  std::string files;
  std::string folders;
  for (const LogFormat& format : log_formats()) {
    std::string& text = format.place == LogPlace::kFile ? files : folders;
    text += (text.empty() ? "" : "; ") + described(format);
  }
  return fmt::format("a file ({}) or a folder ({})", files, folders);
}

std::vector<std::string> log_name_meanings() {
  std::vector<std::string> meanings;
  std::vector<std::string> of_folders;
  for (const LogFormat& format : log_formats()) {
    if (!format.can_be_written()) continue;
    if (format.place == LogPlace::kFolder) {
      // Of several that are folders a name alone means the first.
      of_folders.push_back(of_folders.empty() ? folder_meaning(format)
                                              : fmt::format("a folder with --format {} is {}",
                                                            format.name, format.noun));
      continue;
    }
    std::string text = listed(strings_of(format.endings), "and");
    if (!format.packings.empty()) {
      text += ", also with " + listed(strings_of(format.packings), "or") + ",";
    }
    text += fmt::format(" {} {}", format.endings.size() == 1 ? "is" : "are", format.noun);
    meanings.push_back(std::move(text));
  }
  for (std::string& meaning : of_folders) meanings.push_back(std::move(meaning));
  return meanings;
}

std::string log_formats_text() {
  std::string text;
  for (const LogFormat& format : log_formats()) {
    if (!text.empty()) text += "\n";
    const auto line = [&](std::string_view label, const std::string& value) {
      text += fmt::format("  {:<8}{}\n", label, value);
    };
    text += fmt::format("{}\n", format.name);
    const char* const place = format.place == LogPlace::kFile ? "a file" : "a folder";
    line("is", fmt::format("{}, {} ({})", format.noun, place,
                           listed(strings_of(format.endings), "or") + packed_text(format)));
    line("can be", format.can_be_written() ? "read and written" : "read");
    line("holds", kinds_text(format.holds));
    line("", details_text(format.holds));
  }
  return text;
}

std::string log_formats_json() {
  using Json = nlohmann::ordered_json;
  Json json = {{"formats", Json::array()}};
  for (const LogFormat& format : log_formats()) {
    json["formats"].push_back({{"name", format.name},
                               {"title", format.title},
                               {"noun", format.noun},
                               {"is_folder", format.place == LogPlace::kFolder},
                               {"endings", strings_of(format.endings)},
                               {"packings", strings_of(format.packings)},
                               {"has_sets", format.has_sets},
                               {"from_pipes", format.reads_streams},
                               {"written", format.can_be_written()},
                               {"holds", contents_json(format.holds)}});
  }
  return json.dump(2) + "\n";
}

}  // namespace loopstone
