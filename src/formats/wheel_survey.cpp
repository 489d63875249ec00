#include "formats/wheel_survey.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <tuple>
#include <utility>

#include "formats/wheel_fields.hpp"
#include "formats/wheel_messages.hpp"
#include "loopstone/messages/message_codec.hpp"

namespace loopstone {
namespace {

constexpr std::int64_t kEnough = 100;
constexpr double kMostSeconds = 30.0;
constexpr std::int64_t kMostBytes = std::int64_t{1} << 26;
constexpr std::size_t kMostJoints = 1000;
/// What a wheel that stands seems to move by [rad, rad/s, counts].
constexpr double kStanding = 1e-3;

/// What was seen of one wheel.
struct SeenWheel {
  PlannedWheel wheel{};
  std::optional<double> first{};
  bool has_moved = false;
};

/// What was told at one stamp.
struct Moment {
  std::optional<Stamp> stamp{};
  std::set<std::string> names{};
};

/// "robot1/" of "robot1/wheel_left_joint".
std::string prefix_of(const std::string& name) { return name.substr(0, name.rfind('/') + 1); }

bool has_both_sides(const std::vector<SeenWheel>& wheels) {
  const auto has = [&](bool is_left) {
    return std::ranges::any_of(wheels,
                               [&](const SeenWheel& w) { return w.wheel.spot.is_left == is_left; });
  };
  return has(true) && has(false);
}

class WheelSurveyor {
 public:
  WheelSurveyor(Recording& recording, TopicSurvey& survey, const std::vector<std::size_t>& topics)
      : recording_(recording), survey_(survey), topics_(topics), messages_(recording, survey) {}

  std::vector<WheelCandidate> run() {
    recording_.rewind();
    recording_.want([this](const RecordedTopic& topic) { return place_of(topic).has_value(); });
    look();
    recording_.want({});
    recording_.rewind();
    return candidates();
  }

 private:
  [[nodiscard]] std::optional<std::size_t> place_of(const RecordedTopic& topic) const {
    for (const std::size_t i : topics_) {
      const TopicFacts& facts = survey_.topics[i];
      if (facts.name == topic.name && facts.type == topic.type) return i;
    }
    return std::nullopt;
  }

  void look() {
    std::int64_t bytes = 0;
    std::optional<Stamp> first;
    while (const auto message = recording_.next()) {
      const auto place = place_of(recording_.topics()[message->topic]);
      if (!place) continue;
      take(*place, *message);
      if (!first) first = message->recorded;
      bytes += static_cast<std::int64_t>(message->bytes.size());
      const bool is_enough = std::ranges::all_of(
          topics_, [&](std::size_t i) { return survey_.topics[i].seen >= kEnough; });
      const double passed_s = message->recorded.seconds() - first->seconds();
      if (is_enough || bytes > kMostBytes || passed_s > kMostSeconds) return;
    }
  }

  void take(std::size_t place, const RecordedMessage& message) {
    TopicFacts& facts = survey_.topics[place];
    ++facts.seen;
    try {
      const WheelMessage& told = messages_.decode(message, place);
      if (!continues(place, told)) facts.stamps.add(told.stamp, message.recorded);
      if (facts.frame.empty()) facts.frame = told.frame;
      for (const ToldWheel& wheel : told.wheels) note(place, wheel);
      facts.is_decoded = true;
      facts.fault.clear();
    } catch (const MessageError& error) {
      if (!facts.is_decoded) facts.fault = error.what();
    }
  }

  /// Whether a message tells other wheels of the moment that the one before it told of.
  bool continues(std::size_t place, const WheelMessage& told) {
    Moment& last = moments_[place];
    std::set<std::string> names;
    for (const ToldWheel& wheel : told.wheels) names.insert(wheel.name);
    const bool is_other =
        !names.empty() && std::ranges::none_of(names, [&](const std::string& name) {
          return last.names.contains(name);
        });
    if (told.stamp && told.stamp == last.stamp && is_other) {
      last.names.merge(names);
      return true;
    }
    last = {told.stamp, std::move(names)};
    return false;
  }

  void note(std::size_t place, const ToldWheel& told) {
    if (is_steering(told.name)) steers_.insert(place);
    if (!told.spot) return;
    std::vector<SeenWheel>& seen = seen_[place];
    auto known = std::ranges::find_if(seen, [&](const SeenWheel& one) {
      return one.wheel.name == told.name && one.wheel.field.path == told.field.path;
    });
    if (known == seen.end()) {
      if (seen.size() >= kMostJoints) return;
      seen.push_back({.wheel = {place, told.name, told.field, *told.spot}});
      known = std::prev(seen.end());
    }
    const double value = told.position.value_or(0.0);
    if (!known->first) known->first = value;
    if (std::abs(value - *known->first) > kStanding ||
        std::abs(told.speed.value_or(0.0)) > kStanding) {
      known->has_moved = true;
    }
  }

  /// Of several units the best, of several robots the first one with both sides.
  static std::vector<SeenWheel> of_one_robot(const std::vector<SeenWheel>& all) {
    std::map<std::tuple<WheelUnit, std::string>, std::vector<SeenWheel>> groups;
    for (const SeenWheel& one : all) {
      groups[{one.wheel.field.unit, prefix_of(one.wheel.name)}].push_back(one);
    }
    for (const auto& [what, wheels] : groups) {
      if (has_both_sides(wheels)) return wheels;
    }
    return all;
  }

  /// Motors and drives only where nothing is called a wheel.
  static void drop_motors(std::vector<SeenWheel>& wheels) {
    std::vector<SeenWheel> called;
    for (const SeenWheel& one : wheels) {
      const auto words = words_of_name(one.wheel.name);
      const bool is_motor = std::ranges::find(words, "motor") != words.end() ||
                            std::ranges::find(words, "drive") != words.end();
      const bool is_wheel = std::ranges::find(words, "wheel") != words.end();
      if (is_wheel || !is_motor) called.push_back(one);
    }
    if (has_both_sides(called)) wheels = std::move(called);
  }

  /// Wheels that are steered do not roll straight ahead: the rear ones tell more.
  static void drop_steered(std::vector<SeenWheel>& wheels) {
    std::vector<SeenWheel> rear;
    for (const SeenWheel& one : wheels) {
      if (one.wheel.spot.row == WheelRow::kRear) rear.push_back(one);
    }
    if (has_both_sides(rear)) wheels = std::move(rear);
  }

  void add_candidate(std::vector<SeenWheel> wheels, bool steers,
                     std::vector<WheelCandidate>& candidates) {
    wheels = of_one_robot(wheels);
    drop_motors(wheels);
    if (steers) drop_steered(wheels);
    if (!has_both_sides(wheels)) return;
    WheelCandidate candidate;
    for (const SeenWheel& one : wheels) {
      candidate.wheels.push_back(one.wheel);
      if (one.has_moved) candidate.has_moved = true;
    }
    candidates.push_back(std::move(candidate));
  }

  /// What the names of topics of one robot's wheels share.
  [[nodiscard]] std::string family_of(std::size_t topic) const {
    const TopicFacts& facts = survey_.topics[topic];
    return facts.type + " " + without_spot(words_of_name(facts.name));
  }

  std::vector<WheelCandidate> candidates() {
    std::vector<WheelCandidate> found;
    std::map<std::string, std::vector<SeenWheel>> families;  // topics of one wheel each
    for (const auto& [topic, wheels] : seen_) {
      if (has_both_sides(wheels)) {
        add_candidate(wheels, steers_.contains(topic), found);
      } else {
        auto& family = families[family_of(topic)];
        family.insert(family.end(), wheels.begin(), wheels.end());
      }
    }
    for (const auto& [name, wheels] : families) add_candidate(wheels, false, found);
    const auto rank = [&](const WheelCandidate& one) {
      const int kind = one.unit() == WheelUnit::kRadians            ? 0
                       : one.unit() == WheelUnit::kRadiansPerSecond ? 3
                       : one.tells_angles()                         ? 1
                                                                    : 2;
      return std::tuple(!one.has_moved, kind, one.wheels.front().topic);
    };
    std::ranges::sort(found, {}, rank);
    return found;
  }

  Recording& recording_;
  TopicSurvey& survey_;
  const std::vector<std::size_t>& topics_;
  WheelMessages messages_;
  std::map<std::size_t, Moment> moments_{};               ///< the last ones, by topic
  std::map<std::size_t, std::vector<SeenWheel>> seen_{};  ///< by topic
  std::set<std::size_t> steers_{};                        ///< topics with joints that steer
};

}  // namespace

WheelUnit WheelCandidate::unit() const { return wheels.front().field.unit; }

bool WheelCandidate::tells_angles() const {
  return unit() != WheelUnit::kCounts || std::ranges::all_of(wheels, [](const PlannedWheel& wheel) {
           return !wheel.field.resolution.empty();
         });
}

std::vector<std::string> WheelCandidate::names(const TopicSurvey& survey) const {
  std::vector<std::string> names;
  const bool is_one_topic = std::ranges::all_of(
      wheels, [&](const PlannedWheel& wheel) { return wheel.topic == wheels.front().topic; });
  for (const PlannedWheel& wheel : wheels) {
    const std::string& own = wheel.name.empty() ? wheel.field.path : wheel.name;
    names.push_back(is_one_topic ? own : survey.topics[wheel.topic].name);
  }
  return names;
}

std::vector<WheelCandidate> survey_wheels(Recording& recording, TopicSurvey& survey,
                                          const std::vector<std::size_t>& topics) {
  return WheelSurveyor(recording, survey, topics).run();
}

}  // namespace loopstone
