#include "report/motion_profile.hpp"

#include <algorithm>

namespace loopstone {

MotionProfile motion_profile(const Trajectory& trajectory, int most_spans) {
  MotionProfile profile;
  if (trajectory.size() < 2) return profile;
  const auto& poses = trajectory.poses();
  const Stamp start = trajectory.front().stamp;
  const double duration_s = (trajectory.back().stamp - start).seconds();
  const auto spans = static_cast<std::size_t>(
      std::min<std::int64_t>(most_spans, static_cast<std::int64_t>(poses.size()) - 1));
  const double span_s = duration_s / static_cast<double>(spans);
  struct Sum {
    double forward_m = 0.0;
    double turn_rad = 0.0;
    double time_s = 0.0;
  };
  std::vector<Sum> sums(spans);
  for (std::size_t i = 1; i < poses.size(); ++i) {
    const double middle_s =
        0.5 * ((poses[i].stamp - start).seconds() + (poses[i - 1].stamp - start).seconds());
    const Tangent2 motion = log(poses[i - 1].pose.inverse() * poses[i].pose);
    Sum& sum = sums[std::min(static_cast<std::size_t>(middle_s / span_s), spans - 1)];
    sum.forward_m += motion.x();
    sum.turn_rad += motion.z();
    sum.time_s += (poses[i].stamp - poses[i - 1].stamp).seconds();
  }
  for (std::size_t i = 0; i < spans; ++i) {
    if (!(sums[i].time_s > 0.0)) continue;
    profile.time_s.push_back((static_cast<double>(i) + 0.5) * span_s);
    profile.speed_m_s.push_back(sums[i].forward_m / sums[i].time_s);
    profile.yaw_rate_rad_s.push_back(sums[i].turn_rad / sums[i].time_s);
  }
  return profile;
}

}  // namespace loopstone
