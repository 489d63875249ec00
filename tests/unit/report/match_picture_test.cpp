#include "loopstone/report/match_picture.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "loopstone/base/error.hpp"

namespace loopstone {
namespace {

/// An L of 4 m by 3 m.
std::vector<Eigen::Vector2d> corner() {
  std::vector<Eigen::Vector2d> points;
  for (double s = 0.0; s <= 4.0; s += 0.02) points.emplace_back(s, 0.0);
  for (double s = 0.0; s <= 3.0; s += 0.02) points.emplace_back(0.0, s);
  return points;
}

/// Pixels of about this colour in the left or right half.
int count(const Image& image, const std::array<int, 3>& colour, bool right_half) {
  int found = 0;
  for (int row = 0; row < image.height * 4 / 5; ++row) {
    for (int column = right_half ? image.width / 2 : 0;
         column < (right_half ? image.width : image.width / 2); ++column) {
      int off = 0;
      for (int channel = 0; channel < 3; ++channel)
        off += std::abs(image.sample(row, column, channel) -
                        colour[static_cast<std::size_t>(channel)]);
      found += off < 40 ? 1 : 0;
    }
  }
  return found;
}

constexpr std::array<int, 3> kBlue{0x25, 0x63, 0xeb};
constexpr std::array<int, 3> kGreen{0x05, 0x96, 0x69};
constexpr std::array<int, 3> kRed{0xdc, 0x26, 0x26};

TEST(MatchPicture, BeforeIsBlueAndAGoodMatchGreen) {
  const std::vector<Eigen::Vector2d> points = corner();
  MatchScene<2> scene;
  scene.source = points;
  scene.target = points;
  scene.guess_target_T_source = {0.5, 0.3, 0.2};
  const Image image = draw_match_picture<2>(scene, {.panel_px = 300, .far_m = 0.1});
  EXPECT_EQ(image.channels, 3);
  EXPECT_GT(count(image, kBlue, false), 300);
  EXPECT_LT(count(image, kBlue, true), 20);
  EXPECT_GT(count(image, kGreen, true), 300);
  EXPECT_EQ(count(image, kRed, true), 0);
}

TEST(MatchPicture, ABadMatchIsRed) {
  const std::vector<Eigen::Vector2d> points = corner();
  MatchScene<2> scene;
  scene.source = points;
  scene.target = points;
  scene.target_T_source = {0.5, 0.5, 0.0};
  const Image image = draw_match_picture<2>(scene, {.panel_px = 300, .far_m = 0.1});
  EXPECT_GT(count(image, kRed, true), 300);
}

TEST(MatchPicture, ThreeViewsOfSpaceAndAMapUnderneath) {
  std::vector<Eigen::Vector3d> points;
  for (const Eigen::Vector2d& p : corner()) points.emplace_back(p.x(), p.y(), 0.5 * p.x());
  MatchScene<3> scene;
  scene.source = points;
  scene.target = points;
  const Image space = draw_match_picture<3>(scene, {.panel_px = 300});
  MatchScene<2> flat;
  const std::vector<Eigen::Vector2d> planar = corner();
  GridFrame frame{{-1.0, -1.0}, 0.1, 60, 50};
  CellStates map(frame, kFreeCell);
  for (int i = 0; i < 40; ++i) map[{10 + i, 9}] = kOccupiedCell;
  flat.source = planar;
  flat.target = planar;
  flat.map = &map;
  flat.shows_robot = true;
  const Image plane = draw_match_picture<2>(flat, {.panel_px = 300});
  EXPECT_GT(space.height, plane.height) << "three views one below the other";
}

TEST(MatchPicture, NothingToDrawIsRefused) {
  EXPECT_THROW((void)draw_match_picture<2>(MatchScene<2>{}), UsageError);
  const std::vector<Eigen::Vector2d> nowhere{Eigen::Vector2d::Constant(std::nan(""))};
  MatchScene<2> scene;
  scene.source = nowhere;
  EXPECT_THROW((void)draw_match_picture<2>(scene), UsageError);
}

TEST(MatchPicture, WithoutATargetAndWithASinglePoint) {
  const std::vector<Eigen::Vector2d> one{{1.0, 2.0}};
  MatchScene<2> scene;
  scene.source = one;
  EXPECT_GT(draw_match_picture<2>(scene).width, 0);
}

}  // namespace
}  // namespace loopstone
