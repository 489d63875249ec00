#include "formats/carmen_times.hpp"

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <string>
#include <utility>

#include "formats/stamp_order.hpp"

namespace loopstone {
namespace {

using Scan = CarmenTimesSample::Scan;
using Stretch = std::vector<Scan>;
using TimeOf = std::function<std::optional<Stamp>(const Scan&)>;

/// Fewer say nothing.
constexpr std::size_t kFewestScans = 5;
/// A log that would lose more scans by its stamps is better read without them.
constexpr double kMostLost = 0.2;
/// No laser of a map is slower [s].
constexpr double kLongestStep_s = 2.0;
/// A SICK LMS at 38,400 baud, as in most recordings by CARMEN: 4.7 to 5.4 in Intel, ACES, MIT.
constexpr double kSickRateHz = 5.0;
constexpr double kUsualRateHz = 10.0;

std::optional<Stamp> header_of(const Scan& scan) { return scan.times.header; }
std::optional<Stamp> logger_of(const Scan& scan) { return scan.times.logger; }

template <typename Value>
Value median(std::vector<Value> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

std::vector<Stamp> times_of(const Stretch& stretch, const TimeOf& time_of) {
  std::vector<Stamp> times;
  for (const Scan& scan : stretch) {
    if (const auto time = time_of(scan)) times.push_back(*time);
  }
  return times;
}

std::size_t scans_of(const CarmenTimesSample& sample) {
  std::size_t scans = 0;
  for (const Stretch& stretch : sample.stretches()) scans += stretch.size();
  return scans;
}

/// Scans of a stretch that the reader would skip.
std::size_t lost_within(const Stretch& stretch, const TimeOf& time_of) {
  std::size_t lost = 0;
  StampOrder order(true, std::nullopt, [&](const OrderedRecord&, const std::string&) { ++lost; });
  for (const Scan& scan : stretch) {
    const auto time = time_of(scan);
    if (!time) {
      ++lost;
      continue;
    }
    LaserScan message;
    message.stamp = *time;
    message.lidar = lidar_of(scan.tag);
    order.push({std::move(message)});
    while (order.pop()) {
    }
  }
  order.close();
  while (order.pop()) {
  }
  return lost;
}

/// The share of the sample that the reader would skip. Stretches may overlap, so that between them
/// only their middles are compared.
double lost_share(const CarmenTimesSample& sample, const TimeOf& time_of) {
  std::size_t lost = 0;
  std::optional<Stamp> newest;
  for (const Stretch& stretch : sample.stretches()) {
    const std::vector<Stamp> times = times_of(stretch, time_of);
    const auto middle = times.empty() ? std::nullopt : std::optional<Stamp>(median(times));
    const bool goes_back = middle && newest && *middle + StampOrder::kWindow < *newest;
    lost += goes_back ? stretch.size() : lost_within(stretch, time_of);
    if (middle && (!newest || *middle > *newest)) newest = middle;
  }
  return static_cast<double>(lost) /
         static_cast<double>(std::max<std::size_t>(scans_of(sample), 1));
}

/// The same time in all scans.
bool stands_still(const CarmenTimesSample& sample, const TimeOf& time_of) {
  std::optional<Stamp> first;
  for (const Stretch& stretch : sample.stretches()) {
    for (const Scan& scan : stretch) {
      const auto time = time_of(scan);
      if (!time) return false;
      if (!first) first = time;
      if (*time != *first) return false;
    }
  }
  return first.has_value();
}

bool has_all(const CarmenTimesSample& sample, const TimeOf& time_of) {
  for (const Stretch& stretch : sample.stretches()) {
    if (times_of(stretch, time_of).size() != stretch.size()) return false;
  }
  return true;
}

/// Stamps of another kind than seconds are refused, not replaced.
bool is_malformed(const CarmenTimesSample& sample) {
  std::size_t malformed = 0;
  for (const Stretch& stretch : sample.stretches()) {
    for (const Scan& scan : stretch) {
      if (!scan.times.header && !scan.times.absent) ++malformed;
    }
  }
  return 2 * malformed > scans_of(sample);
}

/// What is wrong with the scans' own stamps; empty when they can be used.
std::string fault_of_headers(const CarmenTimesSample& sample) {
  if (scans_of(sample) < kFewestScans || is_malformed(sample)) return {};
  const double lost = lost_share(sample, header_of);
  if (lost <= kMostLost) return {};
  std::size_t absent = 0;
  for (const Stretch& stretch : sample.stretches()) {
    absent += static_cast<std::size_t>(
        std::count_if(stretch.begin(), stretch.end(),
                      [](const Scan& scan) { return !scan.times.header.has_value(); }));
  }
  if (absent == scans_of(sample)) return "no scan has a stamp";
  if (stands_still(sample, header_of)) return "all scans have the same stamp";
  char text[120];
  std::snprintf(
      text, sizeof text,
      "the scans' stamps repeat or run to and fro (by them %.0f %% of the scans that were "
      "looked at would be lost)",
      100.0 * lost);
  return text;
}

/// Mean step between the scans of a lidar [s], of steps that a laser can have; nothing when they
/// are not the most.
std::optional<double> mean_step_s(const CarmenTimesSample& sample, const TimeOf& time_of) {
  double sum_s = 0.0;
  std::size_t good = 0;
  std::size_t all = 0;
  for (const Stretch& stretch : sample.stretches()) {
    std::array<std::optional<Stamp>, kCarmenLidars> last{};
    for (const Scan& scan : stretch) {
      auto& before = last[static_cast<std::size_t>(lidar_of(scan.tag))];
      const auto time = time_of(scan);
      if (before && time) {
        const double step_s = time->seconds() - before->seconds();
        ++all;
        if (step_s >= 0.0 && step_s <= kLongestStep_s) {
          ++good;
          sum_s += step_s;
        }
      }
      before = time;
    }
  }
  constexpr double kShortestStep_s = 0.001;
  if (good + 1 < kFewestScans || 2 * good < all) return std::nullopt;
  const double mean_s = sum_s / static_cast<double>(good);
  return mean_s >= kShortestStep_s ? std::optional(mean_s) : std::nullopt;
}

void choose_rate(const CarmenTimesSample& sample, CarmenSurvey& survey) {
  if (const auto step_s = mean_step_s(sample, header_of)) {
    survey.scan_rate_hz = 1.0 / *step_s;
    survey.rate_origin = "the mean step of their stamps";
  } else if (const auto written_s = mean_step_s(sample, logger_of)) {
    survey.scan_rate_hz = 1.0 / *written_s;
    survey.rate_origin = "the mean step of the logger's times";
  } else if (sample.is_of_a_sick()) {
    survey.scan_rate_hz = kSickRateHz;
    survey.rate_origin = "the usual rate of a SICK laser at a serial line; the log does not tell";
  } else {
    survey.scan_rate_hz = kUsualRateHz;
    survey.rate_origin = "a usual rate of lasers; the log does not tell";
  }
}

StampUse stamps_for(const CarmenTimesSample& sample, CarmenSurvey& survey) {
  // Few scans are enough to see that a clock was never set.
  const bool never_set = stands_still(sample, header_of);
  const bool logger_goes_on = has_all(sample, logger_of) && !stands_still(sample, logger_of) &&
                              lost_share(sample, logger_of) <= kMostLost;
  survey.stamp_fault = fault_of_headers(sample);
  if (never_set && logger_goes_on) survey.stamp_fault = "all scans have the same stamp";
  if (survey.stamp_fault.empty()) return StampUse::kHeader;
  return logger_goes_on ? StampUse::kRecord : StampUse::kOrder;
}

}  // namespace

void CarmenTimesSample::add(const CarmenScan& scan) {
  if (!first_) {
    first_ = scan.tag;
    is_of_a_sick_ = !scan.beams || scan.beams->laser_type == 0 || scan.beams->laser_type == 1;
  }
  auto& tag = tags_[static_cast<std::size_t>(lidar_of(scan.tag))];
  if (!tag) tag = scan.tag;
  if (*tag == scan.tag) stretches_.back().push_back({scan.tag, scan.times});
}

void choose_stamps(const CarmenTimesSample& sample, StampUse wanted, CarmenSurvey& survey) {
  survey.stamps = wanted == StampUse::kAuto ? stamps_for(sample, survey) : wanted;
  if (survey.stamps == StampUse::kOrder) choose_rate(sample, survey);
  if (survey.stamps != StampUse::kHeader && survey.any_scan) survey.any_record = true;
  const TimeOf time_of = survey.stamps == StampUse::kRecord ? logger_of : header_of;
  if (sample.stretches().empty()) return;
  const std::vector<Stamp> early = times_of(sample.stretches().front(), time_of);
  if (!early.empty()) survey.early_stamp = median(early);
}

}  // namespace loopstone
