#include <array>

#include "formats/carmen_line.hpp"
#include "formats/carmen_reader.hpp"
#include "formats/carmen_writer.hpp"
#include "formats/rawlog_objects.hpp"
#include "formats/rawlog_reader.hpp"
#include "formats/recording_formats.hpp"
#include "formats/ucsd_format.hpp"
#include "loopstone/formats/log_format.hpp"

namespace loopstone {
namespace {

using std::string_view;

constexpr std::array<string_view, 3> kCarmenEndings{".clf", ".log", ".carmen"};
constexpr std::array<string_view, 2> kPackings{".gz", ".bz2"};
constexpr std::array<string_view, 1> kUcsdEndings{".npz"};
constexpr std::array<string_view, 1> kMcapEndings{".mcap"};
constexpr std::array<string_view, 1> kBagEndings{".bag"};
constexpr std::array<string_view, 1> kDatabaseEndings{".db3"};
constexpr std::array<string_view, 1> kDatabasePackings{".zstd"};
constexpr std::array<string_view, 1> kRawlogEndings{".rawlog"};

// Stamps as doubles: what is rounded on the way to seconds, and on the way back.
constexpr Duration kErrorOfDoubleStamps{500};

// All that a robot with ROS tells.
constexpr LogContents kTopics{.scans = true,
                              .odometry_poses = true,
                              .wheel_ticks = true,
                              .imu_samples = true,
                              .rgbd_frames = true,
                              .lidars = 16,
                              .beams_change = true,
                              .beam_times = true,
                              .intensities = true,
                              .lidar_mount = true,
                              .single_precision = true};

constexpr std::array<LogFormat, 6> kFormats{{
    {
        .name = "carmen",
        .title = "CARMEN",
        .noun = "CARMEN text",
        .file_is = "text",
        .place = LogPlace::kFile,
        .endings = kCarmenEndings,
        .packings = kPackings,
        .reads_streams = true,
        .holds = {.scans = true,
                  .odometry_poses = true,
                  .lidars = kCarmenLidars,
                  .beams_change = true,
                  .lidar_mount = true},
        // Text has no mark at its beginning. The reader looks for a line that it understands.
        .recognise =
            [](const LogInput& log) {
              return log.is_folder ? Recognition::kNo : Recognition::kPossible;
            },
        .open = [](const LogInput& log,
                   const LogOptions& options) { return open_carmen_log(*log.content, options); },
        .truth =
            [](const LogInput& log, const std::string& topic, const LogOptions& options) {
              return read_carmen_truth(*log.content, topic, options);
            },
        .create = [](const LogTarget& target,
                     const RobotModel& robot) { return create_carmen_log(target.path, robot); },
    },
    {
        .name = "ucsd",
        .title = "UCSD",
        .noun = "the UCSD layout",
        .file_is = "an archive",
        .place = LogPlace::kFolder,
        .endings = kUcsdEndings,
        .expected = "EncodersN.npz, HokuyoN.npz or ImuN.npz",
        .has_sets = true,
        .has_picture_files = true,
        .holds = {.scans = true,
                  .odometry_poses = true,
                  .wheel_ticks = true,
                  .imu_samples = true,
                  .rgbd_frames = true,
                  .beam_times = true,
                  .lidar_mount = true,
                  .stamp_error = kErrorOfDoubleStamps},
        .recognise = recognise_ucsd,
        .open = open_ucsd,
        .files = ucsd_log_files,
        .create = create_ucsd,
        .parts = ucsd_parts,
    },
    {
        .name = "mcap",
        .title = "MCAP",
        .noun = "MCAP",
        .file_is = "an MCAP file",
        .place = LogPlace::kFile,
        .endings = kMcapEndings,
        .reads_streams = true,
        .holds = kTopics,
        .recognise = recognise_mcap,
        .open = open_mcap_log,
        .truth = mcap_truth,
        .create = create_mcap_log,
    },
    {
        .name = "bag",
        .title = "ROS 1 bag",
        .noun = "a ROS 1 bag",
        .file_is = "a ROS 1 bag",
        .place = LogPlace::kFile,
        .endings = kBagEndings,
        .holds = kTopics,
        .recognise = recognise_bag,
        .open = open_bag_log,
        .truth = bag_truth,
        .create = create_bag_log,
    },
    {
        .name = "rosbag2",
        .title = "rosbag2",
        .noun = "a rosbag2 recording",
        .file_is = "a database of rosbag2",
        .place = LogPlace::kFolder,
        .endings = kDatabaseEndings,
        .packings = kDatabasePackings,
        .expected = "metadata.yaml with .db3 or .mcap files",
        .holds = kTopics,
        .recognise = recognise_rosbag2,
        .open = open_rosbag2_log,
        .truth = rosbag2_truth,
        .files = rosbag2_log_files,
        .create = create_rosbag2_log,
        .parts = rosbag2_parts,
    },
    {
        .name = "rawlog",
        .title = "MRPT",
        .noun = "MRPT's rawlog",
        .file_is = "a rawlog of MRPT",
        .place = LogPlace::kFile,
        .endings = kRawlogEndings,
        .reads_streams = true,
        .holds = {.scans = true,
                  .odometry_poses = true,
                  .lidars = kRawlogLidars,
                  .beams_change = true,
                  .lidar_mount = true},
        .recognise =
            [](const LogInput& log) {
              return begins_as_rawlog(log.head) ? Recognition::kCertain : Recognition::kNo;
            },
        .open = [](const LogInput& log,
                   const LogOptions& options) { return open_rawlog(*log.content, options); },
    },
}};

}  // namespace

std::span<const LogFormat> log_formats() { return kFormats; }

}  // namespace loopstone
