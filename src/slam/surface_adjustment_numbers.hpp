#pragma once

namespace loopstone {

/// What the adjustment to surfaces decides by, beside its options.
struct SurfaceAdjustmentNumbers {
  double shared_noise = 2.0;
  double believed_noise = 4.0;
  double holding_noise = 8.0;
  double range_scale_sigma = 0.002;
  double least_sigma_m = 1e-4;
  double kernel_width = 2.0;
  double slope_sigma = 0.1;
  double free_slope = 100.0;
  double step_accuracy = 0.1;
  int products_max = 40;
  double own_surfaces = 0.1;
  int keys_per_segment = 12;
  double visit_gap_m = 3.0;
  double tied_rad = 0.02;
};
inline constexpr SurfaceAdjustmentNumbers kSurfaceAdjustment{};

template <typename Visitor>
void visit_numbers(const SurfaceAdjustmentNumbers& n, Visitor&& visit) {
  visit("shared_noise", n.shared_noise,
        "chosen: neighbouring points of a scan err alike, so many of them do not average all noise "
        "away; sigma is so many times their spread");
  visit("believed_noise", n.believed_noise,
        "measured by bench/covariances.py: the same for covariances, which have to cover what errs "
        "alike in all scans as well");
  visit("holding_noise", n.holding_noise,
        "measured by bench/drives.py: the same for what holds a path by itself, where the errors "
        "that "
        "neighbouring scans share add up along it");
  visit(
      "range_scale_sigma", n.range_scale_sigma,
      "chosen: ranges of lasers are as true as two parts in a thousand, and the map is as large as "
      "they say; in covariances alone");
  visit("least_sigma_m", n.least_sigma_m, "derived: points are stored to better than this");
  visit("kernel_width", n.kernel_width,
        "chosen: standard deviations beyond which distances count less and less");
  visit("slope_sigma", n.slope_sigma,
        "chosen: how far a patch's direction may be off the mean of its points' normals [rad]");
  visit("free_slope", n.free_slope, "derived: no prior, as far as the arithmetic allows [rad]");
  visit("step_accuracy", n.step_accuracy,
        "chosen: a step is found to this accuracy; the next round goes on from there");
  visit("products_max", n.products_max, "chosen: beyond the 15 that a round takes as a rule");
  visit("own_surfaces", n.own_surfaces,
        "chosen: share of a key scan's surfaces in the preconditioner, enough to know which "
        "directions they hold, without holding together what moves together");
  visit("keys_per_segment", n.keys_per_segment,
        "chosen: key scans that the preconditioner moves as one rigid body");
  visit("tied_rad", n.tied_rad,
        "chosen: what both sides of a break saw is the same only where their headings are known to "
        "so much, one degree; where odometry leaves it open by three they may be others");
  visit("visit_gap_m", n.visit_gap_m,
        "chosen: a wall that comes into sight again after so much of the path is seen in another "
        "visit");
}

}  // namespace loopstone
