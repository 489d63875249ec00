#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <unordered_map>

#include "plan/plan_numbers.hpp"
#include "plan/wall_line.hpp"

namespace loopstone {

namespace {

/// Sums over points: how many, where, how spread.
struct Moments {
  double count = 0.0;
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  Eigen::Matrix2d squares = Eigen::Matrix2d::Zero();

  void add(const Eigen::Vector2d& point) {
    count += 1.0;
    sum += point;
    squares += point * point.transpose();
  }
  void add(const Moments& other) {
    count += other.count;
    sum += other.sum;
    squares += other.squares;
  }
  [[nodiscard]] Eigen::Vector2d mean() const { return sum / count; }
  [[nodiscard]] Eigen::Matrix2d covariance() const {
    const Eigen::Vector2d m = mean();
    return squares / count - m * m.transpose();
  }
};

/// What faces one way in one cell.
struct Piece {
  Moments moments{};
  Eigen::Vector2d facing = Eigen::Vector2d::Zero();  ///< sum of normals
  std::int32_t last_scan = -1;
  int scans = 0;
  bool used = false;

  [[nodiscard]] Eigen::Vector2d normal() const { return facing.normalized(); }
};

using Key = std::int64_t;

Key key_of(int column, int row, int sector) {
  return ((static_cast<Key>(row) + (1 << 24)) << 32) +
         ((static_cast<Key>(column) + (1 << 24)) << 5) + sector;
}

/// Pieces, and where they are.
class PieceMap {
 public:
  explicit PieceMap(const WallSamples& samples) {
    for (const WallSample& sample : samples.samples) add(sample);
    const int least_scans = samples.from_scans ? kPlan.least_scans : 1;
    for (Piece& piece : pieces_)
      piece.used = piece.scans < least_scans || !(piece.facing.norm() > 0.0);
  }

  [[nodiscard]] std::vector<Piece>& pieces() { return pieces_; }

  /// Calls visit(index) for all in the cells around a point.
  template <typename Visit>
  void around(const Eigen::Vector2d& point, Visit&& visit) const {
    const int column = cell_of(point.x());
    const int row = cell_of(point.y());
    for (int r = row - 1; r <= row + 1; ++r) {
      for (int c = column - 1; c <= column + 1; ++c) {
        for (int sector = 0; sector < kPlan.sectors; ++sector) {
          const auto found = places_.find(key_of(c, r, sector));
          if (found != places_.end()) visit(found->second);
        }
      }
    }
  }

 private:
  static int cell_of(double metres) { return static_cast<int>(std::floor(metres / kPlan.piece_m)); }

  void add(const WallSample& sample) {
    const double turn =
        std::atan2(static_cast<double>(sample.normal.y()), static_cast<double>(sample.normal.x()));
    const int sector =
        (static_cast<int>(std::lround(turn / (2.0 * kPi) * kPlan.sectors)) + kPlan.sectors) %
        kPlan.sectors;
    const Eigen::Vector2d point = sample.point.cast<double>();
    const auto [found, is_new] =
        places_.try_emplace(key_of(cell_of(point.x()), cell_of(point.y()), sector), pieces_.size());
    if (is_new) pieces_.emplace_back();
    Piece& piece = pieces_[found->second];
    piece.moments.add(point);
    piece.facing += sample.normal.cast<double>();
    if (sample.scan != piece.last_scan) ++piece.scans;
    piece.last_scan = sample.scan;
  }

  std::vector<Piece> pieces_{};
  std::unordered_map<Key, std::size_t> places_{};
};

/// Where samples are at all, whichever way they face: at a corner that juts out normals are of both
/// walls, so lines of pieces end before it.
class SampleCells {
 public:
  explicit SampleCells(const WallSamples& samples) {
    for (const WallSample& sample : samples.samples) ++counts_[key(sample.point.cast<double>())];
  }
  [[nodiscard]] bool has_some(const Eigen::Vector2d& point) const {
    const auto found = counts_.find(key(point));
    return found != counts_.end() && found->second >= kPlan.least_scans;
  }

 private:
  static Key key(const Eigen::Vector2d& point) {
    return key_of(static_cast<int>(std::floor(point.x() / kPlan.end_cell_m)),
                  static_cast<int>(std::floor(point.y() / kPlan.end_cell_m)), 0);
  }
  std::unordered_map<Key, int> counts_{};
};

/// How far a line goes on beyond an end.
double reach_beyond(const SampleCells& cells, const Eigen::Vector2d& end,
                    const Eigen::Vector2d& way) {
  const Eigen::Vector2d normal(-way.y(), way.x());
  const double step_m = 0.5 * kPlan.end_cell_m;
  double reach_m = 0.0;
  for (double t = step_m; t <= reach_m + 2.5 * kPlan.end_cell_m && t < kPlan.gap_m; t += step_m) {
    for (const double across : {-0.7, 0.0, 0.7}) {
      if (!cells.has_some(end + t * way + across * kPlan.end_cell_m * normal)) continue;
      reach_m = t;
      break;
    }
  }
  return reach_m;
}

/// A line while it grows.
class GrowingLine {
 public:
  GrowingLine(PieceMap& map, std::size_t seed, double across_m)
      : map_(map), seed_(seed), across_m_(across_m), members_{seed} {
    const Piece& piece = map.pieces()[seed];
    set(piece.moments.mean(), piece.normal());
  }

  void grow() {
    double reach_m = 2.5 * kPlan.piece_m;
    constexpr int kRounds = 24;
    for (int round = 0; round < kRounds; ++round) {
      const std::vector<std::size_t> before = members_;
      gather(reach_m);
      fit(members_);
      if (members_ == before && reach_m > 2.0 * (high_m_ - low_m_) + 1.0) break;
      reach_m *= 1.5;
    }
  }

  /// The line through those that lie on it; all that were gathered are used up.
  [[nodiscard]] WallLine finish(const WallSamples& samples) {
    std::vector<std::size_t> kept = members_;
    for (int round = 0; round < 2; ++round) {
      const double most = std::max(2.5 * spread(kept), 0.15 * across_m_);
      std::vector<std::size_t> near;
      for (const std::size_t i : kept)
        if (std::abs(across_of(piece(i).moments.mean())) <= most) near.push_back(i);
      if (near.empty()) break;
      kept = std::move(near);
      fit(kept);
    }
    for (const std::size_t i : members_) map_.pieces()[i].used = true;
    return line_through(kept, samples);
  }

 private:
  [[nodiscard]] const Piece& piece(std::size_t i) const { return map_.pieces()[i]; }
  [[nodiscard]] double across_of(const Eigen::Vector2d& point) const {
    return (point - centre_).dot(normal_);
  }
  [[nodiscard]] double along_of(const Eigen::Vector2d& point) const {
    return (point - centre_).dot(along_);
  }
  void set(const Eigen::Vector2d& centre, const Eigen::Vector2d& normal) {
    centre_ = centre;
    normal_ = normal;
    along_ = {normal.y(), -normal.x()};
  }

  [[nodiscard]] bool belongs(std::size_t i) const {
    static const double kFacing = std::cos(radians(kPlan.facing_deg));
    const Piece& candidate = piece(i);
    return !candidate.used && std::abs(across_of(candidate.moments.mean())) <= across_m_ &&
           candidate.normal().dot(normal_) >= kFacing;
  }

  /// Walks along the line from the seed in both directions, until there is a gap.
  void gather(double reach_m) {
    std::vector<std::size_t> found{seed_};
    const double start = along_of(piece(seed_).moments.mean());
    low_m_ = high_m_ = start;
    for (const double way : {1.0, -1.0}) {
      double last = start;
      const double step = 0.5 * kPlan.piece_m;
      for (double t = 0.0; t <= reach_m; t += step) {
        const double here = start + way * t;
        if (way * (here - last) > kPlan.gap_m + kPlan.piece_m) break;
        map_.around(centre_ + here * along_, [&](std::size_t i) {
          if (!belongs(i)) return;
          found.push_back(i);
          const double at = along_of(piece(i).moments.mean());
          if (way * (at - last) > 0.0 && way * (at - last) <= kPlan.gap_m + kPlan.piece_m)
            last = at;
        });
      }
      (way > 0.0 ? high_m_ : low_m_) = last;
    }
    std::sort(found.begin(), found.end());
    found.erase(std::unique(found.begin(), found.end()), found.end());
    const auto beyond = [&](std::size_t i) {
      const double at = along_of(piece(i).moments.mean());
      return at < low_m_ - 1e-9 || at > high_m_ + 1e-9;
    };
    std::erase_if(found, beyond);
    members_ = std::move(found);
  }

  void fit(const std::vector<std::size_t>& of) {
    Moments all;
    Eigen::Vector2d facing = Eigen::Vector2d::Zero();
    for (const std::size_t i : of) {
      all.add(piece(i).moments);
      facing += piece(i).facing;
    }
    const Eigen::Matrix2d c = all.covariance();
    const double yaw = 0.5 * std::atan2(2.0 * c(0, 1), c(0, 0) - c(1, 1));
    Eigen::Vector2d normal(-std::sin(yaw), std::cos(yaw));
    if (normal.dot(facing) < 0.0) normal = -normal;
    // What is no longer than it is thick has no direction of its own.
    const double length = std::sqrt(std::max(0.0, along_spread(c, yaw)));
    const double thickness = std::sqrt(std::max(0.0, along_spread(c, yaw + 0.5 * kPi)));
    if (length < 2.5 * thickness) normal = facing.normalized();
    set(all.mean(), normal);
  }

  static double along_spread(const Eigen::Matrix2d& c, double yaw) {
    const Eigen::Vector2d u(std::cos(yaw), std::sin(yaw));
    return u.dot(c * u);
  }

  /// Of the pieces about the line.
  [[nodiscard]] double spread(const std::vector<std::size_t>& of) const {
    double sum = 0.0;
    double count = 0.0;
    for (const std::size_t i : of) {
      const double off = across_of(piece(i).moments.mean());
      sum += piece(i).moments.count * off * off;
      count += piece(i).moments.count;
    }
    return std::sqrt(sum / count);
  }

  [[nodiscard]] WallLine line_through(const std::vector<std::size_t>& of,
                                      const WallSamples& samples) const {
    WallLine line{.centre = centre_ + samples.origin, .along = along_};
    Eigen::Vector2d facing = Eigen::Vector2d::Zero();
    for (const std::size_t i : of) facing += piece(i).facing;
    line.low_m = std::numeric_limits<double>::infinity();
    line.high_m = -line.low_m;
    double within = 0.0;
    for (const std::size_t i : of) {
      const Moments& moments = piece(i).moments;
      const Eigen::Matrix2d c = moments.covariance();
      const double at = along_of(moments.mean());
      const double half = std::sqrt(3.0 * std::max(0.0, along_.dot(c * along_)));
      line.low_m = std::min(line.low_m, at - half);
      line.high_m = std::max(line.high_m, at + half);
      line.samples += moments.count;
      within += moments.count * std::max(0.0, normal_.dot(c * normal_));
    }
    const double length = std::max(line.length_m(), kPlan.piece_m);
    const double independent =
        std::clamp(length / kPlan.correlated_m, 1.0, static_cast<double>(of.size()));
    const double between = spread(of);
    const double single = std::sqrt(between * between + within / line.samples / 25.0);
    const double common = samples.common_sigma_m;
    line.sigma_across_m = std::sqrt(single * single / independent + common * common);
    line.sigma_yaw_rad = std::sqrt(12.0 / independent) * single / length + common / length;
    line.facing = facing.dot(normal_) / line.samples;
    return line;
  }

  PieceMap& map_;
  std::size_t seed_;
  double across_m_;
  std::vector<std::size_t> members_;
  Eigen::Vector2d centre_{0.0, 0.0};
  Eigen::Vector2d normal_{0.0, 1.0};
  Eigen::Vector2d along_{1.0, 0.0};
  double low_m_ = 0.0;
  double high_m_ = 0.0;
};

/// A line beside a stronger one that faces the same way: samples of the same wall, which would hide
/// one behind it.
bool is_ghost(const WallLine& faint, const WallLine& strong, double ghost_m) {
  if (faint.along.dot(strong.along) < 0.98) return false;
  if (std::abs(strong.across_of(faint.centre)) > ghost_m) return false;
  if (faint.samples >= strong.samples) return false;
  const double from = strong.along_of(faint.at(faint.low_m));
  const double to = strong.along_of(faint.at(faint.high_m));
  const double overlap = std::min(to, strong.high_m) - std::max(from, strong.low_m);
  return overlap >= 0.7 * faint.length_m();
}

/// How far from a line its pieces lie: by how samples spread about the pieces themselves, which a
/// laser's noise, and what its ranges are wrong by from afar, make wide.
double line_reach_m(const WallSamples& samples, const std::vector<Piece>& pieces) {
  if (!samples.from_scans) return std::max(kPlan.across_m, 2.8 * samples.common_sigma_m);
  std::vector<double> spreads;
  for (const Piece& piece : pieces) {
    if (piece.used || piece.moments.count < 10.0) continue;
    const Eigen::Vector2d normal = piece.normal();
    spreads.push_back(std::sqrt(std::max(0.0, normal.dot(piece.moments.covariance() * normal))));
  }
  if (spreads.empty()) return kPlan.across_m;
  const auto middle = spreads.begin() + static_cast<std::ptrdiff_t>(spreads.size() / 2);
  std::nth_element(spreads.begin(), middle, spreads.end());
  return std::clamp(kPlan.across_spreads * *middle, kPlan.across_m, kPlan.across_most_m);
}

}  // namespace

FoundLines grow_lines(const WallSamples& samples) {
  PieceMap map(samples);
  std::vector<Piece>& pieces = map.pieces();
  std::vector<std::size_t> order(pieces.size());
  std::iota(order.begin(), order.end(), 0U);
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    const double na = pieces[a].moments.count;
    const double nb = pieces[b].moments.count;
    return na != nb ? na > nb : a < b;
  });
  const double across_m = line_reach_m(samples, pieces);
  std::vector<WallLine> lines;
  for (const std::size_t seed : order) {
    if (pieces[seed].used) continue;
    GrowingLine growing(map, seed, across_m);
    growing.grow();
    const WallLine line = growing.finish(samples);
    const double least_m = samples.from_scans ? kPlan.least_length_m : 3.0 * across_m;
    const double least_samples = samples.from_scans ? kPlan.least_samples : 3.0;
    const bool is_straight = line.length_m() >= kPlan.short_m || !samples.from_scans ||
                             line.facing >= kPlan.short_facing;
    if (line.length_m() >= least_m && line.samples >= least_samples && is_straight)
      lines.push_back(line);
  }
  if (samples.from_scans) {
    const SampleCells cells(samples);
    for (WallLine& line : lines) {
      line.high_m += reach_beyond(cells, line.at(line.high_m) - samples.origin, line.along);
      line.low_m -= reach_beyond(cells, line.at(line.low_m) - samples.origin, -line.along);
    }
  }
  std::vector<WallLine> kept;
  for (const WallLine& line : lines) {
    const auto shadows = [&](const WallLine& other) {
      return &other != &line && is_ghost(line, other, 1.7 * across_m);
    };
    if (std::none_of(lines.begin(), lines.end(), shadows)) kept.push_back(line);
  }
  return {std::move(kept), across_m};
}

}  // namespace loopstone
