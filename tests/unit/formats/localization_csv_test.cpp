#include "loopstone/formats/localization_csv.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "loopstone/base/error.hpp"
#include "loopstone/base/rng.hpp"
#include "support/temp_dir.hpp"

namespace loopstone {
namespace {

using testing::HasSubstr;

std::vector<LocalizationEstimate> some_estimates(int count) {
  Rng rng(5);
  std::vector<LocalizationEstimate> estimates;
  for (int i = 0; i < count; ++i) {
    LocalizationEstimate e;
    e.stamp = Stamp{1'500'000'000'123'456'789 + 100'000'007LL * i};
    e.map_T_robot = {rng.normal(), 1e3 * rng.normal(), rng.uniform(-3.1, 3.1)};
    const Eigen::Matrix3d root =
        Eigen::Matrix3d::NullaryExpr([&](Eigen::Index, Eigen::Index) { return rng.normal(); });
    e.covariance = root * root.transpose();
    e.covariance.triangularView<Eigen::StrictlyLower>() = e.covariance.transpose();
    e.state = static_cast<LocalizationState>(i % 3);
    e.probability = rng.uniform();
    e.refined = i % 2 == 0;
    e.hypotheses = i;
    e.particles = 100 * i;
    e.travelled_m = 0.1 * i;
    e.evidence = {rng.uniform(), rng.uniform(), rng.uniform(), rng.uniform(),
                  rng.uniform(), rng.uniform(), rng.uniform(), rng.uniform()};
    e.evidence.known = rng.uniform();
    e.evidence.silent = rng.uniform();
    for (FitOverWay* fit : {&e.evidence.lately, &e.evidence.along})
      *fit = {rng.uniform(), rng.uniform(), rng.uniform(), rng.uniform(), rng.uniform()};
    estimates.push_back(e);
  }
  return estimates;
}

void expect_same(const LocalizationEstimate& a, const LocalizationEstimate& b) {
  EXPECT_EQ(a.stamp, b.stamp);
  EXPECT_EQ(a.map_T_robot, b.map_T_robot);
  EXPECT_EQ(a.covariance, b.covariance);
  EXPECT_EQ(a.state, b.state);
  EXPECT_EQ(a.probability, b.probability);
  EXPECT_EQ(a.refined, b.refined);
  EXPECT_EQ(a.hypotheses, b.hypotheses);
  EXPECT_EQ(a.particles, b.particles);
  EXPECT_EQ(a.travelled_m, b.travelled_m);
  EXPECT_EQ(a.evidence.explained, b.evidence.explained);
  EXPECT_EQ(a.evidence.violations, b.evidence.violations);
  EXPECT_EQ(a.evidence.unexpected, b.evidence.unexpected);
  EXPECT_EQ(a.evidence.mass, b.evidence.mass);
  EXPECT_EQ(a.evidence.precision, b.evidence.precision);
  EXPECT_EQ(a.evidence.spread_m, b.evidence.spread_m);
  EXPECT_EQ(a.evidence.spread_rad, b.evidence.spread_rad);
  EXPECT_EQ(a.evidence.innovation, b.evidence.innovation);
  EXPECT_EQ(a.evidence.followed_m, b.evidence.followed_m);
  EXPECT_EQ(a.evidence.known, b.evidence.known);
  EXPECT_EQ(a.evidence.silent, b.evidence.silent);
  EXPECT_EQ(a.evidence.lately, b.evidence.lately);
  EXPECT_EQ(a.evidence.along, b.evidence.along);
}

std::string error_of(std::string_view text) {
  try {
    (void)parse_localization_csv(text, "where.csv");
  } catch (const DataError& error) {
    return error.what();
  }
  return "accepted";
}

constexpr const char* kLeastHeader =
    "t_s,x_m,y_m,yaw_rad,xx_m2,xy_m2,xyaw_m_rad,yy_m2,yyaw_m_rad,yawyaw_rad2,state,probability\n";

TEST(LocalizationCsv, EveryBitSurvives) {
  const test::TempDir dir;
  const auto estimates = some_estimates(50);
  write_localization_csv(dir / "where.csv", estimates);
  const auto read = read_localization_csv(dir / "where.csv");
  ASSERT_EQ(read.size(), estimates.size());
  for (std::size_t i = 0; i < read.size(); ++i) expect_same(read[i], estimates[i]);
}

TEST(LocalizationCsv, ColumnsAreNamedWithUnits) {
  const std::string text = format_localization_csv({});
  EXPECT_EQ(
      text,
      "t_s,x_m,y_m,yaw_rad,xx_m2,xy_m2,xyaw_m_rad,yy_m2,yyaw_m_rad,yawyaw_rad2,state,"
      "probability,refined,hypotheses,particles,landmarks,travelled_m,explained,violations,"
      "unexpected,mass,precision,spread_m,spread_rad,innovation,followed_m,known,silent,unproven,"
      "lately_explained,lately_violations,lately_unexpected,lately_known,lately_silent,"
      "along_explained,along_violations,along_unexpected,along_known,along_silent\n");
  EXPECT_TRUE(parse_localization_csv(text).empty());
}

TEST(LocalizationCsv, NothingPrintsAsMinusZeroOrNan) {
  LocalizationEstimate e;
  e.map_T_robot = {-0.0, 0.0, 0.0};
  e.covariance(0, 0) = std::numeric_limits<double>::quiet_NaN();
  e.evidence.innovation = std::numeric_limits<double>::infinity();
  const std::string text = format_localization_csv({e});
  EXPECT_EQ(text.find('-'), std::string::npos) << text;
  EXPECT_EQ(text.find("inf"), std::string::npos) << text;
  EXPECT_EQ(text.find("nan"), std::string::npos) << text;
  const auto read = parse_localization_csv(text);
  EXPECT_TRUE(std::isnan(read.at(0).covariance(0, 0)));
  EXPECT_EQ(read[0].covariance(1, 1), 0.0);
}

TEST(LocalizationCsv, ColumnsMayChangePlacesAndOthersBeThere) {
  const auto read = parse_localization_csv(
      "remark,state,t_s,probability,yaw_rad,y_m,x_m,xx_m2,xy_m2,xyaw_m_rad,yy_m2,yyaw_m_rad,"
      "yawyaw_rad2\r\nhello, LOST ,12.5,0.25,3,2,1,4,5,6,7,8,9\r\n\r\n");
  ASSERT_EQ(read.size(), 1u);
  EXPECT_EQ(read[0].state, LocalizationState::kLost);
  EXPECT_EQ(read[0].stamp, Stamp{12'500'000'000});
  EXPECT_EQ(read[0].map_T_robot, (Pose2{1.0, 2.0, 3.0}));
  EXPECT_EQ(read[0].covariance(2, 0), 6.0);
  EXPECT_EQ(read[0].covariance(0, 2), 6.0);
  EXPECT_EQ(read[0].covariance(2, 1), 8.0);
}

TEST(LocalizationCsv, DamageNamesItsLine) {
  const std::string head = kLeastHeader;
  const std::string good = "1,2,3,4,5,6,7,8,9,10,TRACKING,0.5\n";
  EXPECT_EQ(error_of(head + good), "accepted");
  EXPECT_THAT(error_of(""), HasSubstr("where.csv: is empty"));
  EXPECT_THAT(error_of("t_s,x_m\n"), HasSubstr("where.csv:1: there is no column state"));
  EXPECT_THAT(error_of(head + good + "1,2,3\n"),
              HasSubstr("where.csv:3: the line has 3 values, the first line names 12"));
  EXPECT_THAT(error_of(head + "x,2,3,4,5,6,7,8,9,10,TRACKING,0.5"),
              HasSubstr("where.csv:2: the time"));
  EXPECT_THAT(error_of(head + "1,2,3,4,5,6,7,8,9,10,SURE,0.5"),
              HasSubstr("the state is 'SURE'; expected TRACKING"));
  EXPECT_THAT(error_of(head + "1,inf,3,4,5,6,7,8,9,10,LOST,0.5"),
              HasSubstr("'inf' can't be a value of x_m"));
  EXPECT_THAT(error_of(head + "1,2,3,4,5,6,7,8,9,10,LOST,0.5x"), HasSubstr("probability"));
  const std::string with_count = head.substr(0, head.size() - 1) + ",particles\n";
  EXPECT_THAT(error_of(with_count + "1,2,3,4,5,6,7,8,9,10,LOST,0.5,-1"), HasSubstr("particles"));
  EXPECT_THAT(error_of(with_count + "1,2,3,4,5,6,7,8,9,10,LOST,0.5,99999999999"),
              HasSubstr("particles"));
}

}  // namespace
}  // namespace loopstone
