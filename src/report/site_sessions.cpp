#include <fmt/format.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <iterator>
#include <span>
#include <string>

#include "formats/atomic_file.hpp"
#include "loopstone/pipeline/site.hpp"
#include "loopstone/report/site_recording.hpp"
#include "report/drive_part.hpp"
#include "report/mask_files.hpp"

namespace loopstone {

namespace {

std::string csv_text(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

}  // namespace

std::string format_site_sessions(const MapResult& result, std::span<const SiteSession> sessions) {
  std::string text = "session,begins,trajectory,clock_shift_s,first_node,nodes,closures,log\n";
  for (std::size_t i = 0; i < sessions.size(); ++i) {
    const auto [first, end] = part_of_drive(result, i, result.node_stamps, std::identity{});
    // A site of one session has one trajectory.
    const std::string trajectory =
        result.drives.empty() ? "trajectory.tum" : drive_trajectory_name(i);
    fmt::format_to(std::back_inserter(text), "{},{},{},{:.9f},{},{},{},{}\n", sessions[i].id,
                   utc_text(sessions[i].begins), trajectory,
                   static_cast<double>(result.clock_shift(i).nanoseconds) * 1e-9, first,
                   end - first, sessions[i].closures, csv_text(sessions[i].log));
  }
  return text;
}

void write_site_sessions(const MapResult& result, std::span<const SiteSession> sessions,
                         const std::string& folder) {
  make_folder(folder);
  write_file_atomically(folder + "/sessions.csv", format_site_sessions(result, sessions));
}

}  // namespace loopstone
