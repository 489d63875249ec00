#include "localization/map_proof.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cstdlib>
#include <vector>

namespace loopstone {
namespace {

constexpr double kStepM = 0.1;

/// A robot that drives on a map.
struct Drive {
  MapProof proof{};
  double travelled_m = 0.0;
  double followed_m = 0.0;
  double doubt = 0.0;

  void go(double way_m, bool fits) {
    for (double gone = 0.0; gone < way_m - 0.5 * kStepM; gone += kStepM) {
      travelled_m += kStepM;
      followed_m += kStepM;
      doubt = proof.doubt_at(travelled_m, fits, followed_m);
    }
  }
  void another_place() { followed_m = 0.0; }
};

TEST(MapProof, ARobotThatIsFoundAtOnceNeverDoubtsItsMap) {
  Drive drive;
  for (int metre = 0; metre < 100; ++metre) {
    drive.go(1.0, true);
    EXPECT_EQ(drive.doubt, 0.0);
  }
}

TEST(MapProof, DoubtGrowsAsNothingFitsAndEndsWhereAPlaceHolds) {
  Drive drive;
  drive.go(2.0, false);
  const double after_two = drive.doubt;
  EXPECT_GT(after_two, 0.0);
  drive.go(20.0, false);
  EXPECT_GT(drive.doubt, after_two);
  EXPECT_NEAR(drive.doubt, 1.0, 1e-9);
  drive.go(10.0, true);
  EXPECT_LT(drive.doubt, 0.75);
  EXPECT_GT(drive.doubt, 0.25);
  drive.go(15.0, true);
  EXPECT_EQ(drive.doubt, 0.0);
  // Off the map for a while: it is the right one all the same.
  drive.go(200.0, false);
  EXPECT_EQ(drive.doubt, 0.0);
}

TEST(MapProof, PlacesThatFitOneAfterTheOtherProveNothing) {
  Drive drive;
  drive.go(10.0, false);
  for (int place = 0; place < 20; ++place) {
    drive.another_place();
    drive.go(6.0, true);
    drive.go(2.0, false);
  }
  EXPECT_GT(drive.doubt, 0.8);
}

TEST(MapProof, AGuessFromOutsideForgetsWhatWasDrivenInVain) {
  Drive drive;
  drive.go(10.0, false);
  drive.proof.begin_anew();
  drive.another_place();
  drive.go(kStepM, true);
  EXPECT_EQ(drive.doubt, 0.0);
}

RC_GTEST_PROP(MapProof, DoubtIsAShareAndAStandingRobotChangesNothing, ()) {
  Drive drive;
  for (const int way : *rc::gen::container<std::vector<int>>(rc::gen::inRange(-30, 31))) {
    if (way % 5 == 0) drive.another_place();
    drive.go(kStepM * std::abs(way), way > 0);
    RC_ASSERT(drive.doubt >= 0.0 && drive.doubt <= 1.0);
    const double before = drive.doubt;
    for (int scan = 0; scan < 100; ++scan)
      drive.doubt = drive.proof.doubt_at(drive.travelled_m, way > 0, drive.followed_m);
    if (way != 0) RC_ASSERT(drive.doubt == before);
  }
}

}  // namespace
}  // namespace loopstone
