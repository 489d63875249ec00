#include "formats/topic_choice.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <tuple>

#include "formats/ros_geometry.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/formats/log_format_words.hpp"
#include "loopstone/geometry/angle.hpp"
#include "loopstone/geometry/roll_pitch_yaw.hpp"

namespace loopstone {
namespace {

using std::string_view;

/// Frames that robots call their own, the best first (REP-105, REP-120).
constexpr std::array<string_view, 6> kBaseFrames{"base_footprint", "base_link",  "base",
                                                 "base_frame",     "robot_base", "chassis"};
constexpr std::array<string_view, 3> kOdometryFrames{"odom", "odom_combined", "odometry"};
/// Words in names of poses that are no dead reckoning: somebody else's result, or the truth.
constexpr std::array<string_view, 14> kNoOdometry{"truth", "ground", "mocap",  "vicon", "optitrack",
                                                  "gps",   "gnss",   "amcl",   "slam",  "icp",
                                                  "lidar", "laser",  "visual", "map"};
/// Words in names of lasers that do not look ahead in the plane.
constexpr std::array<string_view, 6> kOtherWay{"vertical", "tilt", "down", "up", "cliff", "safety"};

std::string lower(string_view text) {
  std::string result(text);
  for (char& c : result) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return result;
}

/// Whether a name holds one of the words between its separators.
template <std::size_t kCount>
bool holds_word(string_view name, const std::array<string_view, kCount>& words) {
  const std::string text = lower(name);
  return std::ranges::any_of(words, [&](string_view word) {
    for (auto at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) {
      const bool begins = at == 0 || std::isalnum(static_cast<unsigned char>(text[at - 1])) == 0;
      const bool is_long = word.size() > 3;
      const std::size_t end = at + word.size();
      const bool ends =
          end == text.size() || std::isalnum(static_cast<unsigned char>(text[end])) == 0;
      if (is_long || (begins && ends)) return true;
    }
    return false;
  });
}

/// "base_link" of "robot1/base_link".
string_view last_part(string_view frame) { return frame.substr(frame.rfind('/') + 1); }

template <std::size_t kCount>
bool is_one_of(string_view frame, const std::array<string_view, kCount>& names) {
  return std::ranges::find(names, last_part(frame)) != names.end();
}

/// Rounded first, so that nothing is "-0.000".
std::string metres(double value_m) {
  return fmt::format("{:.3f} m", std::round(1e3 * value_m) / 1e3 + 0.0);
}
std::string tenths_of_degrees(double angle_rad) {
  return fmt::format("{:.1f}", std::round(10.0 * degrees(angle_rad)) / 10.0 + 0.0);
}

std::string laser_mount_text(const Pose3& base_T_laser) {
  const Pose2 pose = to_pose2(base_T_laser);
  return fmt::format("x {}, y {}, yaw {:.1f} deg, {} up{}", metres(pose.x), metres(pose.y),
                     degrees(pose.yaw), metres(base_T_laser.translation.z()),
                     is_upside_down(base_T_laser) ? ", upside down" : "");
}

class Chooser {
 public:
  Chooser(const TopicSurvey& survey, const TopicOptions& options)
      : survey_(survey), options_(options) {
    choice_.roles.assign(survey.topics.size(), TopicRole::kNone);
    choice_.remarks.assign(survey.topics.size(), {});
    for (std::size_t i = 0; i < survey.topics.size(); ++i) {
      if (topic(i).kind == TopicKind::kTransforms) choice_.roles[i] = TopicRole::kTransforms;
      choice_.remarks[i] = topic(i).fault;
    }
  }

  TopicChoice run() {
    choose_odometry_topic();
    choose_base();
    if (!choice_.odometry) choose_odometry_frame();
    choose_lasers();
    choose_imu();
    choose_wheels();
    if (options_.pictures) choose_camera();
    tell_of_several_robots();
    tell();
    return std::move(choice_);
  }

 private:
  [[nodiscard]] const TopicFacts& topic(std::size_t i) const { return survey_.topics[i]; }

  template <typename Fits>
  [[nodiscard]] std::vector<std::size_t> all(Fits&& fits) const {
    std::vector<std::size_t> found;
    for (std::size_t i = 0; i < survey_.topics.size(); ++i) {
      if (fits(topic(i))) found.push_back(i);
    }
    return found;
  }

  /// The topics that the user named for a role; nothing when the role was left to us.
  template <typename Fits>
  std::optional<std::vector<std::size_t>> named(TopicRole role, Fits&& fits) const {
    std::optional<std::vector<std::size_t>> found;
    for (const auto& choice : options_.named) {
      if (choice.first != role) continue;
      const std::string& name = choice.second;
      if (!found) found.emplace();
      if (name.empty()) continue;
      const std::vector<std::size_t> places =
          all([&](const TopicFacts& t) { return t.name == name || t.name == "/" + name; });
      if (places.empty()) refuse(role, name, "there is no such topic", fits);
      for (const std::size_t place : places) {
        if (!fits(topic(place))) {
          refuse(role, name, "a topic of " + topic(place).type + " can't be that", fits);
        }
        if (!topic(place).fault.empty()) refuse(role, name, topic(place).fault, fits);
        if (std::ranges::find(*found, place) == found->end()) found->push_back(place);
      }
    }
    return found;
  }

  template <typename Fits>
  [[noreturn]] void refuse(TopicRole role, const std::string& name, const std::string& reason,
                           Fits&& fits) const {
    std::vector<std::string> others;
    for (const std::size_t i : all(fits)) {
      if (topic(i).fault.empty()) others.push_back(topic(i).name);
    }
    throw UsageError(fmt::format(
        "--topic {}={}: {}; {}", to_string(role), name, reason,
        others.empty() ? "none of this recording can" : "there is " + listed(others, "and")));
  }

  /// How much a pose topic looks like the robot's own dead reckoning; 0: not at all.
  [[nodiscard]] int likeness_to_odometry(const TopicFacts& facts) const {
    if (last_part(facts.frame) == "map" || last_part(facts.frame) == "world") return 0;
    const std::string name = lower(facts.name);
    if (holds_word(name, kNoOdometry)) return 0;
    if (name == "/odom" || name == "odom") return 4;
    if (name.ends_with("/odom")) return 3;
    return name.find("odom") != std::string::npos || name.find("wheel") != std::string::npos ? 2
                                                                                             : 1;
  }

  void choose_odometry_topic() {
    const auto fits = [](const TopicFacts& t) { return t.kind == TopicKind::kOdometry; };
    const auto by_user = named(TopicRole::kOdometry, fits);
    std::vector<std::size_t> found = by_user.value_or(std::vector<std::size_t>{});
    if (!by_user) {
      found = all([&](const TopicFacts& t) {
        return fits(t) && t.has_messages() && t.fault.empty() && likeness_to_odometry(t) > 0;
      });
      std::ranges::stable_sort(found, [&](std::size_t a, std::size_t b) {
        return std::tuple(likeness_to_odometry(topic(a)), topic(a).rate_hz()) >
               std::tuple(likeness_to_odometry(topic(b)), topic(b).rate_hz());
      });
    }
    no_odometry_ = by_user && by_user->empty();
    for (const std::size_t i : all(fits)) {
      if (choice_.remarks[i].empty()) {
        choice_.remarks[i] = likeness_to_odometry(topic(i)) == 0
                                 ? "poses that are no dead reckoning, by name or frame"
                                 : "another one is used";
      }
    }
    if (found.empty()) return;
    use(found.front(), TopicRole::kOdometry);
    const TopicFacts& used = topic(found.front());
    // Some drivers name the fixed frame as the one that moves.
    const bool has_child =
        used.child_frame != used.frame && !is_one_of(used.child_frame, kOdometryFrames);
    choice_.odometry = {.topic = found.front(),
                        .parent = used.frame,
                        .child = has_child ? used.child_frame : std::string()};
  }

  void choose_base() {
    const FrameTree& frames = survey_.frames;
    if (!options_.base_frame.empty()) {
      choice_.base_frame = frame_name(options_.base_frame);
      if (!frames.has(choice_.base_frame)) {
        choice_.warnings.push_back("no tf names the frame '" + choice_.base_frame +
                                   "', which is to be the robot's");
      }
      return;
    }
    const std::string child = choice_.odometry ? choice_.odometry->child : "";
    if (!child.empty() && frames.has(child)) {
      choice_.base_frame = child;
      return;
    }
    for (const string_view frame : kBaseFrames) {
      if (!frames.has(frame)) continue;
      choice_.base_frame = std::string(frame);
      return;
    }
    choice_.base_frame = child.empty() ? prefixed_base() : child;
  }

  /// The base frame above a laser when all names begin with the robot's: "robot1/base_link".
  [[nodiscard]] std::string prefixed_base() const {
    for (const string_view base : kBaseFrames) {
      for (const std::size_t i : all([](const TopicFacts& t) { return t.is_laser(); })) {
        for (const std::string& frame : survey_.frames.ancestry(topic(i).frame)) {
          if (last_part(frame) == base) return frame;
        }
      }
    }
    return {};
  }

  /// The frame above the robot's that odometry moves, when no topic tells odometry.
  void choose_odometry_frame() {
    if (no_odometry_ || choice_.base_frame.empty()) return;
    for (const std::string& frame : survey_.frames.ancestry(choice_.base_frame)) {
      const auto parent = survey_.frames.parent_of(frame);
      if (!parent || !is_one_of(*parent, kOdometryFrames)) continue;
      choice_.odometry = {.parent = *parent, .child = frame};
      return;
    }
  }

  void use(std::size_t i, TopicRole role) {
    choice_.roles[i] = role;
    choice_.remarks[i].clear();
  }

  [[nodiscard]] std::optional<Pose3> mount(const TopicFacts& laser) const {
    if (laser.frame.empty() || choice_.base_frame.empty()) return std::nullopt;
    return survey_.frames.find(choice_.base_frame, laser.frame);
  }

  void choose_lasers() {
    const auto fits = [](const TopicFacts& t) { return t.is_laser(); };
    std::vector<std::size_t> found;
    if (const auto by_user = named(TopicRole::kLaser, fits)) {
      found = *by_user;
    } else {
      found =
          all([&](const TopicFacts& t) { return fits(t) && t.has_messages() && t.fault.empty(); });
      drop_clouds(found);
      drop_tilted(found);
      drop_glued(found);
      drop_copies(found);
      drop_unknown(found);
    }
    std::ranges::stable_sort(found, {}, [&](std::size_t i) {
      const auto pose = mount(topic(i));
      return pose ? std::round(degrees(std::abs(to_pose2(*pose).yaw))) : 0.0;
    });
    for (const std::size_t i : found) {
      use(i, TopicRole::kLaser);
      choice_.lasers.push_back({i, mount(topic(i))});
    }
  }

  template <typename Goes>
  void drop(std::vector<std::size_t>& found, const std::string& why, Goes&& goes) {
    std::erase_if(found, [&](std::size_t i) {
      if (!goes(i)) return false;
      choice_.remarks[i] = why;
      return true;
    });
  }

  void drop_clouds(std::vector<std::size_t>& found) {
    const auto is_cloud = [&](std::size_t i) { return topic(i).kind == TopicKind::kCloud; };
    if (std::ranges::all_of(found, is_cloud)) return;
    drop(found, "a cloud beside planar scans", is_cloud);
  }

  void drop_tilted(std::vector<std::size_t>& found) {
    for (const std::size_t i : std::vector(found)) {
      const auto pose = mount(topic(i));
      if (!pose || topic(i).kind == TopicKind::kCloud) continue;
      const double tilt_deg = degrees(tilt_of(*pose));
      if (tilt_deg <= kMostTiltDeg) continue;
      drop(found, fmt::format("looks {:.0f} deg out of the horizontal", tilt_deg),
           [&](std::size_t other) { return other == i; });
    }
  }

  /// Scans in the robot's own frame beside lasers with frames of their own are glued of these.
  void drop_glued(std::vector<std::size_t>& found) {
    const auto is_base = [&](std::size_t i) { return topic(i).frame == choice_.base_frame; };
    const auto has_own = [&](std::size_t i) { return !is_base(i) && mount(topic(i)).has_value(); };
    if (std::ranges::none_of(found, has_own)) return;
    drop(found, "in the robot's own frame beside lasers with their own: glued of these", is_base);
  }

  /// Of several topics of one frame the busiest is used: a driver's beside somebody's filter of it.
  void drop_copies(std::vector<std::size_t>& found) {
    for (const std::size_t i : std::vector(found)) {
      const auto is_better = [&](std::size_t other) {
        if (other == i || topic(other).frame != topic(i).frame || topic(i).frame.empty())
          return false;
        const auto rank = [&](std::size_t t) {
          return std::tuple(std::round(topic(t).rate_hz()), topic(t).beams,
                            -static_cast<long>(topic(t).name.size()), -static_cast<long>(t));
        };
        return rank(other) > rank(i);
      };
      const auto better = std::ranges::find_if(found, is_better);
      if (better == found.end()) continue;
      const std::string why = "of the same frame as " + topic(*better).name;
      drop(found, why, [&](std::size_t other) { return other == i; });
    }
  }

  /// A laser whose place nobody tells is used only when it is the only one.
  void drop_unknown(std::vector<std::size_t>& found) {
    const auto is_known = [&](std::size_t i) { return mount(topic(i)).has_value(); };
    if (found.size() < 2 || std::ranges::all_of(found, is_known)) return;
    if (std::ranges::any_of(found, is_known)) {
      drop(found, "tf does not tell where it sits", [&](std::size_t i) { return !is_known(i); });
      return;
    }
    const auto rank = [&](std::size_t i) {
      const std::string name = topic(i).name + " " + topic(i).frame;
      return std::tuple(!holds_word(name, kOtherWay),
                        topic(i).rate_hz() * static_cast<double>(topic(i).beams));
    };
    const std::size_t best = *std::ranges::max_element(found, {}, rank);
    choice_.warnings.push_back(fmt::format(
        "{} lasers, and no tf tells where they sit: only {} is used; name others by --topic "
        "laser=NAME and their mounts by --robot",
        found.size(), topic(best).name));
    drop(found, "nothing tells where it sits", [&](std::size_t i) { return i != best; });
  }

  void choose_imu() {
    const auto fits = [](const TopicFacts& t) { return t.kind == TopicKind::kImu; };
    const auto by_user = named(TopicRole::kImu, fits);
    std::vector<std::size_t> found = by_user ? *by_user : all([&](const TopicFacts& t) {
      return fits(t) && t.has_messages() && t.fault.empty();
    });
    if (found.empty()) return;
    const auto rank = [&](std::size_t i) {
      return std::tuple(topic(i).name.ends_with("/data"), topic(i).rate_hz());
    };
    const std::size_t best = by_user ? found.front() : *std::ranges::max_element(found, {}, rank);
    for (const std::size_t i : found) choice_.remarks[i] = "another one is used";
    use(best, TopicRole::kImu);
    choice_.imu = best;
  }

  void choose_wheels() {
    const auto is_ours = [](const TopicFacts& t) { return t.kind == TopicKind::kTicks; };
    const auto fits = [&](const TopicFacts& t) {
      return is_ours(t) || t.kind == TopicKind::kJoints || t.kind == TopicKind::kCounts;
    };
    const auto by_user = named(TopicRole::kWheels, fits);
    std::vector<std::size_t> found = by_user ? *by_user : all([&](const TopicFacts& t) {
      return is_ours(t) && t.has_messages() && t.fault.empty();
    });
    // Others need more than a look at the names of topics: plan_wheels().
    std::erase_if(found, [&](std::size_t i) { return !is_ours(topic(i)); });
    if (found.empty()) return;
    use(found.front(), TopicRole::kWheels);
    choice_.wheels = found.front();
  }

  void choose_camera() {
    const auto depths = pictures_for(TopicRole::kDepth, shows_depth);
    const auto colours = pictures_for(TopicRole::kColour, shows_colour);
    auto camera = loopstone::choose_camera(survey_, choice_.base_frame, depths, colours);
    for (const std::size_t i : depths) choice_.remarks[i] = lonely_or_other(camera, "colour");
    for (const std::size_t i : colours) choice_.remarks[i] = lonely_or_other(camera, "depth");
    if (!camera) return;
    use(camera->depth, TopicRole::kDepth);
    use(camera->colour, TopicRole::kColour);
    for (const std::string& note : camera->notes) choice_.warnings.push_back(note);
    choice_.camera = std::move(camera);
  }

  [[nodiscard]] static std::string lonely_or_other(const std::optional<ChosenCamera>& camera,
                                                   const std::string& partner) {
    return camera ? "another one is used" : "no pictures of " + partner + " beside it";
  }

  /// \param shows  what it has to show; the user may know better
  std::vector<std::size_t> pictures_for(TopicRole role,
                                        bool (*shows)(const TopicFacts& topic)) const {
    const auto fits = [](const TopicFacts& t) { return t.is_picture(); };
    if (auto by_user = named(role, fits)) return *by_user;
    return all(
        [&](const TopicFacts& t) { return shows(t) && t.has_messages() && t.fault.empty(); });
  }

  /// Robots that share names of frames keep them apart by topic; here all are one tree.
  void tell_of_several_robots() {
    std::vector<std::string> moving;
    for (const TopicFacts& facts : survey_.topics) {
      if (facts.kind != TopicKind::kTransforms || !facts.has_messages()) continue;
      if (facts.name.ends_with("/tf")) moving.push_back(facts.name);
    }
    if (moving.size() < 2) return;
    choice_.warnings.push_back(listed(moving, "and") +
                               " are taken for one tf: of several robots whose frames have the "
                               "same names, poses and mounts get mixed up");
  }

  // What was chosen, in words.

  void say(TopicRole role, const std::string& text) {
    choice_.choices.push_back(fmt::format("{:<9}{}", to_string(role), text));
  }

  [[nodiscard]] std::string described(std::size_t i) const {
    const double rate_hz = topic(i).rate_hz();
    return topic(i).name + " (" + topic(i).type +
           (rate_hz > 0.0 ? fmt::format(", {:.1f} Hz)", rate_hz) : ")");
  }

  void tell() {
    if (!choice_.base_frame.empty()) {
      choice_.choices.push_back(fmt::format("{:<9}{}", "robot", "frame " + choice_.base_frame));
    }
    for (const ChosenLaser& laser : choice_.lasers) tell(laser);
    if (!choice_.odometry) {
      say(TopicRole::kOdometry, "none");
    } else if (choice_.odometry->topic) {
      const std::string& child = choice_.odometry->child;
      say(TopicRole::kOdometry,
          described(*choice_.odometry->topic) + (child.empty() ? "" : ", poses of " + child));
    } else {
      say(TopicRole::kOdometry,
          "tf, " + choice_.odometry->parent + " to " + choice_.odometry->child);
    }
    if (choice_.imu) say(TopicRole::kImu, described(*choice_.imu));
    if (choice_.wheels) say(TopicRole::kWheels, described(*choice_.wheels));
    if (choice_.camera) tell(*choice_.camera);
  }

  void tell(const ChosenCamera& camera) {
    say(TopicRole::kDepth,
        described(camera.depth) + (camera.fault.empty() ? ", " + camera_mount_text(camera) : ""));
    say(TopicRole::kColour, described(camera.colour));
  }

  [[nodiscard]] static std::string camera_mount_text(const ChosenCamera& camera) {
    const Pose3& pose = camera.model.robot_T_camera;
    const Eigen::Vector3d angles = to_roll_pitch_yaw(pose);
    return fmt::format("x {}, y {}, yaw {} deg, {} up, looks {:.0f} deg down{}",
                       metres(pose.translation.x()), metres(pose.translation.y()),
                       tenths_of_degrees(angles.z()), metres(pose.translation.z()),
                       degrees(angles.y()), camera.mount_moves ? ", and moves" : "");
  }

  void tell(const ChosenLaser& laser) {
    const TopicFacts& facts = topic(laser.topic);
    if (!laser.base_T_laser) {
      say(TopicRole::kLaser, described(laser.topic) + ", no mount in tf");
      choice_.warnings.push_back(fmt::format(
          "{}: no tf tells where its frame '{}' sits on the robot; --robot FILE says it, else the "
          "laser is taken for the robot's centre",
          facts.name, facts.frame));
      return;
    }
    say(TopicRole::kLaser, described(laser.topic) + ", " + laser_mount_text(*laser.base_T_laser));
    const double tilt_deg = degrees(tilt_of(*laser.base_T_laser));
    if (tilt_deg > kTiltWorthAWordDeg && facts.kind != TopicKind::kCloud) {
      choice_.warnings.push_back(fmt::format(
          "{}: looks {:.1f} deg out of the horizontal; far walls appear in a wrong place, and the "
          "floor may appear as a wall",
          facts.name, tilt_deg));
    }
  }

  const TopicSurvey& survey_;
  const TopicOptions& options_;
  TopicChoice choice_{};
  bool no_odometry_ = false;
};

}  // namespace

double tilt_of(const Pose3& base_T_laser) {
  const Eigen::Vector3d up = base_T_laser.rotation * Eigen::Vector3d::UnitZ();
  return std::acos(std::clamp(std::abs(up.z()), 0.0, 1.0));
}

bool is_upside_down(const Pose3& base_T_laser) {
  return (base_T_laser.rotation * Eigen::Vector3d::UnitZ()).z() < 0.0;
}

TopicChoice choose_topics(const TopicSurvey& survey, const TopicOptions& options) {
  return Chooser(survey, options).run();
}

}  // namespace loopstone
