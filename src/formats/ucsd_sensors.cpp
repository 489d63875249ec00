#include "formats/ucsd_sensors.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "loopstone/base/error.hpp"
#include "loopstone/base/median.hpp"

namespace loopstone {
namespace {

constexpr double kStandardGravity_m_s2 = 9.80665;

/// Leaves out the records for which `is_good` is false.
template <typename Predicate>
void refuse_bad(KeptStamps& kept, const std::string& reason, Predicate is_good) {
  KeptStamps result;
  result.refused = std::move(kept.refused);
  for (std::size_t i = 0; i < kept.indices.size(); ++i) {
    if (is_good(kept.indices[i])) {
      result.stamps.push_back(kept.stamps[i]);
      result.indices.push_back(kept.indices[i]);
    } else {
      result.refused.push_back({kept.indices[i], reason, {}});
    }
  }
  std::sort(result.refused.begin(), result.refused.end(),
            [](const auto& a, const auto& b) { return a.index < b.index; });
  kept = std::move(result);
}

double median_norm(const UcsdMatrix& matrix, const KeptStamps& kept) {
  std::vector<double> norms;
  for (const std::int64_t i : kept.indices) {
    norms.push_back(std::hypot(matrix.at(0, i), matrix.at(1, i), matrix.at(2, i)));
  }
  return median_of(norms);
}

}  // namespace

std::string shape_text(const std::vector<std::int64_t>& shape) {
  if (shape.empty()) return "a single number";
  std::string text;
  for (const std::int64_t size : shape) text += (text.empty() ? "" : " x ") + std::to_string(size);
  return shape.size() == 1 ? "a row of " + text : text;
}

std::vector<double> read_ucsd_stamps(const NpzFile& file, const std::string& path,
                                     const std::string& key) {
  NpyArray array = file.read(key);
  const bool is_a_row = array.shape.size() == 1 ||
                        (array.shape.size() == 2 && (array.shape[0] == 1 || array.shape[1] == 1));
  if (!is_a_row) {
    throw DataError({path},
                    key + " is " + shape_text(array.shape) + ", a row of stamps was expected");
  }
  return std::move(array.values);
}

UcsdMatrix read_ucsd_matrix(const NpzFile& file, const std::string& path, const std::string& key,
                            std::int64_t components, std::int64_t records) {
  UcsdMatrix matrix{file.read(key)};
  const auto& shape = matrix.array.shape;
  const bool fits = shape.size() == 2 && shape[0] == components && shape[1] == records;
  matrix.records_are_rows =
      !fits && shape.size() == 2 && shape[0] == records && shape[1] == components;
  if (!fits && !matrix.records_are_rows) {
    throw DataError({path}, key + " is " + shape_text(shape) + ", but " +
                                std::to_string(components) + " x " + std::to_string(records) +
                                " was expected: one column for each stamp");
  }
  return matrix;
}

UcsdChannel open_ucsd_encoders(const NpzFile& file, const std::string& path) {
  UcsdChannel channel{path};
  const std::vector<double> seconds = read_ucsd_stamps(file, path);
  const auto counts = std::make_shared<UcsdMatrix>(
      read_ucsd_matrix(file, path, "counts", 4, static_cast<std::int64_t>(seconds.size())));
  channel.kept = keep_increasing(seconds);
  refuse_bad(channel.kept, "a wheel count is no number", [&](std::int64_t i) {
    // Up to 2^53 a double holds every whole number.
    for (int wheel = 0; wheel < 4; ++wheel) {
      if (!(std::abs(counts->at(wheel, i)) <= 9007199254740992.0)) return false;
    }
    return true;
  });
  channel.make = [counts](Stamp stamp, std::int64_t i) {
    WheelTicks ticks{stamp};
    for (int wheel = 0; wheel < 4; ++wheel) {
      ticks.counts[static_cast<std::size_t>(wheel)] = std::llround(counts->at(wheel, i));
    }
    return ticks;
  };
  return channel;
}

UcsdChannel open_ucsd_imu(const NpzFile& file, const std::string& path) {
  UcsdChannel channel{path};
  const std::vector<double> seconds = read_ucsd_stamps(file, path);
  const auto records = static_cast<std::int64_t>(seconds.size());
  const auto rates =
      std::make_shared<UcsdMatrix>(read_ucsd_matrix(file, path, "angular_velocity", 3, records));
  const auto accelerations =
      std::make_shared<UcsdMatrix>(read_ucsd_matrix(file, path, "linear_acceleration", 3, records));
  channel.kept = keep_increasing(seconds);
  refuse_bad(channel.kept, "a reading is not finite", [&](std::int64_t i) {
    for (int axis = 0; axis < 3; ++axis) {
      if (!std::isfinite(rates->at(axis, i)) || !std::isfinite(accelerations->at(axis, i))) {
        return false;
      }
    }
    return true;
  });
  const double at_rest = median_norm(*accelerations, channel.kept);
  const bool in_g = at_rest > 0.5 && at_rest < 2.0;
  if (in_g) channel.notes.emplace_back("the accelerations are in g; they are turned into m/s^2");
  if (!in_g && !channel.kept.stamps.empty() && !(at_rest > 5.0 && at_rest < 20.0)) {
    channel.notes.emplace_back(
        "the accelerations are neither in g nor in m/s^2: gravity can't be seen in them");
  }
  const double unit_m_s2 = in_g ? kStandardGravity_m_s2 : 1.0;
  channel.make = [rates, accelerations, unit_m_s2](Stamp stamp, std::int64_t i) {
    ImuSample sample{stamp};
    for (int axis = 0; axis < 3; ++axis) {
      sample.angular_velocity_rad_s[axis] = rates->at(axis, i);
      sample.linear_acceleration_m_s2[axis] = accelerations->at(axis, i) * unit_m_s2;
    }
    return sample;
  };
  return channel;
}

UcsdChannel open_ucsd_odometry(const NpzFile& file, const std::string& path) {
  UcsdChannel channel{path};
  const std::vector<double> seconds = read_ucsd_stamps(file, path);
  const auto poses = std::make_shared<UcsdMatrix>(
      read_ucsd_matrix(file, path, "poses", 3, static_cast<std::int64_t>(seconds.size())));
  channel.kept = keep_increasing(seconds);
  refuse_bad(channel.kept, "a pose is not finite, or more than 10,000 km away",
             [&](std::int64_t i) {
               constexpr double kMost = 1e7;  // written so that NaN is more
               return std::abs(poses->at(0, i)) <= kMost && std::abs(poses->at(1, i)) <= kMost &&
                      std::abs(poses->at(2, i)) <= kMost;
             });
  channel.make = [poses](Stamp stamp, std::int64_t i) {
    return OdometryPose{stamp, {poses->at(0, i), poses->at(1, i), wrap_angle(poses->at(2, i))}};
  };
  return channel;
}

}  // namespace loopstone
