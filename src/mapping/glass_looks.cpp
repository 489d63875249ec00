#include "mapping/glass_looks.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>

#include "loopstone/grid/block_grid.hpp"
#include "loopstone/grid/ray_walk.hpp"
#include "loopstone/mapping/glass_survey.hpp"
#include "mapping/judged_scans.hpp"
#include "mapping/scan_beams.hpp"
#include "mapping/scan_drawing.hpp"
#include "mapping/visit_agreement.hpp"
#include "mapping/wall_pieces.hpp"

namespace loopstone {

namespace {

constexpr std::size_t kScansPerTask = 32;
constexpr auto kBehindM = static_cast<float>(kGlassSurvey.behind_m);
constexpr auto kOnM = static_cast<float>(kGlassSurvey.on_m);
constexpr auto kHalfPieceM = static_cast<float>(0.5 * kWallPieces.piece_m);

/// Scans with fewer beams.
class ThinnedScans {
 public:
  explicit ThinnedScans(std::span<const PosedScan> scans) {
    scans_.reserve(scans.size());
    for (const PosedScan& posed : scans) {
      if (!usable(posed)) continue;
      scans_.push_back(thinned(*posed.scan));
      posed_.push_back(posed);
      posed_.back().scan = &scans_.back();
    }
  }
  [[nodiscard]] std::span<const PosedScan> posed() const { return posed_; }

 private:
  static LaserScan thinned(const LaserScan& scan) {
    const std::size_t stride = scan.ranges_m.size() / kMostBeams + 1;
    LaserScan thin{.stamp = scan.stamp,
                   .angle_min_rad = scan.angle_min_rad,
                   .angle_increment_rad = scan.angle_increment_rad * static_cast<double>(stride),
                   .range_min_m = scan.range_min_m,
                   .range_max_m = scan.range_max_m,
                   .time_increment_s = scan.time_increment_s * static_cast<double>(stride)};
    for (std::size_t i = 0; i < scan.ranges_m.size(); i += stride)
      thin.ranges_m.push_back(scan.ranges_m[i]);
    return thin;
  }
  static constexpr auto kMostBeams = static_cast<std::size_t>(kGlassSurvey.most_beams);

  std::vector<LaserScan> scans_{};
  std::vector<PosedScan> posed_{};
};

/// A look at one of the pieces.
struct PieceLook {
  std::uint32_t piece = 0;
  SurfaceLook look{};
};

/// Looks of a scan's beams. A beam tells of each piece that it goes through, and of those that it
/// ends on.
class LookTaker {
 public:
  LookTaker(const PieceIndex& index, const std::vector<bool>& goes_on)
      : index_(index), goes_on_(goes_on) {}

  void take(const JudgedBeam& beam, std::vector<PieceLook>& looks) {
    const Eigen::Vector2f way = beam.end - beam.start;
    const float length = way.norm();
    if (!(length > 2.0F * kBehindM)) return;
    const GridFrame plane{.resolution = kWallPieces.piece_m};
    const auto point = [&](const Eigen::Vector2f& at) {
      return grid_point_of(plane, at.cast<double>());
    };
    const Eigen::Vector2f u = way / length;
    walk_ray(point(beam.start), point(beam.end - kBehindM * u), [&](Cell cell) {
      index_.for_each_in(cell, [&](const WallPiece& piece) { look_at(piece, beam, u, looks); });
    });
    index_.for_each_around(index_.cell_of(beam.end), 1,
                           [&](const WallPiece& piece) { end_at(piece, beam, u, looks); });
  }

 private:
  void look_at(const WallPiece& piece, const JudgedBeam& beam, const Eigen::Vector2f& u,
               std::vector<PieceLook>& looks) const {
    const float before = across(piece, beam.start);
    const float behind = -across(piece, beam.end);
    if (!(before > kBehindM && behind > kBehindM)) return;
    const float cosine = -piece.normal.dot(u);
    if (!(cosine > static_cast<float>(kVisitAgreement.least_incidence))) return;
    const Eigen::Vector2f where = beam.start + u * (before / cosine);
    if (std::abs(along(piece, where)) <= kHalfPieceM) add(piece, cosine, false, looks);
  }
  void end_at(const WallPiece& piece, const JudgedBeam& beam, const Eigen::Vector2f& u,
              std::vector<PieceLook>& looks) const {
    const float cosine = -piece.normal.dot(u);
    if (!(cosine > static_cast<float>(kVisitAgreement.least_incidence))) return;
    if (std::abs(across(piece, beam.end)) <= kOnM &&
        std::abs(along(piece, beam.end)) <= kHalfPieceM)
      add(piece, cosine, true, looks);
  }
  void add(const WallPiece& piece, float cosine, bool returned,
           std::vector<PieceLook>& looks) const {
    const std::size_t place = index_.index_of(piece);
    if (!goes_on_[place]) return;
    looks.push_back({static_cast<std::uint32_t>(place),
                     {std::acos(std::min(1.0, static_cast<double>(cosine))), returned}});
  }

  const PieceIndex& index_;
  const std::vector<bool>& goes_on_;
};

/// Of each piece, whether its surface goes on to both sides.
std::vector<bool> those_that_go_on(const PieceIndex& index) {
  std::vector<bool> goes_on;
  constexpr int kReach = static_cast<int>(kGlassSurvey.beside_m / kWallPieces.piece_m) + 1;
  for (const WallPiece& piece : index.items()) {
    bool left = false;
    bool right = false;
    index.for_each_around(index.cell_of(piece.position), kReach, [&](const WallPiece& other) {
      if (piece.normal.dot(other.normal) < kSameFacing ||
          std::abs(across(piece, other.position)) > static_cast<float>(kGlassSurvey.off_line_m))
        return;
      const float to_left = along(piece, other.position);
      if (std::abs(to_left) < kHalfPieceM ||
          std::abs(to_left) > static_cast<float>(kGlassSurvey.beside_m))
        return;
      (to_left > 0.0F ? left : right) = true;
    });
    goes_on.push_back(left && right);
  }
  return goes_on;
}

/// Of each piece, in the order of time.
std::vector<LookedAtPiece> looks_at(const PieceIndex& index, std::span<const JudgedScan> scans,
                                    Threads threads) {
  const std::vector<bool> goes_on = those_that_go_on(index);
  std::vector<std::vector<PieceLook>> parts((scans.size() + kScansPerTask - 1) / kScansPerTask);
  parallel_for(parts.size(), threads, [&](std::size_t task) {
    LookTaker taker(index, goes_on);
    const std::size_t end = std::min((task + 1) * kScansPerTask, scans.size());
    for (std::size_t i = task * kScansPerTask; i < end; ++i)
      for (const JudgedBeam& beam : scans[i].beams) taker.take(beam, parts[task]);
  });
  std::vector<LookedAtPiece> pieces;
  for (const WallPiece& piece : index.items()) pieces.push_back({piece.position, piece.normal});
  for (const auto& part : parts)
    for (const PieceLook& look : part) pieces[look.piece].looks.push_back(look.look);
  return pieces;
}

/// Without those that the robot drove over: people, and the floor where the laser leaned.
std::vector<WallPiece> not_driven_over(std::vector<WallPiece> pieces,
                                       std::span<const PosedScan> scans, double radius_m) {
  const GridFrame plane{.resolution = kWallPieces.piece_m};
  BlockGrid<std::uint8_t> driven(kWallPieces.piece_m);
  std::optional<Eigen::Vector2d> before;
  for (const PosedScan& posed : scans) {
    if (!usable(posed)) continue;
    sweep_footprint(plane, posed.map_T_robot.translation(), radius_m, before,
                    [&](Cell cell) { driven.at(cell) = 1; });
  }
  std::erase_if(pieces, [&](const WallPiece& piece) {
    const auto* over = driven.find(driven.cell_of(piece.position.x(), piece.position.y()));
    return over != nullptr && *over != 0;
  });
  return pieces;
}

}  // namespace

std::vector<LookedAtPiece> surface_looks(std::span<const PosedScan> scans,
                                         double footprint_radius_m, Threads threads) {
  const ThinnedScans thinned(scans);
  const std::vector<JudgedScan> judged = judged_scans(thinned.posed(), threads);
  const PieceIndex index(not_driven_over(stretch_walls(judged).pieces, scans, footprint_radius_m),
                         kWallPieces.piece_m);
  return looks_at(index, judged, threads);
}

}  // namespace loopstone
