#pragma once

#include "loopstone/localization/localization_result.hpp"

namespace loopstone {

/// What a robot may think of its pose, by the probability of the last scans. Evidence is gathered
/// over a way, so neither one scan that fits nor one that does not changes the state: TRACKING
/// begins where the probability was high for some way, or very high; it goes on until it is lost
/// for longer than a person needs to pass, or beyond doubt.
class StateJudge {
 public:
  /// \param tracking_probability  TRACKING begins from here up
  /// \param lost_probability      LOST below, of the place alone
  StateJudge(double tracking_probability, double lost_probability)
      : begin_(tracking_probability), lost_(lost_probability) {}

  /// \param probability        of the pose
  /// \param place_probability  of the place, however precise the pose is in it
  /// \param way_m              since the last scan
  /// \param worse              the scan fits much worse than those of the last metres did
  LocalizationState judge(double probability, double place_probability, double way_m,
                          bool worse = false);

  [[nodiscard]] bool is_tracking() const { return tracking_; }
  /// Scans have fitted much worse than they used to for so long that the pose is not trusted.
  [[nodiscard]] bool fits_worse_for_long() const { return worse_m_ > kWorseM; }

  /// The robot is believed to be elsewhere: what was gathered does not count there.
  void begin_anew() { *this = StateJudge(begin_, lost_); }

 private:
  static constexpr double kWorseM = 0.5;

  double begin_;
  double lost_;
  bool tracking_ = false;
  double sure_m_ = 0.0;    ///< way on which the probability has been high
  double unsure_m_ = 0.0;  ///< or low
  double worse_m_ = 0.0;   ///< on which scans fitted worse than they used to
};

}  // namespace loopstone
