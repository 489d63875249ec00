#include "loopstone/formats/ros_map.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <string>

#include "loopstone/base/error.hpp"
#include "loopstone/base/rng.hpp"
#include "support/temp_dir.hpp"

namespace loopstone {
namespace {

using test::TempDir;

const char* const kYaml =
    "image: m.pgm\nresolution: 0.1\norigin: [-1.5, 2.25, 0]\nnegate: 0\noccupied_thresh: "
    "0.65\nfree_thresh: 0.196\n";

std::string error_of(std::string_view text) {
  try {
    (void)parse_map_yaml(text, "m.yaml");
  } catch (const DataError& error) {
    return error.what();
  }
  return "no error";
}

OccupancyMap random_map() {
  Rng rng(1);
  const GridFrame frame{
      .origin = {-1.2345678901234567, 7.05}, .resolution = 0.05, .columns = 23, .rows = 11};
  OccupancyMap map{Grid<float>(frame), Grid<std::uint8_t>(frame)};
  for (std::size_t i = 0; i < map.log_odds.cells().size(); ++i) {
    if (rng.below(3) == 0) continue;
    map.observed.cells()[i] = 1;
    map.log_odds.cells()[i] = static_cast<float>(rng.uniform(-3.5, 3.5));
  }
  return map;
}

TEST(RosMap, BytesAreThoseThatNav2Reads) {
  const TempDir dir;
  const OccupancyMap map = random_map();
  const CellStates states = cell_states(map);
  write_ros_map(dir / "map.yaml", states);
  EXPECT_EQ(dir.names(), (std::vector<std::string>{"map.pgm", "map.yaml"}));
  EXPECT_EQ(dir.read("map.yaml"),
            "image: map.pgm\nmode: trinary\nresolution: 0.05\norigin: [-1.2345678901234567, 7.05, "
            "0]\nnegate: 0\n"
            "occupied_thresh: 0.65\nfree_thresh: 0.196\n");
  const std::string pgm = dir.read("map.pgm");
  const std::string header = "P5\n23 11\n255\n";
  ASSERT_EQ(pgm.substr(0, header.size()), header);
  ASSERT_EQ(pgm.size(), header.size() + 23 * 11);
  // nav2's rule, written out: p = (255 - g) / 255; occupied if p >= 0.65, free if p <= 0.196; top
  // row first.
  for (int row = 0; row < 11; ++row) {
    for (int column = 0; column < 23; ++column) {
      const auto grey = static_cast<unsigned char>(
          pgm[header.size() + static_cast<std::size_t>((10 - row) * 23 + column)]);
      EXPECT_TRUE(grey == 0 || grey == 205 || grey == 254);
      const double p = (255 - grey) / 255.0;
      const int nav2 = p >= 0.65 ? 100 : p <= 0.196 ? 0 : -1;
      const Cell cell{column, row};
      ASSERT_EQ(nav2, states[cell]);
      const int meant = map.observed[cell] == 0         ? -1
                        : map.probability(cell) >= 0.65 ? 100
                        : map.probability(cell) < 0.5   ? 0
                                                        : -1;
      ASSERT_EQ(nav2, meant);
    }
  }
  const CellStates back = read_ros_map(dir / "map.yaml");
  EXPECT_EQ(back.frame(), states.frame());
  EXPECT_EQ(back.cells(), states.cells());
}

TEST(RosMap, SingleScanAlreadyShowsFreeAndOccupied) {
  LaserScan scan;
  scan.range_max_m = 10.0;
  scan.ranges_m = {2.02F};
  const PosedScan posed{&scan, {}, {}, {}};
  const OccupancyMap map = build_occupancy_map(std::span(&posed, 1), 0.0);
  const CellStates states = cell_states(map);
  EXPECT_EQ(states[states.frame().cell_of({2.02, 0.001})], kOccupiedCell);
  EXPECT_EQ(states[states.frame().cell_of({1.0, 0.001})], kFreeCell);
}

Image grey_row(std::vector<std::uint8_t> values) {
  Image image = make_image(static_cast<int>(values.size()), 1, 1);
  image.bytes = std::move(values);
  return image;
}

TEST(RosMap, ModesThresholdsAndNegate) {
  using States = std::vector<std::int8_t>;
  RosMapInfo info;
  const Image image = grey_row({0, 89, 90, 127, 204, 205, 206, 254, 255});
  EXPECT_EQ(interpret_map(image, info).cells(), (States{100, 100, -1, -1, -1, -1, 0, 0, 0}));
  info.free_threshold = 0.25;  // as many files have it: unknown grey turns free
  EXPECT_EQ(interpret_map(image, info).cells(), (States{100, 100, -1, -1, 0, 0, 0, 0, 0}));
  info.negate = true;
  EXPECT_EQ(interpret_map(image, info).cells(), (States{0, -1, -1, -1, 100, 100, 100, 100, 100}));
  info = {};
  info.mode = MapMode::kScale;
  info.free_threshold = 0.2;
  info.occupied_threshold = 0.8;
  EXPECT_EQ(interpret_map(grey_row({51, 102, 153, 204}), info).cells(), (States{100, 67, 33, 0}));
  info.mode = MapMode::kRaw;
  EXPECT_EQ(interpret_map(grey_row({0, 37, 100, 101, 255}), info).cells(),
            (States{0, 37, 100, -1, -1}));
}

TEST(RosMap, TransparentIsUnknownAndColoursAreAveraged) {
  Image image = make_image(3, 1, 4);
  image.bytes = {255, 255, 255, 254, 0, 0, 0, 255, 255, 255, 150, 255};
  EXPECT_EQ(interpret_map(image, {}).cells(), (std::vector<std::int8_t>{-1, 100, 0}));
}

TEST(RosMap, SixteenBitsAndPlainPgmAndPng) {
  const TempDir dir;
  dir.write("m.yaml", kYaml);
  const std::vector<std::int8_t> expected{100, 0, -1, 0};  // bottom row first
  dir.write("m.pgm", "P2\n# tool\n2 2\n1000\n803 1000\n0 999\n");
  EXPECT_EQ(read_ros_map(dir / "m.yaml").cells(), expected);
  EXPECT_EQ(read_ros_map(dir / "m.yaml").frame(),
            (GridFrame{.origin = {-1.5, 2.25}, .resolution = 0.1, .columns = 2, .rows = 2}));
  Image png = make_image(2, 2, 1);
  png.bytes = {205, 254, 0, 254};
  write_png(dir / "m.pgm", png);  // content decides, not the name
  EXPECT_EQ(read_ros_map(dir / "m.yaml").cells(), expected);
}

TEST(RosMap, RotatedOriginIsDrawnAlongTheAxes) {
  // A wall along the picture's bottom row; turned by 90 degrees about its lower left corner it runs
  // along y.
  Image image = make_image(10, 4, 1);
  std::fill(image.bytes.begin(), image.bytes.end(), std::uint8_t{254});
  std::fill(image.bytes.end() - 10, image.bytes.end(), std::uint8_t{0});
  RosMapInfo info;
  info.resolution_m = 0.1;
  info.map_T_corner = {5.0, 3.0, kPi / 2};
  const CellStates cells = interpret_map(image, info);
  const auto at = [&](double x, double y) {
    return cells.value_or(cells.frame().cell_of({x, y}), 77);
  };
  for (double y = 3.05; y < 4.0; y += 0.1) {
    EXPECT_EQ(at(4.95, y), kOccupiedCell) << y;
    EXPECT_EQ(at(4.75, y), kFreeCell) << y;
  }
  // At any angle every cell of the result agrees with the pixel that lies there.
  info.map_T_corner = {1.0, -2.0, 0.4};
  const CellStates tilted = interpret_map(image, info);
  int occupied = 0;
  for (int row = 0; row < tilted.frame().rows; ++row) {
    for (int column = 0; column < tilted.frame().columns; ++column) {
      const Eigen::Vector2d p =
          info.map_T_corner.inverse() * tilted.frame().centre_of({column, row});
      const bool inside = p.x() >= 0 && p.y() >= 0 && p.x() < 1.0 && p.y() < 0.4;
      const int expected = !inside ? -1 : p.y() < 0.1 ? 100 : 0;
      EXPECT_EQ((tilted[{column, row}]), expected);
      occupied += expected == 100 ? 1 : 0;
    }
  }
  EXPECT_NEAR(occupied, 10, 3);
}

TEST(RosMap, YamlOfRos1AndRos2) {
  const RosMapInfo ros1 = parse_map_yaml(kYaml);
  EXPECT_EQ(ros1.mode, MapMode::kTrinary);
  EXPECT_EQ(ros1.image, "m.pgm");
  EXPECT_EQ(ros1.map_T_corner, (Pose2{-1.5, 2.25, 0.0}));
  EXPECT_TRUE(parse_map_yaml(std::string(kYaml) + "mode: raw\n").mode == MapMode::kRaw);
  std::string ros2 = kYaml;
  ros2.replace(ros2.find("negate: 0"), 9, "negate: true");
  EXPECT_TRUE(parse_map_yaml(ros2).negate);
}

TEST(RosMap, YamlDamageIsNamedWithItsLine) {
  const auto with = [](const std::string& old_text, const std::string& new_text) {
    std::string yaml = kYaml;
    yaml.replace(yaml.find(old_text), old_text.size(), new_text);
    return error_of(yaml);
  };
  const auto has = [](const std::string& error, const char* part) {
    EXPECT_NE(error.find(part), std::string::npos) << error;
  };
  has(error_of(""), "no map's YAML file");
  has(error_of("[1, 2"), "no valid YAML");
  has(error_of("just words"), "no map's YAML file");
  has(error_of(std::string(5000, '[')), "too deeply nested");
  has(with("image: m.pgm\n", ""), "has no key 'image'");
  has(with("resolution: 0.1", "resolution: 0"), "m.yaml:2: 'resolution'");
  has(with("resolution: 0.1", "resolution: .nan"), "finite");
  has(with("resolution: 0.1", "resolution: 1e-300"), "m.yaml:2: 'resolution' must be from 0.0001");
  has(with("resolution: 0.1", "resolution: 1e300"), "m.yaml:2: 'resolution' must be from 0.0001");
  has(with("[-1.5, 2.25, 0]", "[1e12, 0, 0.3]"), "m.yaml:3: 'origin' must lie within 1e+07 m");
  has(with("[-1.5, 2.25, 0]", "[0, .inf, 0.3]"), "m.yaml:3: 'origin'");
  std::string nested = "image: ";
  for (int i = 0; i < 20'000; ++i) nested += "- ";
  has(error_of(nested), "no valid YAML");
  has(with("resolution: 0.1", "resolution: fine"),
      "m.yaml:2: 'resolution' must be a finite number");
  has(with("[-1.5, 2.25, 0]", "[-1.5, 2.25]"), "m.yaml:3: 'origin' must be [x, y, yaw]");
  has(with("[-1.5, 2.25, 0]", "[-1.5, 2.25, x]"), "'origin'");
  has(with("0.65", "1.5"), "'occupied_thresh' must lie in [0, 1]");
  has(with("0.65", "0.1"), "must be less than");
  has(with("negate: 0", "mode: fancy\nnegate: 0"), "trinary, scale or raw");
}

TEST(RosMap, UnwritableFolderLeavesNothing) {
  const TempDir dir;
  EXPECT_THROW(write_ros_map(dir / "none/map.yaml", cell_states(random_map())), DataError);
  std::filesystem::create_directory(dir.path() / "map.yaml");  // the second file cannot be made
  EXPECT_THROW(write_ros_map(dir / "map.yaml", cell_states(random_map())), DataError);
  EXPECT_EQ(dir.names(), std::vector<std::string>{"map.yaml"});
  dir.write("a.yaml", kYaml);
  EXPECT_THROW((void)read_ros_map(dir / "a.yaml"), DataError) << "its picture is missing";
}

}  // namespace
}  // namespace loopstone
