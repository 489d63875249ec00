#include "formats/wheel_plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <set>
#include <utility>

#include "formats/wheel_geometry.hpp"
#include "formats/wheel_survey.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/formats/log_format_words.hpp"

namespace loopstone {
namespace {

/// What is known of the wheels, and from where.
struct KnownNumber {
  std::optional<double> value{};
  const char* source = "";
};

KnownNumber known_number(const std::optional<double>& stated, const std::optional<double>& by_tf) {
  if (stated) return {stated, "--robot"};
  return {by_tf, "tf"};
}

/// What a candidate needs to be used.
struct WheelNumbers {
  KnownNumber radius_m{};
  KnownNumber metres_per_count{};
  KnownNumber track_width_m{};
  bool is_angles = false;

  [[nodiscard]] std::vector<std::string> missing() const {
    std::vector<std::string> keys;
    if (is_angles && !radius_m.value) keys.emplace_back("radius_m");
    if (!is_angles && !metres_per_count.value) keys.emplace_back("metres_per_count");
    if (!track_width_m.value) keys.emplace_back("track_width_m");
    return keys;
  }
  [[nodiscard]] std::string text() const {
    const auto told = [](const KnownNumber& number, const char* name, const char* unit) {
      return fmt::format("{} {:.4g} {} ({})", name, *number.value, unit, number.source);
    };
    return (is_angles ? told(radius_m, "radius", "m") : told(metres_per_count, "a count", "m")) +
           ", " + told(track_width_m, "track", "m");
  }
};

class WheelPlanner {
 public:
  WheelPlanner(Recording& recording, const TopicOptions& options, TopicSurvey& survey,
               TopicChoice& choice)
      : recording_(recording), options_(options), survey_(survey), choice_(choice) {}

  WheelPlan run() {
    find_topics();
    if (topics_.empty()) return {};
    if (choice_.wheels) return leave("another one is used");
    if (is_named_none(TopicRole::kWheels)) return {};
    const bool has_poses = choice_.odometry || is_named_none(TopicRole::kOdometry);
    if (!is_named_ && has_poses) return leave("wheels are used only where no odometry is told");
    const std::vector<WheelCandidate> candidates = survey_wheels(recording_, survey_, topics_);
    if (candidates.empty()) return refuse();
    for (const WheelCandidate& candidate : candidates) {
      const WheelNumbers numbers = numbers_of(candidate);
      if (numbers.missing().empty()) return use(candidate, numbers);
    }
    return ask_for_numbers(candidates.front());
  }

 private:
  [[nodiscard]] bool is_named_none(TopicRole role) const {
    return std::ranges::any_of(options_.named, [&](const auto& named) {
      return named.first == role && named.second.empty();
    });
  }

  [[nodiscard]] bool is_named(const TopicFacts& facts) const {
    return std::ranges::any_of(options_.named, [&](const auto& named) {
      return named.first == TopicRole::kWheels &&
             (facts.name == named.second || facts.name == "/" + named.second);
    });
  }

  /// Those that the user named, or all that may tell of wheels.
  void find_topics() {
    std::vector<std::size_t> all;
    for (std::size_t i = 0; i < survey_.topics.size(); ++i) {
      const TopicFacts& facts = survey_.topics[i];
      if (facts.kind != TopicKind::kJoints && facts.kind != TopicKind::kCounts) continue;
      if (is_named(facts)) topics_.push_back(i);
      const bool is_empty = facts.messages && *facts.messages == 0;
      if (facts.fault.empty() && !is_empty && !is_command(facts.name)) all.push_back(i);
    }
    is_named_ = !topics_.empty();
    if (!is_named_) topics_ = std::move(all);
  }

  WheelPlan leave(const std::string& why) {
    for (const std::size_t i : topics_) {
      if (choice_.remarks[i].empty()) choice_.remarks[i] = why;
    }
    return {};
  }

  WheelPlan refuse() {
    for (const std::size_t i : topics_) {
      const std::string& fault = survey_.topics[i].fault;
      if (is_named_) {
        throw UsageError(fmt::format("--topic wheels={}: {}", survey_.topics[i].name,
                                     fault.empty() ? kNoWheels : fault));
      }
      if (!fault.empty()) choice_.remarks[i] = fault;
    }
    return leave(kNoWheels);
  }

  [[nodiscard]] WheelNumbers numbers_of(const WheelCandidate& candidate) const {
    const WheelGeometry by_tf = wheel_geometry(survey_.frames, choice_.base_frame);
    const StatedWheels& stated = options_.wheels;
    return {.radius_m = known_number(stated.radius_m, by_tf.radius_m),
            .metres_per_count = known_number(stated.metres_per_count, {}),
            .track_width_m = known_number(stated.track_width_m, by_tf.track_width_m),
            .is_angles = candidate.tells_angles()};
  }

  WheelPlan ask_for_numbers(const WheelCandidate& candidate) {
    const WheelNumbers numbers = numbers_of(candidate);
    const std::string keys = listed(numbers.missing(), "and");
    choice_.warnings.push_back(
        fmt::format("{}: {} of wheels ({}), which can't be used without {}: give {} in [wheels] "
                    "of --robot FILE",
                    listed(topic_names(candidate), "and"), numbers.is_angles ? "angles" : "counts",
                    listed(candidate.names(survey_), "and"), keys,
                    numbers.missing().size() > 1 ? "them" : "it"));
    return leave(keys + " of the wheels not known");
  }

  [[nodiscard]] static std::vector<std::size_t> topics_of(const WheelCandidate& candidate) {
    return WheelPlan{.wheels = candidate.wheels}.topics();
  }

  [[nodiscard]] std::vector<std::string> topic_names(const WheelCandidate& candidate) const {
    std::vector<std::string> names;
    for (const std::size_t i : topics_of(candidate)) names.push_back(survey_.topics[i].name);
    return names;
  }

  WheelPlan use(const WheelCandidate& candidate, const WheelNumbers& numbers) {
    WheelPlan plan{.wheels = candidate.wheels};
    plan.model.metres_per_count = numbers.is_angles ? *numbers.radius_m.value * kRadiansPerCount
                                                    : *numbers.metres_per_count.value;
    plan.model.track_width_m = *numbers.track_width_m.value;
    if (numbers.radius_m.value) plan.model.radius_m = *numbers.radius_m.value;
    plan.counts_are_cumulative = options_.wheels.counts_are_cumulative.value_or(true);
    for (PlannedWheel& wheel : plan.wheels) {
      wheel.field.bits = std::min(wheel.field.bits, options_.wheels.counter_bits.value_or(62));
    }
    for (const std::size_t i : topics_of(candidate)) choice_.roles[i] = TopicRole::kWheels;
    for (const std::size_t i : topics_) {
      if (choice_.roles[i] == TopicRole::kWheels) choice_.remarks[i].clear();
    }
    leave_others();
    if (is_named_) give_odometry_up();
    choice_.choices.push_back(described(candidate, numbers));
    warn_of_skidding(candidate, numbers);
    return plan;
  }

  void leave_others() {
    for (const std::size_t i : topics_) {
      if (choice_.roles[i] == TopicRole::kNone && choice_.remarks[i].empty()) {
        const std::string& fault = survey_.topics[i].fault;
        choice_.remarks[i] = fault.empty() ? "another one is used for wheels" : fault;
      }
    }
  }

  /// The user wants the wheels, and said nothing of odometry.
  void give_odometry_up() {
    const bool is_odometry_named = std::ranges::any_of(
        options_.named, [](const auto& named) { return named.first == TopicRole::kOdometry; });
    if (!choice_.odometry || is_odometry_named) return;
    if (const auto topic = choice_.odometry->topic) {
      choice_.roles[*topic] = TopicRole::kNone;
      choice_.remarks[*topic] = "the wheels that were named are used";
    }
    choice_.odometry.reset();
    for (std::string& text : choice_.choices) {
      if (text.starts_with(to_string(TopicRole::kOdometry))) {
        text = fmt::format("{:<9}{}", to_string(TopicRole::kOdometry), "none: wheels were named");
      }
    }
  }

  [[nodiscard]] std::string described(const WheelCandidate& candidate,
                                      const WheelNumbers& numbers) const {
    const TopicFacts& facts = survey_.topics[candidate.wheels.front().topic];
    const double rate_hz = facts.rate_hz();
    const std::string rate = rate_hz > 0.0 ? fmt::format(", {:.1f} Hz", rate_hz) : std::string();
    const auto topics = topic_names(candidate);
    const std::string wheels =
        topics.size() > 1 ? std::string() : ", " + listed(candidate.names(survey_), "and");
    return fmt::format("{:<9}{} ({}{}){}, {}", to_string(TopicRole::kWheels), listed(topics, "and"),
                       facts.type, rate, wheels, numbers.text());
  }

  void warn_of_skidding(const WheelCandidate& candidate, const WheelNumbers& numbers) {
    if (options_.wheels.track_width_m || choice_.imu) return;
    std::set<WheelSpot> spots;
    for (const PlannedWheel& wheel : candidate.wheels) spots.insert(wheel.spot);
    if (spots.size() <= 2) return;
    choice_.warnings.push_back(
        fmt::format("{}: wheels ahead and astern slip sideways when the robot turns, as if its "
                    "track were wider than the {:.3f} m of tf; give track_width_m in [wheels] of "
                    "--robot FILE",
                    topic_names(candidate).front(), *numbers.track_width_m.value));
  }

  static constexpr const char* kNoWheels = "names no wheels of both sides";

  Recording& recording_;
  const TopicOptions& options_;
  TopicSurvey& survey_;
  TopicChoice& choice_;
  std::vector<std::size_t> topics_{};  ///< that may tell of wheels
  bool is_named_ = false;              ///< by the user
};

}  // namespace

std::vector<std::size_t> WheelPlan::topics() const {
  std::vector<std::size_t> topics;
  for (const PlannedWheel& wheel : wheels) {
    if (std::ranges::find(topics, wheel.topic) == topics.end()) topics.push_back(wheel.topic);
  }
  return topics;
}

WheelPlan plan_wheels(Recording& recording, const TopicOptions& options, TopicSurvey& survey,
                      TopicChoice& choice) {
  return WheelPlanner(recording, options, survey, choice).run();
}

void drop_wheels(const std::string& why, const TopicSurvey& survey, WheelPlan& plan,
                 TopicChoice& choice) {
  for (const std::size_t i : plan.topics()) {
    choice.roles[i] = TopicRole::kNone;
    choice.remarks[i] = why;
    choice.warnings.push_back(survey.topics[i].name + ": " + why);
  }
  std::erase_if(choice.choices, [](const std::string& text) {
    return text.starts_with(to_string(TopicRole::kWheels));
  });
  plan = {};
}

}  // namespace loopstone
