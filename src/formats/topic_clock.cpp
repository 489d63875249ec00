#include "formats/topic_clock.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "loopstone/base/median.hpp"

namespace loopstone {
namespace {

/// Messages take so long at most from a sensor to the recorder, usually; two clocks that differ by
/// more are not one.
constexpr double kSameClockS = 0.25;
/// Simulations run faster or slower than the recorder's clock, and recordings are played at other
/// speeds; beyond so many times it is another unit.
constexpr double kSameUnit = 50.0;
/// Clocks whose speeds differ by more than this share differ by something else at every moment.
constexpr double kSameSpeed = 0.01;
/// How much of it is worth a word.
constexpr double kSpeedWorthAWord = 0.05;
/// Of the steps from message to message so many may go back, or be none.
constexpr double kFewSteps = 0.1;
/// Steps back of more than this are no jitter.
constexpr double kJumpBackS = 5.0;
constexpr double kUsualPeriodS = 0.1;

double seconds_between(Stamp later, Stamp earlier) { return later.seconds() - earlier.seconds(); }

std::string time_text(double seconds) {
  const double size = std::abs(seconds);
  if (size < 1.0) return fmt::format("{:+.1f} ms", 1e3 * seconds);
  return size < 1e4 ? fmt::format("{:+.2f} s", seconds) : fmt::format("{:+.0f} s", seconds);
}

double usual_step_s(const std::vector<Stamp>& stamps) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < stamps.size(); ++i) {
    steps.push_back(seconds_between(stamps[i], stamps[i - 1]));
  }
  return steps.empty() ? 0.0 : median_of(steps);
}

}  // namespace

void StampFacts::add(std::optional<Stamp> own, Stamp recorded) {
  ++count_;
  if (recorded_.size() >= kMost) return;
  if (!own) ++without_own_;
  own_.push_back(own.value_or(Stamp{}));
  recorded_.push_back(recorded);
}

std::string StampFacts::fault_of(const std::vector<Stamp>& stamps) const {
  const auto steps = static_cast<double>(stamps.size()) - 1.0;
  double back = 0.0;
  double none = 0.0;
  bool jumps = false;
  for (std::size_t i = 1; i < stamps.size(); ++i) {
    const double step_s = seconds_between(stamps[i], stamps[i - 1]);
    if (step_s < 0.0) ++back;
    if (step_s == 0.0) ++none;
    if (step_s < -kJumpBackS) jumps = true;
  }
  if (std::ranges::count(stamps, Stamp{}) > static_cast<std::ptrdiff_t>(stamps.size() / 10)) {
    return "are zero";
  }
  if (steps >= 2.0 && none >= (1.0 - kFewSteps) * steps) return "are all the same";
  if (steps >= 2.0 && none > 0.5 * steps) return "stand still from message to message";
  if (back > kFewSteps * steps && jumps) return "jump to and fro";
  return {};
}

std::string StampFacts::fault_of_own() const {
  if (own_.empty()) return "are not known";
  if (without_own_ > 0) return "are missing";
  if (std::string fault = fault_of(own_); !fault.empty()) return fault;
  if (!fault_of(recorded_).empty()) return {};
  const double times = speed();
  if (!(times > 1.0 / kSameUnit && times < kSameUnit)) {
    return fmt::format("run {:.3g} times as fast as the recorder's clock", times);
  }
  return {};
}

double StampFacts::speed() const {
  if (own_.empty()) return 1.0;
  const double own_s = seconds_between(own_.back(), own_.front());
  const double recorded_s = seconds_between(recorded_.back(), recorded_.front());
  return recorded_s > 1.0 ? own_s / recorded_s : 1.0;
}

std::optional<Duration> StampFacts::behind(const StampFacts& lead) const {
  const auto is_even = [](const StampFacts& facts) {
    return std::abs(facts.speed() - 1.0) <= kSameSpeed;
  };
  if (is_even(*this) && is_even(lead)) {
    return Duration{offset().nanoseconds - lead.offset().nanoseconds};
  }
  std::vector<double> behind_s;
  for (std::size_t i = 0; i < own_.size(); ++i) {
    const auto after = std::ranges::lower_bound(lead.recorded_, recorded_[i]);
    if (after == lead.recorded_.begin() || after == lead.recorded_.end()) continue;
    const auto k = static_cast<std::size_t>(after - lead.recorded_.begin());
    const double passed_s = seconds_between(recorded_[i], lead.recorded_[k - 1]);
    const double step_s = seconds_between(lead.recorded_[k], lead.recorded_[k - 1]);
    const double share = step_s > 0.0 ? passed_s / step_s : 0.0;
    const double lead_step_s = seconds_between(lead.own_[k], lead.own_[k - 1]);
    behind_s.push_back(seconds_between(lead.own_[k - 1], own_[i]) + share * lead_step_s);
  }
  if (behind_s.empty()) return std::nullopt;
  return Duration::from_seconds(median_of(behind_s));
}

std::string StampFacts::fault_of_record() const {
  return recorded_.empty() ? "are not known" : fault_of(recorded_);
}

Duration StampFacts::offset() const {
  std::vector<double> offsets;
  for (std::size_t i = 0; i < own_.size(); ++i) {
    offsets.push_back(seconds_between(recorded_[i], own_[i]));
  }
  return Duration::from_seconds(offsets.empty() ? 0.0 : median_of(offsets));
}

Duration StampFacts::scatter() const {
  std::vector<double> offsets;
  for (std::size_t i = 0; i < own_.size(); ++i) {
    offsets.push_back(seconds_between(recorded_[i], own_[i]));
  }
  if (offsets.size() < 4) return {};
  std::ranges::sort(offsets);
  return Duration::from_seconds(offsets[offsets.size() * 3 / 4] - offsets[offsets.size() / 4]);
}

double StampFacts::period_s() const {
  const bool own = fault_of_own().empty();
  if (!own && !fault_of_record().empty()) return 0.0;
  return std::max(0.0, usual_step_s(own ? own_ : recorded_));
}

namespace {

/// The clock that all others are brought to.
struct LeadingClock {
  TopicClock::Source source = TopicClock::Source::kOwn;
  Duration offset{};  ///< recorder less this clock
  const StampFacts* facts = nullptr;
};

/// What is added to a topic's own stamps to be the leading clock's. Nothing when that can't be
/// told.
std::optional<Duration> behind(const StampFacts& facts, const LeadingClock& lead) {
  if (lead.source == TopicClock::Source::kOwn && lead.facts->fault_of_own().empty()) {
    return facts.behind(*lead.facts);
  }
  if (std::abs(facts.speed() - 1.0) > kSameSpeed) return std::nullopt;
  return Duration{facts.offset().nanoseconds - lead.offset.nanoseconds};
}

TopicClock follow(const ClockQuestion& topic, const LeadingClock& lead, StampUse use,
                  ClockChoice& choice) {
  using Source = TopicClock::Source;
  const StampFacts& facts = *topic.facts;
  const std::string fault = facts.fault_of_own();
  const Duration to_lead{-lead.offset.nanoseconds};
  if (use == StampUse::kRecord) return {.source = Source::kRecord, .shift = to_lead};
  if (use == StampUse::kHeader) return {.source = Source::kOwn};
  if (!fault.empty() || facts.count() == 0) {
    if (facts.count() > 0 && fault != "are missing") {
      choice.warnings.push_back(topic.name + ": its stamps " + fault +
                                "; the recorder's are used instead");
    }
    return {.source = Source::kRecord, .shift = to_lead};
  }
  if (!facts.fault_of_record().empty()) return {.source = Source::kOwn};
  const std::optional<Duration> known = behind(facts, lead);
  if (!known && lead.source == Source::kRecord) {
    return {.source = Source::kRecord, .shift = to_lead};
  }
  const bool is_known = known && (!topic.is_dated_ahead || lead.source == Source::kRecord);
  const Duration apart = is_known ? *known : Duration{};
  if (std::abs(apart.seconds()) <= kSameClockS) return {.source = Source::kOwn};
  choice.warnings.push_back(fmt::format(
      "{}: its clock is {} off the laser's, measured against the recorder's; corrected by that",
      topic.name, time_text(-apart.seconds())));
  return {.source = Source::kOwn, .shift = apart};
}

}  // namespace

ClockChoice choose_clocks(const std::vector<ClockQuestion>& topics, StampUse use) {
  using Source = TopicClock::Source;
  ClockChoice choice;
  if (topics.empty()) return choice;
  const ClockQuestion& first = topics.front();
  const std::string own_fault = first.facts->fault_of_own();
  const std::string record_fault = first.facts->fault_of_record();
  LeadingClock lead;
  if (use == StampUse::kOrder ||
      (use == StampUse::kAuto && !own_fault.empty() && !record_fault.empty())) {
    const double period_s = first.facts->period_s();
    const double used_s = period_s > 1e-3 ? period_s : kUsualPeriodS;
    if (use == StampUse::kAuto) {
      choice.warnings.push_back(fmt::format(
          "{}: its stamps {}, and the recorder's {}: messages are taken in their order, {:.3f} s "
          "from scan to scan",
          first.name, own_fault, record_fault, used_s));
    }
    choice.clocks.assign(topics.size(), {.source = Source::kOrder, .period_s = used_s});
    return choice;
  }
  const bool own = use == StampUse::kHeader || (use == StampUse::kAuto && own_fault.empty());
  if (own) {
    lead.offset = record_fault.empty() ? first.facts->offset() : Duration{};
    const double offset_s = lead.offset.seconds();
    if (std::abs(offset_s) > kSameClockS) {
      choice.notes.push_back(fmt::format(
          "{}: the recorder's clock is {} off the messages' own, by which the log is read",
          first.name, time_text(offset_s)));
    }
    if (const double times = first.facts->speed(); std::abs(times - 1.0) > kSpeedWorthAWord) {
      choice.notes.push_back(
          fmt::format("{}: its stamps run {:.3g} times as fast as the recorder's clock: simulated, "
                      "or played at another speed",
                      first.name, times));
    }
  } else if (use == StampUse::kAuto) {
    choice.warnings.push_back(first.name + ": its stamps " + own_fault +
                              "; the recorder's are used instead");
  }
  choice.clocks.push_back({.source = own ? Source::kOwn : Source::kRecord});
  lead.source = choice.clocks.front().source;
  lead.facts = first.facts;
  for (std::size_t i = 1; i < topics.size(); ++i) {
    choice.clocks.push_back(follow(topics[i], lead, use, choice));
  }
  return choice;
}

void ClockDrift::add(Stamp own, Stamp recorded) {
  const double offset_s = seconds_between(recorded, own);
  if (first_s_.size() < kMost) first_s_.push_back(offset_s);
  if (last_s_.size() < kMost) {
    last_s_.push_back(offset_s);
  } else {
    last_s_[static_cast<std::size_t>(count_) % kMost] = offset_s;
  }
  ++count_;
}

std::optional<double> ClockDrift::drift_s() const {
  if (count_ < static_cast<std::int64_t>(4 * kMost)) return std::nullopt;
  std::vector<double> first_s = first_s_;
  std::vector<double> last_s = last_s_;
  return median_of(last_s) - median_of(first_s);
}

}  // namespace loopstone
