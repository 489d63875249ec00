#include "mapping/visit_agreement.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "loopstone/grid/grid_frame.hpp"
#include "loopstone/grid/ray_walk.hpp"
#include "loopstone/mapping/map_quality.hpp"

namespace loopstone {
namespace {

constexpr std::size_t kPiecesPerTask = 512;
constexpr std::size_t kScansPerTask = 32;
/// A beam passes a piece itself, not what may be beside it.
constexpr auto kHalfPieceM = static_cast<float>(0.5 * kWallPieces.piece_m);
// As the points that are compared by them.
constexpr auto kBesideM = static_cast<float>(kVisitAgreement.beside_m);
constexpr auto kAlongM = static_cast<float>(kVisitAgreement.along_m);
constexpr auto kLeastIncidence = static_cast<float>(kVisitAgreement.least_incidence);
constexpr auto kMostBeamM = static_cast<float>(kVisitAgreement.most_beam_m);
constexpr auto kHeldOutEvery = static_cast<std::size_t>(kVisitAgreement.held_out_every);

template <typename Part>
std::vector<Part> joined(const std::vector<std::vector<Part>>& parts) {
  std::vector<Part> all;
  for (const auto& part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

/// Nearest piece of each other visit.
class NearestByVisit {
 public:
  explicit NearestByVisit(int stretches) : nearest_m_(static_cast<std::size_t>(stretches), kNone) {}

  void take(int stretch, float distance_m) {
    float& nearest = nearest_m_[static_cast<std::size_t>(stretch)];
    if (nearest == kNone) touched_.push_back(stretch);
    nearest = std::min(nearest, distance_m);
  }
  /// Calls visit(stretch, distance) for each visit, and forgets them.
  template <typename Visit>
  void finish(Visit&& visit) {
    for (const int stretch : touched_) {
      float& nearest = nearest_m_[static_cast<std::size_t>(stretch)];
      visit(stretch, nearest);
      nearest = kNone;
    }
    touched_.clear();
  }

 private:
  static constexpr float kNone = 1e9F;
  std::vector<float> nearest_m_;
  std::vector<int> touched_{};
};

/// Whether the beam enters the piece from its front, well inside its length, and comes out behind.
bool passes(const JudgedBeam& beam, const WallPiece& piece, float margin_m) {
  const float before = across(piece, beam.start);
  const float behind = across(piece, beam.end);
  if (!(before > margin_m && behind < -margin_m)) return false;
  const Eigen::Vector2f way = beam.end - beam.start;
  if (before - behind < kLeastIncidence * way.norm()) return false;
  return std::abs(along(piece, beam.start + way * (before / (before - behind)))) <= kHalfPieceM;
}

bool ends_on(const JudgedBeam& beam, const WallPiece& piece, float margin_m) {
  const Eigen::Vector2f way = beam.end - beam.start;
  return -piece.normal.dot(way) >= kLeastIncidence * way.norm() &&
         std::abs(across(piece, beam.end)) <= margin_m &&
         std::abs(along(piece, beam.end)) <= kAlongM;
}

void meet(const JudgedBeam& beam, int stretch, const PieceIndex& index, float margin_m,
          std::vector<BeamMeeting>& meetings) {
  const Eigen::Vector2f way = beam.end - beam.start;
  const float length = way.norm();
  const float walked = std::min(length - margin_m, kMostBeamM);
  if (!(walked > 0.0F)) return;
  const GridFrame frame{.origin = {0.0, 0.0}, .resolution = kWallPieces.piece_m};
  const Eigen::Vector2f last = beam.start + way * (walked / length);
  bool crossed = false;
  walk_ray(grid_point_of(frame, beam.start.cast<double>()),
           grid_point_of(frame, last.cast<double>()), [&](Cell cell) {
             if (crossed) return;
             index.for_each_in(cell, [&](const WallPiece& piece) {
               if (crossed || !are_apart(piece.stretch, stretch)) return;
               if (!passes(beam, piece, margin_m)) return;
               crossed = true;
               meetings.push_back({piece.position, static_cast<std::int32_t>(index.index_of(piece)),
                                   -across(piece, beam.end), stretch, piece.stretch});
             });
           });
  if (crossed || length > kMostBeamM) return;
  bool ended = false;
  index.for_each_around(index.cell_of(beam.end), 1, [&](const WallPiece& piece) {
    if (ended || !are_apart(piece.stretch, stretch) || !ends_on(beam, piece, margin_m)) return;
    ended = true;
    meetings.push_back({beam.end, -1, 0.0F, stretch, piece.stretch});
  });
}

}  // namespace

std::vector<WallOffset> wall_offsets(const PieceIndex& index, int stretches, Threads threads) {
  const auto& pieces = index.items();
  const std::size_t looked =
      std::min(pieces.size(), static_cast<std::size_t>(kVisitAgreement.most_pieces));
  std::vector<std::vector<WallOffset>> parts((looked + kPiecesPerTask - 1) / kPiecesPerTask);
  parallel_for(parts.size(), threads, [&](std::size_t task) {
    NearestByVisit nearest(stretches);
    const std::size_t end = std::min((task + 1) * kPiecesPerTask, looked);
    for (std::size_t i = task * kPiecesPerTask; i < end; ++i) {
      const WallPiece& piece = pieces[i * pieces.size() / looked];
      constexpr int kReach = static_cast<int>(kMapQuality.most_offset_m / kWallPieces.piece_m);
      index.for_each_around(index.cell_of(piece.position), kReach, [&](const WallPiece& other) {
        if (!are_apart(piece.stretch, other.stretch) ||
            piece.normal.dot(other.normal) < kSameFacing ||
            std::abs(along(piece, other.position)) > kBesideM) {
          return;
        }
        const float distance_m = std::abs(across(piece, other.position));
        if (distance_m <= static_cast<float>(kMapQuality.most_offset_m))
          nearest.take(other.stretch, distance_m);
      });
      nearest.finish([&](int stretch, float distance_m) {
        parts[task].push_back({piece.position, distance_m, piece.normal, piece.stretch, stretch});
      });
    }
  });
  return joined(parts);
}

std::vector<BeamMeeting> beam_meetings(std::span<const JudgedScan> scans, const PieceIndex& index,
                                       float margin_m, Threads threads) {
  std::vector<std::vector<BeamMeeting>> parts((scans.size() + kScansPerTask - 1) / kScansPerTask);
  parallel_for(parts.size(), threads, [&](std::size_t task) {
    const std::size_t first = task * kScansPerTask;
    for (const JudgedScan& scan :
         scans.subspan(first, std::min(kScansPerTask, scans.size() - first))) {
      for (const JudgedBeam& beam : scan.beams)
        meet(beam, scan.stretch, index, margin_m, parts[task]);
    }
  });
  return joined(parts);
}

HeldOut held_out_agreement(std::span<const JudgedScan> scans, const PieceIndex& index,
                           std::span<const std::uint8_t> crossed, float tolerance_m,
                           Threads threads) {
  constexpr std::size_t kPerTask = kScansPerTask * kHeldOutEvery;
  std::vector<HeldOut> parts((scans.size() + kPerTask - 1) / kPerTask);
  parallel_for(parts.size(), threads, [&](std::size_t task) {
    const std::size_t end = std::min((task + 1) * kPerTask, scans.size());
    for (std::size_t s = task * kPerTask; s < end; s += kHeldOutEvery) {
      const int stretch = scans[s].stretch;
      for (const WallReturn& seen : scans[s].returns) {
        bool foretold = false;
        bool missed = false;
        constexpr int kReach =
            static_cast<int>(0.5 * kMapQuality.most_offset_m / kWallPieces.piece_m);
        index.for_each_around(index.cell_of(seen.surface), kReach, [&](const WallPiece& piece) {
          if (piece.normal.dot(seen.normal) < kSameFacing ||
              std::abs(along(piece, seen.surface)) > kAlongM) {
            return;
          }
          const bool here = std::abs(across(piece, seen.surface)) <= tolerance_m;
          if (are_apart(piece.stretch, stretch)) {
            (here ? foretold : missed) = true;
          } else if (here && crossed[index.index_of(piece)] != 0) {
            missed = true;
          }
        });
        if (foretold) {
          ++parts[task].foretold;
        } else if (missed) {
          ++parts[task].missed;
        }
      }
    }
  });
  HeldOut total;
  for (const HeldOut& part : parts) {
    total.foretold += part.foretold;
    total.missed += part.missed;
  }
  return total;
}

}  // namespace loopstone
