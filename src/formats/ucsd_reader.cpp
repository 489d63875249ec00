#include "formats/ucsd_reader.hpp"

#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "formats/skip_tally.hpp"
#include "formats/ucsd_files.hpp"
#include "formats/ucsd_sensors.hpp"

namespace loopstone {
namespace {

namespace fs = std::filesystem;

class UcsdReader final : public LogReader {
 public:
  UcsdReader(const UcsdFiles& files, LogOptions options)
      : options_(std::move(options)), has_plain_depth_(!holds_disparity(files)) {
    // Of equal stamps the earlier channel comes first: the motion is known before the scan that
    // needs it.
    open(files.odometry, open_ucsd_odometry);
    open(files.encoders, open_ucsd_encoders);
    open(files.imu, open_ucsd_imu);
    open(files.kinect,
         [&](const NpzFile& file, const std::string&) { return open_ucsd_kinect(file, files); });
    const auto open_lidar = [&](const NpzFile& file, const std::string& path) {
      UcsdChannel channel = open_ucsd_hokuyo(file, path);
      if (file.has("robot_T_lidar")) {
        const NpyArray mount = file.read("robot_T_lidar");
        mount_ = Pose2{mount.values[0], mount.values[1], wrap_angle(mount.values[2])};
      }
      return channel;
    };
    open(files.hokuyo, open_lidar, true);
    const std::string set = std::to_string(files.set);
    if (!files.hokuyo) notes_.push_back("no Hokuyo" + set + ".npz: no laser scans");
    if (!files.encoders && !files.odometry) {
      notes_.push_back("no Encoders" + set + ".npz: the wheels' motion is not known");
    }
    if (!files.hokuyo && !files.encoders && !files.odometry) {
      throw DataError({files.folder.string()}, "set " + set +
                                                   " has neither laser scans nor wheel counts: "
                                                   "nothing can be made of it");
    }
  }

  std::optional<SensorMessage> next() override {
    Channel* first = nullptr;
    for (Channel& channel : channels_) {
      if (channel.next == channel.sensor.kept.stamps.size()) continue;
      if (first == nullptr || channel.stamp() < first->stamp()) first = &channel;
    }
    if (first == nullptr) return std::nullopt;
    const Stamp stamp = first->stamp();
    const std::int64_t index = first->sensor.kept.indices[first->next];
    report_refused(*first, index);
    ++first->next;
    ++messages_done_;
    SensorMessage message = first->sensor.make(stamp, index);
    if (first->next == first->sensor.kept.stamps.size()) {
      report_refused(*first, std::numeric_limits<std::int64_t>::max());
    }
    return message;
  }

  ReadProgress progress() const override {
    if (messages_total_ == 0) return {bytes_total_, bytes_total_};
    const double ratio = static_cast<double>(messages_done_) / static_cast<double>(messages_total_);
    return {static_cast<std::int64_t>(ratio * static_cast<double>(bytes_total_)), bytes_total_};
  }
  std::string format() const override { return "ucsd"; }
  RobotModel robot(RobotModel base) const override {
    if (has_plain_depth_) base.camera.encoding.kind = DepthKind::kDepth;
    if (!mount_) return base;
    if (base.lidars.empty()) base.lidars.emplace_back();
    base.lidars[0].robot_T_lidar = *mount_;
    return base;
  }
  const SkippedRecords& skipped() const override { return tally_.skipped(); }
  std::vector<std::string> notes() const override { return notes_; }

 private:
  struct Channel {
    UcsdChannel sensor;
    bool is_lidar = false;
    std::size_t next = 0;
    std::size_t refused_reported = 0;

    [[nodiscard]] Stamp stamp() const { return sensor.kept.stamps[next]; }
  };

  template <typename Open>
  void open(const std::optional<fs::path>& file_path, Open&& open_sensor, bool is_lidar = false) {
    if (!file_path) return;
    const fs::path& path = *file_path;
    const std::string name = path.string();
    const NpzFile file(name, options_.memory, options_.stop);
    Channel channel{open_sensor(file, name), is_lidar};
    for (std::string& note : channel.sensor.notes) {
      notes_.push_back(path.filename().string() + ": " + note);
    }
    std::error_code ignored;
    bytes_total_ += static_cast<std::int64_t>(fs::file_size(path, ignored));
    messages_total_ += static_cast<std::int64_t>(channel.sensor.kept.stamps.size());
    if (channel.sensor.kept.stamps.empty()) {
      if (channel.sensor.make) {
        notes_.push_back(path.filename().string() + " holds no usable record");
      }
      report_refused(channel, std::numeric_limits<std::int64_t>::max());
    }
    channels_.push_back(std::move(channel));
  }

  /// Tells of the refused records that stand before record `index` in the file.
  void report_refused(Channel& channel, std::int64_t index) {
    const auto& refused = channel.sensor.kept.refused;
    for (auto& next = channel.refused_reported;
         next < refused.size() && refused[next].index < index; ++next) {
      const std::string& name = refused[next].name;
      const std::string reason =
          (name.empty() ? "record " + std::to_string(refused[next].index + 1) : name) + ": " +
          refused[next].reason;
      if (options_.strict) throw DataError({channel.sensor.path}, reason);
      const LogProblem problem{{{channel.sensor.path}, reason}, channel.is_lidar};
      tally_.add(problem);
      if (options_.on_problem) options_.on_problem(problem);
    }
  }

  LogOptions options_;
  bool has_plain_depth_ = false;
  std::vector<Channel> channels_;
  std::vector<std::string> notes_;
  std::optional<Pose2> mount_;
  std::int64_t bytes_total_ = 0;
  std::int64_t messages_total_ = 0;
  std::int64_t messages_done_ = 0;
  SkipTally tally_;
};

}  // namespace

std::unique_ptr<LogReader> open_ucsd_log(const fs::path& folder, std::optional<int> set,
                                         const LogOptions& options) {
  return std::make_unique<UcsdReader>(find_ucsd_files(folder, set), options);
}

}  // namespace loopstone
