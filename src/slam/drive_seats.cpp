#include "slam/drive_seats.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "loopstone/geometry/angle.hpp"
#include "loopstone/slam/mapper.hpp"
#include "slam/scan_edges.hpp"

namespace loopstone {

namespace {

KeyScan seated(KeyScan key, const DriveSeat& seat) {
  key.stamp = key.stamp + seat.clock_shift;
  key.local_T_robot = seat.local_T_drive * key.local_T_robot;
  key.scan += seat.scan;
  return key;
}

MappedScan seated(MappedScan mapped, const DriveSeat& seat) {
  mapped.scan.stamp = mapped.scan.stamp + seat.clock_shift;
  mapped.index += seat.scan;
  mapped.local_T_robot = seat.local_T_drive * mapped.local_T_robot;
  mapped.local_T_robot_end = seat.local_T_drive * mapped.local_T_robot_end;
  return mapped;
}

/// What is known of where a drive begins that follows others, as Mapper::begin_drive() has it.
PathBreak break_before(const DriveRecord& drive, const DriveSeat& seat, Stamp from,
                       double reach_m) {
  const KeyScan first = seated(drive.back_end.chain.submaps.front().keys.front(), seat);
  return {.from = from,
          .to = first.stamp,
          .to_scan = first.scan,
          .cause = BreakCause::kNewDrive,
          .bridge = BreakBridge::kNothing,
          .covariance = planar_covariance(std::max(reach_m, kMapper.beside_m), kPi)};
}

}  // namespace

std::vector<DriveSeat> seats_of(std::span<const std::shared_ptr<const DriveRecord>> drives) {
  std::vector<DriveSeat> seats;
  DriveSeat next;
  Stamp ends{};
  double least_x = std::numeric_limits<double>::infinity();
  double most_x = -least_x;
  for (const auto& drive : drives) {
    DriveSeat seat = next;
    if (!seats.empty()) {
      const Stamp begins = ends + Duration::from_seconds(kMapper.between_drives_s);
      seat.clock_shift = begins - drive->track.front().stamp;
      seat.local_T_drive = {most_x + kMapper.beside_m, 0.0, 0.0};
      seat.before = break_before(*drive, seat, ends, seat.local_T_drive.x - least_x);
    }
    for (const TrackedPose& pose : drive->track) {
      least_x = std::min(least_x, seat.local_T_drive.x + pose.local_T_robot.x);
      most_x = std::max(most_x, seat.local_T_drive.x + pose.local_T_robot.x);
    }
    ends = drive->track.back().stamp + seat.clock_shift;
    const std::vector<SubmapRecord>& submaps = drive->back_end.chain.submaps;
    next.submap += submaps.size();
    next.scan += drive->track.size();
    next.piece += std::ranges::max(submaps, {}, &SubmapRecord::piece).piece + 1;
    seats.push_back(seat);
  }
  return seats;
}

KeyChain::State seated(const KeyChain::State& chain, const DriveSeat& seat) {
  KeyChain::State all = chain;
  for (SubmapRecord& submap : all.submaps) {
    for (KeyScan& key : submap.keys) key = seated(key, seat);
    SharedScans scans;
    submap.scans.for_each([&](const MappedScan& mapped) {
      scans.add(std::make_shared<const MappedScan>(seated(mapped, seat)));
    });
    submap.scans = std::move(scans);
    submap.piece += seat.piece;
    submap.closed_with.clear();
  }
  all.newest = seated(all.newest, seat);
  if (seat.scan == 0) return all;
  KeyScan& first = all.submaps.front().keys.front();
  first.starts_drive = true;
  first.across = seat.before.covariance;
  return all;
}

PathBreak seated(PathBreak gap, const DriveSeat& seat) {
  gap.from = gap.from + seat.clock_shift;
  gap.to = gap.to + seat.clock_shift;
  gap.to_scan += seat.scan;
  return gap;
}

TrackedPose seated(TrackedPose pose, const DriveSeat& seat) {
  pose.stamp = pose.stamp + seat.clock_shift;
  pose.local_T_robot = seat.local_T_drive * pose.local_T_robot;
  return pose;
}

}  // namespace loopstone
