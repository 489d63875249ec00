#include "loopstone/report/site_recording.hpp"

#include <fmt/format.h>

#include <cstddef>
#include <utility>
#include <vector>

#include "formats/topic_names.hpp"
#include "formats/topic_writer.hpp"
#include "loopstone/base/thinned.hpp"
#include "report/drive_part.hpp"
#include "report/map_messages.hpp"
#include "report/site_masks.hpp"
#include "report/written_states.hpp"

namespace loopstone {

void write_site_recording(const MapResult& result, std::span<const SiteSession> sessions,
                          const Grid<float>& movable, const std::string& path) {
  constexpr std::size_t kMostPoses = 20'000;
  TopicWriter writer(create_mcap(path));
  const auto& poses = result.trajectory.poses();
  const Stamp begin = poses.empty() ? Stamp{} : poses.front().stamp;
  const auto send = [&](const std::string& topic, const auto& message) {
    writer.send(topic, begin, message, true);
  };
  send("/map", to_message(states_to_write(result.map), begin));
  send("/movable", to_message(movable_mask(movable, result.map), begin));
  for (std::size_t i = 0; i < sessions.size(); ++i) {
    const auto [first, end] = part_of_drive(result, i, poses, &StampedPose2::stamp);
    const std::span<const StampedPose2> own = std::span(poses).subspan(first, end - first);
    send(fmt::format("/session_{}/path", sessions[i].id),
         path_message(thinned(own, kMostPoses), begin));
  }
  send("/loop_closures", closure_markers(closure_lines(result), begin));
  send("/verdict", msg::DiagnosticArray{.header = {begin, ""}, .status = diagnostics_of(result)});
  for (const StampedPose2& at : poses) {
    writer.send("/tf", at.stamp,
                msg::TFMessage{{transform_message(at.stamp, kMapFrame, kBaseFrame, at.pose)}});
  }
  writer.finish();
}

}  // namespace loopstone
