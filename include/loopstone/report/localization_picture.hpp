#pragma once

#include <cstdint>
#include <memory>

#include "loopstone/formats/image.hpp"
#include "loopstone/grid/grid.hpp"
#include "loopstone/localization/localization_result.hpp"

namespace loopstone {

struct LocalizationPictureOptions {
  int target_side_px = 2000;  ///< small maps are enlarged by a whole factor up to about this
  int most_side_px = 4000;    ///< large maps are reduced by a whole factor to stay below
  int most_clouds = 12;       ///< snapshots whose particles are shown, spread over the run
};

/// The map with the path coloured by state (TRACKING, DOUBTFUL, LOST), the particles of some
/// snapshots with their time, the places of searches, jumps of the pose, start and end, scale bar,
/// axes and legend. 8-bit RGB; the top of the picture is the largest y.
/// \param occupancy  the map, in percent, -1 unknown
[[nodiscard]] Image draw_localization_picture(const LocalizationResult& result,
                                              const Grid<std::int8_t>& occupancy,
                                              const LocalizationPictureOptions& options = {});

struct BeliefPictureOptions {
  int width_px = 1280;
  double close_up_m = 12.0;  ///< side of the close-up around the estimate
  bool whole_map =
      /// beside the close-up; else one picture: the close-up, or where the belief is wide the whole
      true;
};

/// Draws the belief of one moment after another at the same size: the particles, the hypotheses
/// with their probabilities, the scan at the estimate, the state. The map is drawn once.
class BeliefPainter {
 public:
  /// \param occupancy  must outlive the painter
  /// \param start      moments are named by their time since then
  BeliefPainter(const Grid<std::int8_t>& occupancy, Stamp start,
                const BeliefPictureOptions& options = {});
  ~BeliefPainter();
  BeliefPainter(BeliefPainter&&) noexcept;
  BeliefPainter& operator=(BeliefPainter&&) noexcept;

  /// 8-bit RGB.
  [[nodiscard]] Image draw(const BeliefSnapshot& snapshot) const;

 private:
  struct Layout;
  std::unique_ptr<const Layout> layout_;
};

}  // namespace loopstone
