#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "loopstone/base/parallel_for.hpp"
#include "mapping/judged_scans.hpp"
#include "mapping/wall_pieces.hpp"

// What one visit says about the walls of the others.

namespace loopstone {

/// What visits are compared by.
struct VisitAgreementNumbers {
  int most_pieces = 20000;
  double beside_m = 0.07;
  double along_m = 0.1;
  double least_incidence = 0.34;
  double most_beam_m = 12.0;
  int held_out_every = 4;
};
inline constexpr VisitAgreementNumbers kVisitAgreement{};

template <typename Visitor>
void visit_numbers(const VisitAgreementNumbers& n, Visitor&& visit) {
  visit("most_pieces", n.most_pieces, "chosen: bounds the cost; pieces that look for others");
  visit("beside_m", n.beside_m,
        "chosen: pieces lie beside each other when they overlap by a good part of their length");
  visit("along_m", n.along_m, "chosen: a return belongs to a piece this near along the wall");
  visit("least_incidence", n.least_incidence,
        "derived: cosine of 70 deg from a wall's normal; beams along a wall pass it or not by a "
        "hair");
  visit("most_beam_m", n.most_beam_m,
        "chosen: beyond, a small error of heading makes a beam pass a door post on the wrong side");
  visit("held_out_every", n.held_out_every, "chosen: one scan in so many is held out");
}

/// The same wall in two visits.
struct WallOffset {
  Eigen::Vector2f where;
  float offset_m = 0.0F;
  Eigen::Vector2f normal = Eigen::Vector2f::UnitX();
  int stretch = 0;        ///< of the piece that looked for the other
  int other_stretch = 0;  ///< of the visit that it was compared with
};

/// Pairs pieces of wall with the nearest one of every other visit that faces the same way and lies
/// beside it, at most kMapQuality.most_offset_m away. At most some ten thousand pieces, evenly
/// chosen, look for theirs.
[[nodiscard]] std::vector<WallOffset> wall_offsets(const PieceIndex& index, int stretches,
                                                   Threads threads);

/// A beam that met a wall of another visit.
struct BeamMeeting {
  Eigen::Vector2f where;
  std::int32_t crossed = -1;  ///< the piece it went through (PieceIndex::items); -1: it ended there
  float behind_m = 0.0F;      ///< how far behind the piece that it went through it ended
  int stretch = 0;            ///< of the beam
  int wall_stretch = 0;       ///< of the wall
};

/// \param margin_m  a wall that the beam's end lies behind by less is the one that it ended on
[[nodiscard]] std::vector<BeamMeeting> beam_meetings(std::span<const JudgedScan> scans,
                                                     const PieceIndex& index, float margin_m,
                                                     Threads threads);

struct HeldOut {
  std::int64_t foretold = 0;  ///< another visit has a wall there
  std::int64_t missed = 0;    ///< other visits have the wall elsewhere nearby, or looked through it
};

/// \param crossed      of each piece, whether a beam of another visit went through it
/// \param tolerance_m  how near another visit's wall has to be
[[nodiscard]] HeldOut held_out_agreement(std::span<const JudgedScan> scans, const PieceIndex& index,
                                         std::span<const std::uint8_t> crossed, float tolerance_m,
                                         Threads threads);

}  // namespace loopstone
