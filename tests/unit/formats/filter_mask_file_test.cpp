#include "loopstone/formats/filter_mask_file.hpp"

#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include <vector>

#include "loopstone/formats/ros_map.hpp"

namespace loopstone {
namespace {

const GridFrame kFrame{.origin = {-3.0, 2.0}, .resolution = 0.25, .columns = 40, .rows = 24};

FilterMask half_speed() {
  const std::vector<SpeedZone> zones{
      {"", box_polygon({-2.0, 3.0}, {0.0, 4.0}), 0.5, SpeedUnit::kMetresPerSecond},
      {"", box_polygon({1.0, 3.0}, {2.0, 4.0}), 1.5, SpeedUnit::kMetresPerSecond}};
  return speed_mask(kFrame, zones);
}

TEST(FilterMaskFile, AMapServerReadsTheValuesBack) {
  const FilterMask mask = half_speed();
  const RosMapInfo info =
      parse_map_yaml(format_mask_yaml(mask.values.frame(), "speed_mask.pgm"), "mask.yaml");
  EXPECT_EQ(info.image, "speed_mask.pgm");
  const CellStates read = interpret_map(mask_image(mask), info);
  EXPECT_EQ(read.frame(), kFrame);
  EXPECT_EQ(read.cells(), mask.values.cells());
}

TEST(FilterMaskFile, TheParametersTellHowTheValuesAreMeant) {
  const FilterMask speed = half_speed();
  const FilterMask keep_out =
      keep_out_mask(kFrame, std::vector{KeepOutZone{"", box_polygon({0.0, 3.0}, {1.0, 4.0})}});
  const YAML::Node yaml = YAML::Load(format_nav2_filters(&keep_out, &speed));
  const YAML::Node info = yaml["speed_costmap_filter_info_server"]["ros__parameters"];
  EXPECT_EQ(info["type"].as<int>(), 2);
  EXPECT_EQ(info["multiplier"].as<double>(), speed.multiplier);
  // A parameter that is a double must be written as one.
  EXPECT_EQ(info["base"].Scalar(), "0.0");
  EXPECT_EQ(yaml["keepout_costmap_filter_info_server"]["ros__parameters"]["type"].as<int>(), 0);
  EXPECT_EQ(yaml["keepout_costmap_filter_info_server"]["ros__parameters"]["multiplier"].Scalar(),
            "1.0");
  const YAML::Node filters = yaml["global_costmap"]["global_costmap"]["ros__parameters"]["filters"];
  EXPECT_EQ(filters.as<std::vector<std::string>>(),
            (std::vector<std::string>{"keepout_filter", "speed_filter"}));
  // Topics of what shows a mask and of what says what it is are the same.
  EXPECT_EQ(info["mask_topic"].Scalar(),
            yaml["speed_filter_mask_server"]["ros__parameters"]["topic_name"].Scalar());
}

TEST(FilterMaskFile, WhatIsNotThereIsNotNamed) {
  const FilterMask speed = half_speed();
  const std::string text = format_nav2_filters(nullptr, &speed);
  EXPECT_EQ(text.find("keepout"), std::string::npos);
}

}  // namespace
}  // namespace loopstone
