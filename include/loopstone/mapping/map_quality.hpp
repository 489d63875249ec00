#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "loopstone/base/parallel_for.hpp"
#include "loopstone/mapping/occupancy.hpp"
#include "loopstone/mapping/visit_contradiction.hpp"

namespace loopstone {

// How good is a map when nobody knows the truth? A map is a claim about many visits to the same
// places. What can be checked is whether they agree: each wall should lie where the other visits
// put it, no beam should pass through a wall that another visit hit, and what one visit sees the
// others should foretell. Within a visit poses agree because each scan was aligned to the ones
// before; so only scans that are some stretches of travel apart (kMapQuality) are compared.
//
// What can't be seen this way: a map that is wrong everywhere alike (its scale), a stretch that was
// travelled once, two places that look the same and were taken for one.

/// What the judgement of a map decides by.
struct MapQualityNumbers {
  double stretch_m = 4.0;
  int stretches_apart = 3;
  double place_m = 0.5;
  double most_offset_m = 0.5;
  double doubled_m = 0.10;
  double tolerance_m = 0.05;
  double tolerance_sigmas = 3.0;
  double margin_sigmas = 6.0;
};
inline constexpr MapQualityNumbers kMapQuality{};

template <typename Visitor>
void visit_numbers(const MapQualityNumbers& n, Visitor&& visit) {
  visit("stretch_m", n.stretch_m, "chosen: travel within which poses agree with one another");
  visit("stretches_apart", n.stretches_apart,
        "derived: at least 8 m, on average 12 m of travel between two visits");
  visit("place_m", n.place_m, "chosen: side of a place of the picture");
  visit("most_offset_m", n.most_offset_m,
        "chosen: farther apart, two walls that face the same way are not taken for one");
  visit("doubled_m", n.doubled_m,
        "derived: two cells of a map of 5 cm, from where on a wall is drawn twice");
  visit("tolerance_m", n.tolerance_m,
        "derived: the side of a map's cell, by which a return may lie off a wall");
  visit("tolerance_sigmas", n.tolerance_sigmas,
        "chosen: the same in standard deviations of the scanner's noise, if that is more");
  visit("margin_sigmas", n.margin_sigmas,
        "chosen: so far behind a wall a beam has gone through it, and doubled_m at least");
}

/// A place that holds walls, and what the visits say about it.
struct QualityPlace {
  Eigen::Vector2f centre = Eigen::Vector2f::Zero();  ///< map frame [m]
  std::int32_t compared = 0;                         ///< pairs of visits that both saw a wall here
  float offset_m = 0.0F;                             ///< mean distance between the two
  std::int32_t beams = 0;    ///< of one visit that met a wall of another here
  std::int32_t crossed = 0;  ///< of them, those that went through it

  [[nodiscard]] bool is_doubled() const {
    return offset_m > static_cast<float>(kMapQuality.doubled_m);
  }
  /// At least a quarter of a few beams: one beam through the gap under a door is nothing.
  [[nodiscard]] bool is_crossed() const { return crossed >= 4 && 4 * crossed >= beams; }
};

/// What a map's scans say about each other at their final poses. Figures rest on the counts beside
/// them: where a count is 0 the figure says nothing.
struct MapQuality {
  std::int64_t scans = 0;   ///< that were judged
  std::int64_t visits = 0;  ///< stretches of travel

  std::int64_t returns = 0;  ///< that lie on a piece of wall
  double sensor_noise_m =
      0.0;  ///< of one return about its neighbours in the same scan, standard deviation
  double local_spread_m =
      0.0;  ///< of scans about the wall of their own stretch, standard deviation

  std::int64_t walls_compared = 0;   ///< pieces of wall in pairs of visits
  double wall_offset_m = 0.0;        ///< between the same wall in two visits, median
  double wall_offset_worst_m = 0.0;  ///< the same, 95 of 100 are below
  double doubled_share = 0.0;        ///< of them, farther apart than kMapQuality.doubled_m
  /// Of all returns about the one wall that they show: noise, own stretch and between visits
  /// together, standard deviation.
  double wall_thickness_m = 0.0;

  std::int64_t entropy_points = 0;
  double entropy_nats = 0.0;       ///< mean map entropy
  double entropy_gain_nats = 0.0;  ///< of the whole map over a single stretch, at the same points

  std::int64_t beams_tested = 0;  ///< that met a wall of another visit
  double crossed_share = 0.0;     ///< of them, went through it

  std::int64_t held_out_returns = 0;  ///< of held-out scans, where other visits have a say
  double held_out_agreement = 0.0;    ///< of them, share that the other visits' walls foretell

  std::vector<QualityPlace> places{};  ///< all that hold walls, by rows of blocks
  /// Where two visits contradict each other over some metres of wall, the worst first.
  std::vector<VisitContradiction> contradictions{};
  std::vector<VisitTie> agreeing{};  ///< visits far apart along the path that agree, in time order

  [[nodiscard]] std::size_t places_revisited() const;
  /// Doubled or crossed.
  [[nodiscard]] std::size_t places_in_trouble() const;
};

/// Judges the scans of a map against each other. Scans that add little are left out, and more than
/// some thousands are thinned, so the cost does not grow without bound.
///
///   1. Every scan is read as surfaces (surface_points); the noise of its returns shows against
///      their neighbours.
///   2. The surfaces of a stretch of travel become pieces of wall, 10 cm long.
///   3. Each piece is compared with the nearest piece of every other visit that faces the same way:
///      wall offsets.
///   4. Beams that pass a piece of another visit from front to back are violations of free space.
///   5. Every fourth scan is held out: do other visits have a wall where it has returns?
///   6. Where two visits contradict each other: connected regions, with both times.
///   7. Mean map entropy of the returns, of the whole map and of the stretch alone.
///
/// \param scans  in time order, at final poses; those without a scan are left out
/// Deterministic: the same bytes for any number of threads. Cost: about 0.1 ms a judged scan of 180
/// beams.
/// Sources: Droeschel, Stueckler and Behnke 2014, "Local multi-resolution representation for 6D
/// motion estimation and mapping with a continuously rotating 3D laser scanner", and Razlaw et al.
/// 2015, "Evaluation of registration methods for sparse 3D laser scans" (mean map entropy);
/// Haehnel, Schulz and Burgard 2002, "Map building with mobile robots in populated environments"
/// (beams that contradict hits).
[[nodiscard]] MapQuality assess_map(std::span<const PosedScan> scans, Threads threads = {});

}  // namespace loopstone
