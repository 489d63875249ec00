#include "loopstone/slam/session.hpp"

#include <fmt/format.h>

#include <sstream>

namespace loopstone {

namespace {

/// "front_end.points_max = 360" where two texts of the same keys first differ; empty where they
/// don't.
std::string differing_line(const std::string& was, const std::string& is) {
  std::istringstream old_lines(was);
  std::istringstream new_lines(is);
  std::string group;
  std::string before;
  std::string now;
  while (true) {
    const bool more_old = static_cast<bool>(std::getline(old_lines, before));
    const bool more_new = static_cast<bool>(std::getline(new_lines, now));
    if (!more_old && !more_new) return {};
    if (!more_old || !more_new) return "one has more than the other";
    if (before != now) return fmt::format("{}`{}` then, `{}` now", group, before, now);
    if (now.starts_with('[')) group = now + " ";
  }
}

}  // namespace

std::string difference(const SessionTerms& session, const SessionTerms& now) {
  const auto differs = [](const char* what, const auto& then, const auto& now_is) {
    return fmt::format("{}: {} then, {} now", what, then, now_is);
  };
  if (session.version != now.version) return differs("loopstone", session.version, now.version);
  std::string line = differing_line(session.options_toml, now.options_toml);
  if (!line.empty()) return "options: " + line;
  line = differing_line(session.robot_toml, now.robot_toml);
  if (!line.empty()) return "robot: " + line;
  if (session.mounts_from_log != now.mounts_from_log) {
    return differs("--robot", session.mounts_from_log ? "not given" : "given",
                   now.mounts_from_log ? "not given" : "given");
  }
  if (session.start_s != now.start_s) return differs("--start", session.start_s, now.start_s);
  if (session.duration_s != now.duration_s)
    return differs("--duration", session.duration_s, now.duration_s);
  if (session.max_scans != now.max_scans)
    return differs("--max-scans", session.max_scans, now.max_scans);
  return {};
}

}  // namespace loopstone
