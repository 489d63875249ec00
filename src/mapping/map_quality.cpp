#include "loopstone/mapping/map_quality.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "loopstone/base/median.hpp"
#include "loopstone/grid/block_grid.hpp"
#include "mapping/judged_scans.hpp"
#include "mapping/map_entropy.hpp"
#include "mapping/visit_agreement.hpp"
#include "mapping/visit_contradictions.hpp"
#include "mapping/wall_pieces.hpp"

namespace loopstone {
namespace {

/// A distance between two visits has the error of both.
const double kTwoVisits = std::sqrt(2.0);

struct PlaceSums {
  double offset_m = 0.0;
  std::int32_t compared = 0;
  std::int32_t beams = 0;
  std::int32_t crossed = 0;
  bool wall = false;
};

struct Walls {
  std::vector<WallPiece> pieces{};
  std::vector<float> spread_m{};
  int stretches = 0;
};

/// The scans of each stretch, one after the other.
std::vector<std::span<const JudgedScan>> by_stretch(const std::vector<JudgedScan>& scans) {
  std::vector<std::span<const JudgedScan>> runs;
  for (std::size_t first = 0; first < scans.size();) {
    std::size_t end = first;
    while (end < scans.size() && scans[end].stretch == scans[first].stretch) ++end;
    runs.emplace_back(&scans[first], end - first);
    first = end;
  }
  return runs;
}

Walls walls_of(const std::vector<JudgedScan>& scans, Threads threads) {
  const auto runs = by_stretch(scans);
  std::vector<StretchWalls> parts(runs.size());
  parallel_for(runs.size(), threads, [&](std::size_t i) { parts[i] = stretch_walls(runs[i]); });
  Walls walls;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const int stretch = runs[i].front().stretch;
    walls.stretches = stretch + 1;
    walls.pieces.insert(walls.pieces.end(), parts[i].pieces.begin(), parts[i].pieces.end());
    walls.spread_m.insert(walls.spread_m.end(), parts[i].spread_m.begin(), parts[i].spread_m.end());
  }
  return walls;
}

double sigma_of(std::vector<float>& absolute) {
  return kSigmaPerMedian * static_cast<double>(median_of(absolute));
}

void add_offsets(const std::vector<WallOffset>& offsets, MapQuality& quality) {
  quality.walls_compared = static_cast<std::int64_t>(offsets.size());
  if (offsets.empty()) return;
  std::vector<float> values;
  values.reserve(offsets.size());
  for (const WallOffset& offset : offsets) values.push_back(offset.offset_m);
  quality.wall_offset_m = static_cast<double>(median_of(values));
  const auto worst = values.begin() + static_cast<std::ptrdiff_t>(values.size() * 95 / 100);
  std::nth_element(values.begin(), worst, values.end());
  quality.wall_offset_worst_m = static_cast<double>(*worst);
  const auto doubled = std::count_if(values.begin(), values.end(), [](float value) {
    return value > static_cast<float>(kMapQuality.doubled_m);
  });
  quality.doubled_share = static_cast<double>(doubled) / static_cast<double>(values.size());
}

void add_places(const std::vector<WallPiece>& pieces, const std::vector<WallOffset>& offsets,
                const std::vector<BeamMeeting>& meetings, MapQuality& quality) {
  BlockGrid<PlaceSums> places(kMapQuality.place_m);
  const auto at = [&](const Eigen::Vector2f& point) -> PlaceSums& {
    return places.at(
        places.cell_of(static_cast<double>(point.x()), static_cast<double>(point.y())));
  };
  for (const WallPiece& piece : pieces) at(piece.position).wall = true;
  for (const WallOffset& offset : offsets) {
    PlaceSums& place = at(offset.where);
    place.offset_m += static_cast<double>(offset.offset_m);
    ++place.compared;
  }
  for (const BeamMeeting& meeting : meetings) {
    PlaceSums& place = at(meeting.where);
    ++place.beams;
    if (meeting.crossed >= 0) ++place.crossed;
  }
  places.for_each([&](Cell cell, const PlaceSums& sums) {
    if (!sums.wall) return;
    quality.places.push_back(
        {.centre = places.centre_of(cell).cast<float>(),
         .compared = sums.compared,
         .offset_m = sums.compared > 0 ? static_cast<float>(sums.offset_m / sums.compared) : 0.0F,
         .beams = sums.beams,
         .crossed = sums.crossed});
  });
}

}  // namespace

std::size_t MapQuality::places_revisited() const {
  return static_cast<std::size_t>(
      std::count_if(places.begin(), places.end(),
                    [](const auto& place) { return place.compared > 0 || place.beams > 0; }));
}

std::size_t MapQuality::places_in_trouble() const {
  return static_cast<std::size_t>(
      std::count_if(places.begin(), places.end(),
                    [](const auto& place) { return place.is_doubled() || place.is_crossed(); }));
}

MapQuality assess_map(std::span<const PosedScan> scans, Threads threads) {
  MapQuality quality;
  const auto judged = judged_scans(scans, threads);
  quality.scans = static_cast<std::int64_t>(judged.size());
  if (judged.empty()) return quality;

  std::vector<float> noise_m;
  for (const JudgedScan& scan : judged) {
    quality.returns += static_cast<std::int64_t>(scan.returns.size());
    noise_m.insert(noise_m.end(), scan.noise_m.begin(), scan.noise_m.end());
  }
  quality.sensor_noise_m = sigma_of(noise_m);

  Walls walls = walls_of(judged, threads);
  quality.visits = walls.stretches;
  quality.local_spread_m = sigma_of(walls.spread_m);
  const PieceIndex index(std::move(walls.pieces), kWallPieces.piece_m);

  const auto offsets = wall_offsets(index, walls.stretches, threads);
  add_offsets(offsets, quality);
  const double between_m = kSigmaPerMedian * quality.wall_offset_m / kTwoVisits;
  quality.wall_thickness_m = std::hypot(quality.sensor_noise_m, quality.local_spread_m, between_m);

  const double margin_m =
      std::max(kMapQuality.doubled_m, kMapQuality.margin_sigmas * quality.sensor_noise_m);
  const auto meetings = beam_meetings(judged, index, static_cast<float>(margin_m), threads);
  const auto crossed =
      std::count_if(meetings.begin(), meetings.end(),
                    [](const BeamMeeting& meeting) { return meeting.crossed >= 0; });
  quality.beams_tested = static_cast<std::int64_t>(meetings.size());
  if (!meetings.empty()) {
    quality.crossed_share = static_cast<double>(crossed) / static_cast<double>(meetings.size());
  }

  const double tolerance_m =
      std::max(kMapQuality.tolerance_m, kMapQuality.tolerance_sigmas * quality.sensor_noise_m);
  std::vector<std::uint8_t> looked_through(index.items().size(), 0);
  for (const BeamMeeting& meeting : meetings) {
    if (meeting.crossed >= 0) looked_through[static_cast<std::size_t>(meeting.crossed)] = 1;
  }
  const HeldOut held =
      held_out_agreement(judged, index, looked_through, static_cast<float>(tolerance_m), threads);
  quality.held_out_returns = held.foretold + held.missed;
  if (quality.held_out_returns > 0) {
    quality.held_out_agreement =
        static_cast<double>(held.foretold) / static_cast<double>(quality.held_out_returns);
  }

  const MapEntropy entropy = map_entropy(judged, threads);
  quality.entropy_points = entropy.points;
  quality.entropy_nats = entropy.mean_nats;
  quality.entropy_gain_nats = entropy.mean_nats - entropy.stretch_nats;

  add_places(index.items(), offsets, meetings, quality);
  const StretchTimes times = stretch_times(judged);
  quality.contradictions = visit_contradictions(offsets, meetings, times);
  quality.agreeing = agreeing_visits(offsets, meetings, times);
  return quality;
}

}  // namespace loopstone
