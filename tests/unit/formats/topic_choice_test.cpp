// Which topics of a recording are used.

#include "formats/topic_choice.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "loopstone/base/error.hpp"
#include "loopstone/geometry/angle.hpp"
#include "support/pose_near.hpp"

namespace loopstone {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

Pose3 mount(double roll, double pitch, double yaw) {
  return Pose3::from_roll_pitch_yaw({0.2, 0.0, 0.3}, radians(roll), radians(pitch), radians(yaw));
}

class Survey {
 public:
  TopicFacts& add(const std::string& name, TopicKind kind, const std::string& frame = "",
                  double rate_hz = 10.0) {
    TopicFacts facts{.name = name, .type = "some/Type", .kind = kind, .seen = 50, .frame = frame};
    for (int i = 0; i < 50; ++i) {
      const Stamp stamp = Stamp::from_seconds(1e9 + i / rate_hz);
      facts.stamps.add(stamp, stamp);
    }
    if (kind == TopicKind::kScan) facts.beams = 360;
    survey.topics.push_back(facts);
    return survey.topics.back();
  }
  Survey& scan(const std::string& name, const std::string& frame, double rate_hz = 10.0) {
    add(name, TopicKind::kScan, frame, rate_hz);
    return *this;
  }
  Survey& odometry(const std::string& name, const std::string& child = "base_link",
                   const std::string& frame = "odom", double rate_hz = 10.0) {
    add(name, TopicKind::kOdometry, frame, rate_hz).child_frame = child;
    return *this;
  }
  Survey& fixed(const std::string& parent, const std::string& child, const Pose3& pose = {}) {
    survey.frames.add_fixed(parent, child, pose);
    return *this;
  }
  [[nodiscard]] TopicChoice choice(const TopicOptions& options = {}) const {
    return choose_topics(survey, options);
  }
  [[nodiscard]] std::vector<std::string> lasers(const TopicOptions& options = {}) const {
    std::vector<std::string> names;
    for (const ChosenLaser& laser : choice(options).lasers) {
      names.push_back(survey.topics[laser.topic].name);
    }
    return names;
  }
  [[nodiscard]] std::string odometry_topic(const TopicOptions& options = {}) const {
    const auto odometry = choice(options).odometry;
    return odometry && odometry->topic ? survey.topics[*odometry->topic].name : "";
  }
  [[nodiscard]] std::string remark(const std::string& name) const {
    const auto choice = this->choice();
    for (std::size_t i = 0; i < survey.topics.size(); ++i) {
      if (survey.topics[i].name == name) return choice.remarks[i];
    }
    return "no such topic";
  }

  TopicSurvey survey{};
};

TEST(TopicChoice, TheRobotsOwnOdometryIsPreferred) {
  Survey survey;
  survey.odometry("/ground_truth/odom").odometry("/vicon/pose").odometry("/amcl_odom");
  survey.odometry("/odometry/gps").odometry("/tracked", "base_link", "map");
  survey.odometry("/tracked2", "base_link", "robot1/map");
  EXPECT_EQ(survey.odometry_topic(), "");
  EXPECT_THAT(survey.remark("/vicon/pose"), HasSubstr("no dead reckoning"));
  survey.odometry("/pose_of_somebody");
  EXPECT_EQ(survey.odometry_topic(), "/pose_of_somebody");
  survey.odometry("/wheel/odometry", "base_link", "odom", 50.0);
  EXPECT_EQ(survey.odometry_topic(), "/wheel/odometry");
  survey.odometry("/robot1/odom");
  EXPECT_EQ(survey.odometry_topic(), "/robot1/odom");
  survey.odometry("/odom");
  EXPECT_EQ(survey.odometry_topic(), "/odom");
  EXPECT_EQ(survey.remark("/robot1/odom"), "another one is used");
  EXPECT_EQ(survey.odometry_topic({.named = {{TopicRole::kOdometry, "/vicon/pose"}}}),
            "/vicon/pose");
  EXPECT_FALSE(survey.choice({.named = {{TopicRole::kOdometry, ""}}}).odometry);
}

TEST(TopicChoice, OdometryByTf) {
  Survey survey;
  survey.scan("/scan", "laser").fixed("base_footprint", "base_link").fixed("base_link", "laser");
  survey.survey.frames.add("odom", "base_footprint", Stamp{1}, {});
  const TopicChoice choice = survey.choice();
  ASSERT_TRUE(choice.odometry);
  EXPECT_FALSE(choice.odometry->topic);
  EXPECT_EQ(choice.odometry->parent, "odom");
  EXPECT_EQ(choice.odometry->child, "base_footprint");
  EXPECT_THAT(choice.choices, Contains(HasSubstr("tf, odom to base_footprint")));
  EXPECT_FALSE(survey.choice({.named = {{TopicRole::kOdometry, ""}}}).odometry);
}

TEST(TopicChoice, TheRobotsFrame) {
  Survey survey;
  EXPECT_EQ(survey.choice().base_frame, "");
  survey.fixed("base_link", "laser");
  EXPECT_EQ(survey.choice().base_frame, "base_link");
  survey.fixed("base_footprint", "base_link");
  EXPECT_EQ(survey.choice().base_frame, "base_footprint");
  survey.odometry("/odom", "base_link");
  EXPECT_EQ(survey.choice().base_frame, "base_link");
  EXPECT_EQ(survey.choice({.base_frame = "/laser"}).base_frame, "laser");
  EXPECT_THAT(survey.choice({.base_frame = "nowhere"}).warnings, Contains(HasSubstr("'nowhere'")));
}

TEST(TopicChoice, FramesOfOneRobotAmongSeveral) {
  Survey survey;
  survey.scan("/robot1/scan", "robot1/laser").fixed("robot1/base_link", "robot1/laser");
  survey.survey.frames.add("robot1/odom", "robot1/base_link", Stamp{1}, {});
  const TopicChoice choice = survey.choice();
  EXPECT_EQ(choice.base_frame, "robot1/base_link");
  ASSERT_EQ(choice.lasers.size(), 1u);
  EXPECT_TRUE(choice.lasers[0].base_T_laser);
  ASSERT_TRUE(choice.odometry);
  EXPECT_EQ(choice.odometry->parent, "robot1/odom");
}

TEST(TopicChoice, TfOfSeveralRobotsIsWarnedOf) {
  Survey survey;
  survey.add("/robot1/tf", TopicKind::kTransforms);
  survey.add("/robot1/tf_static", TopicKind::kTransforms);
  EXPECT_THAT(survey.choice().warnings, IsEmpty());
  survey.add("/robot2/tf", TopicKind::kTransforms);
  EXPECT_THAT(survey.choice().warnings,
              ElementsAre(HasSubstr("/robot1/tf and /robot2/tf are taken for one")));
}

TEST(TopicChoice, OdometryThatNamesTheFixedFrameAsItsOwn) {
  for (const char* const child : {"odom", "odom_combined", ""}) {
    Survey survey;
    survey.odometry("/odom", child).scan("/scan", "laser").fixed("base_link", "laser");
    survey.survey.frames.add("odom", "base_link", Stamp{1}, {});
    const TopicChoice choice = survey.choice();
    EXPECT_EQ(choice.base_frame, "base_link") << child;
    EXPECT_EQ(choice.odometry->child, "") << child;
  }
}

TEST(TopicChoice, TiltedLasersAreNamedOrDropped) {
  Survey survey;
  survey.scan("/scan", "a").fixed("base_link", "a", mount(0, 5, 0));
  survey.scan("/vertical", "b").fixed("base_link", "b", mount(90, 0, 0));
  survey.scan("/hangs", "c").fixed("base_link", "c", mount(180, 0, 90));
  EXPECT_THAT(survey.lasers(), ElementsAre("/scan", "/hangs"));
  EXPECT_THAT(survey.remark("/vertical"), HasSubstr("90 deg out of"));
  const TopicChoice choice = survey.choice();
  EXPECT_THAT(choice.warnings, ElementsAre(HasSubstr("/scan: looks 5.0 deg")));
  EXPECT_THAT(choice.choices, Contains(AllOf(HasSubstr("/hangs"), HasSubstr("upside down"),
                                             HasSubstr("yaw 90.0 deg"))));
  EXPECT_THAT(survey.lasers({.named = {{TopicRole::kLaser, "vertical"}}}), ElementsAre("/vertical"))
      << "what the user names is used";
  EXPECT_NEAR(tilt_of(mount(180, 5, 30)), radians(5), 1e-9);
  EXPECT_TRUE(is_upside_down(mount(180, 5, 30)));
  EXPECT_FALSE(is_upside_down(mount(5, 5, 30)));
}

TEST(TopicChoice, TwoCornerLasersBeforeTheScanThatIsGluedOfThem) {
  Survey survey;
  survey.scan("/scan", "base_link").scan("/rear", "rear").scan("/front", "front");
  survey.fixed("base_link", "rear", mount(0, 0, -135)).fixed("base_link", "front", mount(0, 0, 45));
  EXPECT_THAT(survey.lasers(), ElementsAre("/front", "/rear"));
  EXPECT_THAT(survey.remark("/scan"), HasSubstr("glued"));
  Survey alone;
  alone.scan("/scan", "base_link").fixed("base_link", "front");
  EXPECT_THAT(alone.lasers(), ElementsAre("/scan"));
}

TEST(TopicChoice, OfCopiesTheBusiestIsUsed) {
  Survey survey;
  survey.scan("/scan_filtered", "laser").scan("/scan", "laser").scan("/slow", "laser", 1.0);
  survey.fixed("base_link", "laser");
  EXPECT_THAT(survey.lasers(), ElementsAre("/scan"));
  EXPECT_THAT(survey.remark("/slow"), HasSubstr("same frame as"));
  survey.survey.topics[0].beams = 720;
  EXPECT_THAT(survey.lasers(), ElementsAre("/scan_filtered"));
}

TEST(TopicChoice, TwoLasersWithoutAnyTf) {
  Survey survey;
  survey.scan("/vertical_laser", "v", 40.0).scan("/horizontal_laser", "h", 20.0);
  EXPECT_THAT(survey.lasers(), ElementsAre("/horizontal_laser"));
  EXPECT_THAT(survey.choice().warnings,
              Contains(AllOf(HasSubstr("2 lasers"), HasSubstr("only /horizontal_laser"))));
  EXPECT_THAT(survey.choice().warnings, Contains(HasSubstr("no tf tells where its frame 'h'")));
  survey.fixed("base_link", "v");
  EXPECT_THAT(survey.lasers(), ElementsAre("/vertical_laser")) << "the one whose place is known";
}

TEST(TopicChoice, LasersWithoutAFrameAreNoCopies) {
  Survey survey;
  survey.scan("/a", "").scan("/b", "");
  EXPECT_EQ(survey.lasers().size(), 1u);
  EXPECT_THAT(survey.choice().warnings, Contains(HasSubstr("2 lasers")));
}

TEST(TopicChoice, CloudsOnlyWithoutPlanarScans) {
  Survey survey;
  survey.add("/points", TopicKind::kCloud, "velodyne");
  survey.fixed("base_link", "velodyne", mount(0, 40, 0));
  EXPECT_THAT(survey.lasers(), ElementsAre("/points"));
  EXPECT_THAT(survey.choice().warnings, IsEmpty())
      << "a slice is level whatever the scanner's tilt";
  survey.scan("/scan", "laser").fixed("base_link", "laser");
  EXPECT_THAT(survey.lasers(), ElementsAre("/scan"));
  EXPECT_THAT(survey.remark("/points"), HasSubstr("cloud beside"));
  EXPECT_THAT(
      survey.lasers({.named = {{TopicRole::kLaser, "/points"}, {TopicRole::kLaser, "scan"}}}),
      ElementsAre("/points", "/scan"));
}

std::string refusal(const Survey& survey, TopicRole role, const std::string& name) {
  try {
    (void)survey.choice({.named = {{role, name}}});
  } catch (const UsageError& error) {
    return error.what();
  }
  return "none";
}

TEST(TopicChoice, ATopicThatIsNamedTwiceIsOneLaser) {
  Survey survey;
  survey.scan("/a", "a").scan("/b", "b").fixed("base_link", "a").fixed("base_link", "b");
  EXPECT_THAT(survey.lasers({.named = {{TopicRole::kLaser, "/b"}, {TopicRole::kLaser, "b"}}}),
              ElementsAre("/b"));
  EXPECT_THAT(survey.lasers({.named = {{TopicRole::kLaser, ""}}}), IsEmpty());
}

TEST(TopicChoice, TopicsThatCantBeReadAreNotChosen) {
  Survey survey;
  survey.scan("/json", "laser").survey.topics[0].fault = "encoded as json";
  EXPECT_THAT(survey.lasers(), IsEmpty());
  EXPECT_EQ(survey.remark("/json"), "encoded as json");
  EXPECT_THROW((void)survey.lasers({.named = {{TopicRole::kLaser, "/json"}}}), UsageError);
  EXPECT_THAT(refusal(survey, TopicRole::kLaser, "/json"), HasSubstr("encoded as json; none of"));
  Survey empty;
  empty.scan("/silent", "laser").survey.topics[0].seen = 0;
  EXPECT_THAT(empty.lasers(), IsEmpty());
}

TEST(TopicChoice, WhatIsNotThereIsRefusedWithWhatIs) {
  Survey survey;
  survey.scan("/front", "a").scan("/rear", "b").odometry("/odom");
  EXPECT_THAT(refusal(survey, TopicRole::kLaser, "/scan"),
              AllOf(HasSubstr("--topic laser=/scan: there is no such topic"),
                    HasSubstr("/front and /rear"), testing::Not(HasSubstr("/odom"))));
  EXPECT_THAT(refusal(survey, TopicRole::kLaser, "/odom"),
              AllOf(HasSubstr("some/Type can't be that"), HasSubstr("/front and /rear")));
  EXPECT_THAT(refusal(survey, TopicRole::kImu, "/imu"), HasSubstr("none of this recording can"));
  EXPECT_EQ(refusal(survey, TopicRole::kOdometry, "odom"), "none") << "without its slash";
}

TEST(TopicChoice, TheImuWithTheMostToSay) {
  Survey survey;
  survey.add("/imu/raw", TopicKind::kImu, "imu", 400.0);
  survey.add("/camera/imu", TopicKind::kImu, "imu", 100.0);
  EXPECT_EQ(survey.choice().imu, 0u);
  survey.add("/imu/data", TopicKind::kImu, "imu", 50.0);
  EXPECT_EQ(survey.choice().imu, 2u);
  EXPECT_EQ(survey.choice({.named = {{TopicRole::kImu, "/camera/imu"}}}).imu, 1u);
  EXPECT_FALSE(survey.choice({.named = {{TopicRole::kImu, ""}}}).imu);
  EXPECT_EQ(survey.choice().roles[2], TopicRole::kImu);
}

}  // namespace
}  // namespace loopstone
