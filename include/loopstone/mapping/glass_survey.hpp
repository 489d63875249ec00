#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "loopstone/base/parallel_for.hpp"
#include "loopstone/grid/grid.hpp"
#include "loopstone/mapping/occupancy.hpp"

namespace loopstone {

/// What glass is looked for by.
struct GlassSurveyNumbers {
  int most_beams = 360;
  double behind_m = 0.3;
  double on_m = 0.12;
  double beside_m = 0.2;
  double off_line_m = 0.06;
  double flat_rad = 0.6;
  int least_looks = 4;
  double most_log_ratio = 8.0;
  double suspected = 0.5;
  double sure = 0.9;
  double least_pane_m = 0.3;
  double gap_m = 0.1;
};
inline constexpr GlassSurveyNumbers kGlassSurvey{};

template <typename Visitor>
void visit_numbers(const GlassSurveyNumbers& n, Visitor&& visit) {
  visit("most_beams", n.most_beams, "chosen: bounds the cost; of a scan, evenly");
  visit("behind_m", n.behind_m,
        "chosen: a beam that ends so far behind a surface went through it; nearer, poses that are "
        "off may be why");
  visit("on_m", n.on_m, "chosen: a beam that ends so near to a surface ended on it");
  visit("beside_m", n.beside_m,
        "chosen: a surface must go on so far to both sides: past an edge a beam at a flat angle "
        "goes by a hair");
  visit("off_line_m", n.off_line_m, "chosen: what goes on lies this near to the surface's line");
  visit("flat_rad", n.flat_rad,
        "chosen: incidence, from the normal, from which on a look is flat: all glass lets through");
  visit("least_looks", n.least_looks,
        "chosen: with fewer looks, steep and flat together, nothing is known of a surface");
  visit("most_log_ratio", n.most_log_ratio,
        "chosen: one visit says no more, so that others may outvote it");
  visit("suspected", n.suspected, "chosen: probability from which on glass is told of");
  visit("sure", n.sure,
        "chosen: what is no glass comes so far over the length of a pane next to never");
  visit("least_pane_m", n.least_pane_m, "chosen: smaller panes are not told from chance");
  visit("gap_m", n.gap_m, "chosen: cells nearer to each other are one pane");
}

/// A pane that is suspected: cells that hang together.
struct GlassPane {
  Eigen::Vector2d low = Eigen::Vector2d::Zero();  ///< bounds of its cells [m], map frame
  Eigen::Vector2d high = Eigen::Vector2d::Zero();
  double probability = 0.0;  ///< the greatest of its cells

  /// About, of one that is straight [m].
  [[nodiscard]] double length_m() const { return (high - low).norm(); }
};

/// Looks for panes that return beams which meet them squarely and let others through: in the map of
/// a drive they are walls with things seen behind. What moved is told from them by the order of the
/// looks: of glass, steep looks return and flat ones go through, before and after.
///
/// What it cannot see: panes behind which nothing returns, those that were seen from one angle
/// alone, and mirrors that never return a beam of their own.
class GlassSurvey {
 public:
  /// \param scans  of one drive, at final poses, in time order; as assess_map() they are thinned
  /// \param footprint_radius_m  of the robot: where it drove nothing stands
  /// Deterministic: the same for any number of threads. Cost: about 0.1 ms a judged scan.
  void add(std::span<const PosedScan> scans, double footprint_radius_m, Threads threads = {});

  /// P(glass) of the cells of surfaces that were looked at steeply and flat; below 0: nothing is
  /// known, or there is no surface. What is suspected is at least as long as a pane.
  /// Cost: O(cells + pieces of surface).
  /// \param frame  its corner lies on a whole multiple of its resolution
  [[nodiscard]] Grid<float> probability(const GridFrame& frame) const;

 private:
  /// A piece of surface, 10 cm long, as one drive saw it.
  struct Piece {
    Eigen::Vector2f position;  ///< [m], map frame
    Eigen::Vector2f normal;
    float log_ratio = 0.0F;
  };
  template <typename Visit>
  static void draw(const std::vector<Piece>& pieces, double resolution_m, Visit&& visit);

  std::vector<std::vector<Piece>> drives_{};
};

/// Panes of a grid of GlassSurvey::probability(), in the order of their rows. Cost: O(cells).
[[nodiscard]] std::vector<GlassPane> suspected_panes(const Grid<float>& probability);

}  // namespace loopstone
