#include "localization/state_judge.hpp"

namespace loopstone {

namespace {

/// Way over which the probability is high before the pose is TRACKING, unless it is very high.
constexpr double kSureM = 0.1;
constexpr double kVerySure = 0.97;
/// TRACKING ends when the probability has been below this for so long a way ...
constexpr double kUnsure = 0.5;
constexpr double kUnsureM = 0.2;
/// ... or where the probability is so small, or where the pose is too imprecise to drive by.
constexpr double kWrong = 0.3;
constexpr double kImprecise = 0.7;

}  // namespace

LocalizationState StateJudge::judge(double probability, double place_probability, double way_m,
                                    bool worse) {
  sure_m_ = probability >= begin_ ? sure_m_ + way_m : 0.0;
  unsure_m_ = probability < kUnsure ? unsure_m_ + way_m : 0.0;
  worse_m_ = worse ? worse_m_ + way_m : 0.0;
  // As those of a robot that was carried to a place that is only similar do.
  if (fits_worse_for_long()) {
    tracking_ = false;
    sure_m_ = 0.0;
  } else if (tracking_) {
    tracking_ = unsure_m_ <= kUnsureM && probability >= kWrong &&
                probability >= kImprecise * place_probability;
  } else {
    tracking_ = probability >= begin_ && (sure_m_ > kSureM || probability >= kVerySure);
  }
  if (tracking_) return LocalizationState::kTracking;
  return place_probability < lost_ ? LocalizationState::kLost : LocalizationState::kDoubtful;
}

}  // namespace loopstone
