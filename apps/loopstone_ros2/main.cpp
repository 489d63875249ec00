#include <CLI/CLI.hpp>
#include <cstdlib>
#include <memory>
#include <string>

#include "app.hpp"
#include "dds_node.hpp"
#include "live_arguments.hpp"
#include "live_flags.hpp"
#include "loopstone/version.hpp"
#include "program.hpp"
#include "ros2_outlets.hpp"
#include "ros2_source.hpp"

namespace loopstone::app {

namespace {

constexpr const char* kName = "loopstone-ros2";
constexpr const char* kFooter = R"(
Reads /scan, /odom, /tf and /tf_static; other names by --topic, such as --topic laser=/front/scan, and with
--topic imu=/imu/data a gyro. Tells /map, /tf (map to odom), /pose and /diagnostics; with --map it listens to
/initialpose. Ctrl-C ends the drive: the map is finished and written.

Examples:
  loopstone-ros2 -o out                        a map of what the robot's laser tells
  loopstone-ros2 --continue out -o out2        the same map, on another day
  loopstone-ros2 --map out                     where is the robot?
  loopstone-ros2 --domain 7 --interface wlan0 -o out

Exit codes: 0 done, 1 bad data, 2 bad usage or options, 130 interrupted before anything came.
docs/ros2.md tells what to do when nothing comes.)";

struct Ros2Arguments {
  LiveArguments live{};
  DdsOptions dds{};
  RobotFrames frames{};
};

std::string list_of(const SensorTopics& topics) {
  std::string list;
  for (const auto* names : {&topics.scans, &topics.odometry, &topics.imu}) {
    for (const std::string& name : *names) list += name + ", ";
  }
  return list + "/tf and /tf_static";
}

void add_flags(CLI::App& app, Ros2Arguments& arguments, AppContext& context) {
  constexpr int kMostDomain = 232;
  add_live_map_flags(app, arguments.live);
  app.add_option("--domain", arguments.dds.domain,
                 "ROS_DOMAIN_ID of the robot (default: that of the environment, else 0)")
      ->type_name("N")
      ->envname("ROS_DOMAIN_ID")
      ->check(CLI::Range(0, kMostDomain));
  app.add_option("--interface", arguments.dds.interface,
                 "of the network, such as eth0 (default: Cyclone chooses, or CYCLONEDDS_URI says)")
      ->type_name("NAME");
  app.add_option("--odom-frame", arguments.frames.odom, "of the robot's odometry")
      ->type_name("FRAME")
      ->capture_default_str();
  add_live_flags(app, arguments.live, context);
}

ExitCode run(Ros2Arguments& arguments, const AppContext& context) {
  const std::string& base = arguments.live.reading.base_frame;
  if (!base.empty()) arguments.frames.base = base;
  const SensorTopics topics = sensor_topics(topic_options(arguments.live.reading));
  const DdsNode node(arguments.dds, [&context](const std::string& text) { context.warn(text); });
  Ros2Outlets outlets(node, arguments.frames);
  const std::string name =
      "ROS 2, domain " + std::to_string(arguments.dds.domain) + ": " + list_of(topics);
  arguments.live.given = {ros2_source(node, name, topics)};
  arguments.live.listener = &outlets;
  return run_live(arguments.live, context);
}

int run_loopstone_ros2(int argc, char** argv) {
  begin_program(kName);
  CLI::App app{"Maps what a robot with ROS 2 tells over the network, or tells it where it is.",
               kName};
  AppContext context;
  context.set_command_line(kName, argc, argv);
  app.set_version_flag("--version", std::string(kName) + " " + std::string(kVersion));
  Ros2Arguments arguments;
  add_flags(app, arguments, context);
  app.footer(kFooter);
  return run_program(app, [&] {
    app.parse(argc, argv);
    return run(arguments, context);
  });
}

}  // namespace

}  // namespace loopstone::app

int main(int argc, char** argv) { return loopstone::app::run_loopstone_ros2(argc, argv); }
