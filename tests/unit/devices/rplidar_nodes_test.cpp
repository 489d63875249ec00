#include "devices/rplidar_nodes.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "loopstone/geometry/angle.hpp"

namespace loopstone {
namespace {

constexpr double kDegree = kPi / 180.0;

std::string byte(int number) { return {static_cast<char>(number)}; }

std::string node(double angle_deg, int range_mm, int quality = 15, bool begins = false) {
  const auto angle_q6 = static_cast<int>(std::lround(angle_deg * 64.0));
  return byte(quality << 2 | (begins ? 1 : 2)) + byte((angle_q6 << 1 & 0xFE) | 1) +
         byte(angle_q6 >> 7) + byte(range_mm * 4 & 255) + byte(range_mm * 4 >> 8);
}

/// Turns of 100 nodes, each with its number as range.
std::string nodes_text(int count) {
  std::string text;
  for (int i = 0; i < count; ++i) text += node(3.6 * (i % 100), 1000 + i, 15, i % 100 == 0);
  return text;
}

std::string capsule(double start_deg, const std::string& body, bool first = false) {
  const auto start_q6 = static_cast<int>(std::lround(start_deg * 64.0));
  const std::string rest = byte(start_q6 & 255) + byte(start_q6 >> 8 | (first ? 128 : 0)) + body;
  unsigned sum = 0;
  for (const char c : rest) sum ^= static_cast<unsigned char>(c);
  return byte(static_cast<int>(0xA0 | (sum & 15U))) + byte(static_cast<int>(0x50 | sum >> 4U)) +
         rest;
}
std::string dense_body(int range_mm) {
  std::string body;
  for (int i = 0; i < 40; ++i) body += byte((range_mm + i) & 255) + byte((range_mm + i) >> 8);
  return body;
}

TEST(RplidarNodes, NodesAreDecoded) {
  RplidarNodes nodes(RplidarAnswer::kNodes);
  const auto all =
      nodes.add(node(0.5, 1234, 47, true) + node(359.984375, 10) + node(90.0, 0, 0) + "x");
  ASSERT_EQ(all.size(), 2U);  // the last waits for the next
  EXPECT_NEAR(all[0].angle_rad, 0.5 * kDegree, 1e-12);
  EXPECT_DOUBLE_EQ(all[0].range_m, 1.234);
  EXPECT_EQ(all[0].quality, 47);
  EXPECT_TRUE(all[0].begins_turn);
  EXPECT_NEAR(all[1].angle_rad, 359.984375 * kDegree, 1e-12);
  EXPECT_FALSE(all[1].begins_turn);
  EXPECT_EQ(nodes.samples(), 2);
  EXPECT_EQ(nodes.bytes_since(), 5U + 6U);
}

TEST(RplidarNodes, WithoutQualityThereIsNoReturn) {
  RplidarNodes nodes(RplidarAnswer::kNodes);
  const auto all = nodes.add(node(10.0, 500, 0) + node(11.0, 500, 1) + node(12.0, 1));
  ASSERT_EQ(all.size(), 2U);
  EXPECT_EQ(all[0].range_m, 0.0);
  EXPECT_EQ(all[1].range_m, 0.5);
}

TEST(RplidarNodes, PiecesDoNotMatter) {
  const std::string text = nodes_text(300);
  RplidarNodes whole(RplidarAnswer::kNodes);
  const auto expected = whole.add(text);
  RplidarNodes pieces(RplidarAnswer::kNodes);
  std::vector<RplidarNode> got;
  for (const char c : text) {
    for (const RplidarNode& one : pieces.add({&c, 1})) got.push_back(one);
  }
  ASSERT_EQ(got.size(), expected.size());
  for (std::size_t i = 0; i < got.size(); ++i) {
    EXPECT_EQ(got[i].range_m, expected[i].range_m);
    EXPECT_EQ(got[i].sample, expected[i].sample);
  }
  EXPECT_EQ(pieces.gaps(), 0);
}

TEST(RplidarNodes, ALostByteCostsOneGapWhereverItIs) {
  const std::string text = nodes_text(300);
  for (std::size_t lost = 700; lost < 720; ++lost) {
    RplidarNodes nodes(RplidarAnswer::kNodes);
    std::string damaged = text;
    damaged.erase(lost, 1);
    int gaps = 0;
    int wrong = 0;
    std::size_t count = 0;
    for (const RplidarNode& one : nodes.add(damaged)) {
      gaps += one.after_gap ? 1 : 0;
      // Numbers of nodes that were taken from between two others.
      const double turned = one.angle_rad / (3.6 * kDegree);
      const double number = (one.range_m - 1.0) * 1000.0;
      if (std::abs(turned - std::fmod(number, 100.0)) > 0.05) ++wrong;
      ++count;
    }
    EXPECT_EQ(nodes.gaps(), 1) << lost;
    EXPECT_EQ(gaps, 1) << lost;
    EXPECT_LE(wrong, 2) << lost;
    EXPECT_GT(count, 290U) << lost;
  }
}

TEST(RplidarNodes, ExpressCapsulesAreDecoded) {
  // 16 cabins: ranges 1000 + i mm, compensations of i deg / 8.
  std::string body;
  for (int i = 0; i < 32; i += 2) {
    for (const int k : {i, i + 1}) {
      const int word = (1000 + k) << 2 | k >> 4;
      body += byte(word & 255) + byte(word >> 8);
    }
    body += byte((i + 1) % 16 << 4 | i % 16);
  }
  RplidarNodes nodes(RplidarAnswer::kCapsules);
  EXPECT_TRUE(nodes.add(capsule(350.0, body, true)).empty());
  const auto all = nodes.add(capsule(22.0, body));  // 1 deg from one to the next
  ASSERT_EQ(all.size(), 32U);
  int begins = 0;
  for (int i = 0; i < 32; ++i) {
    const RplidarNode& one = all[static_cast<std::size_t>(i)];
    EXPECT_DOUBLE_EQ(one.range_m, (1000 + i) / 1000.0);
    const double expected_deg = std::fmod(350.0 + i - i / 8.0 + 360.0, 360.0);
    EXPECT_NEAR(one.angle_rad, expected_deg * kDegree, 1e-9) << i;
    if (one.begins_turn) {
      ++begins;
      EXPECT_EQ(i, 10);
    }
    EXPECT_EQ(one.sample, i);
  }
  EXPECT_EQ(begins, 1);
  EXPECT_EQ(nodes.samples(), 64);
}

TEST(RplidarNodes, DenseCapsulesAreDecoded) {
  RplidarNodes nodes(RplidarAnswer::kDenseCapsules);
  (void)nodes.add(capsule(10.0, dense_body(30000), true));
  const auto all = nodes.add(capsule(30.0, dense_body(200)));
  ASSERT_EQ(all.size(), 40U);
  EXPECT_DOUBLE_EQ(all[39].range_m, 30.039);
  EXPECT_NEAR(all[39].angle_rad, (10.0 + 39 * 0.5) * kDegree, 1e-9);
}

TEST(RplidarNodes, ADamagedCapsuleIsAGap) {
  const auto text = [](int i) { return capsule(20.0 * i, dense_body(1000 * i + 500), i == 0); };
  for (std::size_t at = 0; at < 84; ++at) {
    RplidarNodes nodes(RplidarAnswer::kDenseCapsules);
    std::string damaged = text(2);
    damaged[at] = static_cast<char>(damaged[at] ^ 0x10);
    std::string all = text(0) + text(1) + damaged;
    for (int i = 3; i < 6; ++i) all += text(i);
    const auto got = nodes.add(all);
    EXPECT_EQ(nodes.gaps(), 1) << at;
    ASSERT_EQ(got.size(), 3U * 40U) << at;  // 0, 3 and 4
    EXPECT_TRUE(got[40].after_gap);
    EXPECT_DOUBLE_EQ(got[40].range_m, 3.5);
  }
}

TEST(RplidarNodes, ACapsuleThatNeverCameIsSeenByItsAngle) {
  RplidarNodes nodes(RplidarAnswer::kDenseCapsules);
  std::size_t count = 0;
  for (const int i : {0, 1, 2, 4, 5, 6})
    count += nodes.add(capsule(20.0 * i, dense_body(1000), i == 0)).size();
  EXPECT_EQ(nodes.gaps(), 1);
  EXPECT_EQ(count, 4U * 40U);
}

TEST(RplidarNodes, AGapBeginsNoTurn) {
  RplidarNodes nodes(RplidarAnswer::kDenseCapsules);
  int begins = 0;
  // From 280 deg on nothing comes until 100 deg of the next turn.
  for (const double start_deg : {200.0, 220.0, 240.0, 260.0, 100.0, 120.0, 140.0}) {
    for (const RplidarNode& one : nodes.add(capsule(start_deg, dense_body(1000))))
      begins += one.begins_turn ? 1 : 0;
  }
  EXPECT_EQ(begins, 0);
  EXPECT_EQ(nodes.gaps(), 1);
}

}  // namespace
}  // namespace loopstone
