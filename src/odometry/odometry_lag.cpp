#include "loopstone/odometry/odometry_lag.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "loopstone/base/sound_state.hpp"

namespace loopstone {

namespace {

constexpr auto kMostSteps = static_cast<std::size_t>(kOdometryLag.steps);
constexpr auto kFewestSteps = static_cast<std::size_t>(kOdometryLag.fewest_steps);
constexpr auto kJudgeEvery = static_cast<std::size_t>(kOdometryLag.judge_every);

/// Odometry's way and heading over time, to be read between the stamps. Reads go forward in time.
class Unrolled {
 public:
  explicit Unrolled(const std::deque<OdometryLag::Step>& steps) {
    times_.push_back(0.0);
    way_.push_back(0.0);
    heading_.push_back(0.0);
    for (const auto& step : steps) {
      times_.push_back((step.to - steps.front().from).seconds());
      way_.push_back(way_.back() + step.odometry_m);
      heading_.push_back(heading_.back() + step.odometry_rad);
    }
  }
  struct State {
    double way_m;
    double heading_rad;
  };
  [[nodiscard]] double end_s() const { return times_.back(); }
  [[nodiscard]] State at(double time_s, std::size_t& hint) const {
    while (hint + 2 < times_.size() && times_[hint + 1] <= time_s) ++hint;
    const double span = times_[hint + 1] - times_[hint];
    const double ratio = span > 0.0 ? (time_s - times_[hint]) / span : 0.0;
    return {way_[hint] + ratio * (way_[hint + 1] - way_[hint]),
            heading_[hint] + ratio * (heading_[hint + 1] - heading_[hint])};
  }

 private:
  std::vector<double> times_{};
  std::vector<double> way_{};
  std::vector<double> heading_{};
};

/// How odometry differs from the laser when it is read later by a shift, motion by motion.
struct Misfit {
  std::vector<double> errors{};
  double squared = 0.0;
  std::size_t steps = 0;
};

Misfit misfit(const std::deque<OdometryLag::Step>& steps, const Unrolled& odometry, double shift_s,
              double margin_s) {
  Misfit result;
  std::size_t hint_from = 0;
  std::size_t hint_to = 0;
  const auto take = [&](bool seen, double error) {
    if (!seen) return;
    result.errors.push_back(error);
    result.squared += error * error;
  };
  for (const auto& step : steps) {
    const double from = (step.from - steps.front().from).seconds();
    const double to = (step.to - steps.front().from).seconds();
    if (from < margin_s || to > odometry.end_s() - margin_s) continue;
    const auto before = odometry.at(from + shift_s, hint_from);
    const auto after = odometry.at(to + shift_s, hint_to);
    take(step.sees_translation, after.way_m - before.way_m - step.laser_m);
    take(step.sees_rotation, after.heading_rad - before.heading_rad - step.laser_rad);
    ++result.steps;
  }
  return result;
}

/// Whether many motions fit better, and few worse: no handful of outliers speaks for a shift.
bool many_fit_better(const Misfit& shifted, const Misfit& none) {
  int better = 0;
  int worse = 0;
  for (std::size_t i = 0; i < none.errors.size(); ++i) {
    const double gain = std::abs(none.errors[i]) - std::abs(shifted.errors[i]);
    if (gain > kOdometryLag.clear_gain) ++better;
    if (gain < -kOdometryLag.clear_gain) ++worse;
  }
  return better >= kOdometryLag.fewest_better && better >= kOdometryLag.better_than_worse * worse;
}

}  // namespace

void OdometryLag::add(const Step& step) {
  const bool continues = !state_.steps.empty() && step.from == state_.steps.back().to &&
                         (step.to - step.from).seconds() < kOdometryLag.gap_s &&
                         step.to > step.from;
  if (!continues) state_.steps.clear();
  if (!(step.to > step.from)) return;
  state_.steps.push_back(step);
  if (state_.steps.size() > kMostSteps) state_.steps.pop_front();
  if (++state_.since_judged >= kJudgeEvery && state_.steps.size() >= kFewestSteps) {
    state_.since_judged = 0;
    judge();
  }
}

void OdometryLag::judge() {
  const Unrolled odometry(state_.steps);
  const double interval_s = odometry.end_s() / static_cast<double>(state_.steps.size());
  const double unit_s = std::max(interval_s, kOdometryLag.finest_s);
  const int shifts =
      std::clamp(static_cast<int>(kOdometryLag.longest_s / unit_s), 1, kOdometryLag.most_shifts);
  const double margin_s = shifts * unit_s;
  const Misfit none = misfit(state_.steps, odometry, 0.0, margin_s);
  if (none.steps < kFewestSteps / 2) return;
  const double noise = kOdometryLag.noise2 * static_cast<double>(none.steps);
  Misfit best = none;
  double best_shift_s = 0.0;
  for (int k = -shifts; k <= shifts; ++k) {
    const double shift_s = k * unit_s;
    Misfit shifted = misfit(state_.steps, odometry, shift_s, margin_s);
    if (shifted.squared >= best.squared) continue;
    best = std::move(shifted);
    best_shift_s = shift_s;
  }
  // At an end of the range the true shift is unknown, and so is whether there is one.
  const bool inside = std::abs(best_shift_s) < margin_s - 0.5 * unit_s;
  if (none.squared > kOdometryLag.convincing * (best.squared + noise) && inside &&
      many_fit_better(best, none)) {
    state_.lag_s = best_shift_s;
  } else if (state_.lag_s && none.squared < kOdometryLag.all_clear * (best.squared + noise)) {
    // Only a robot that speeds up and turns can show that odometry is in time again.
    const Misfit late = misfit(state_.steps, odometry, *state_.lag_s, margin_s);
    if (late.squared > kOdometryLag.convincing * (none.squared + noise) &&
        many_fit_better(none, late))
      state_.lag_s.reset();
  }
}

void OdometryLag::restore(State state) {
  require_sound(state.steps.size() <= kMostSteps, "more motions than are remembered");
  require_sound(!state.lag_s || std::isfinite(*state.lag_s), "a lag that is no number");
  const Step* before = nullptr;
  for (const Step& step : state.steps) {
    require_sound(step.to > step.from && (before == nullptr || step.from == before->to),
                  "motions that do not follow one another");
    before = &step;
  }
  state_ = std::move(state);
}

}  // namespace loopstone
