#include "formats/rawlog_objects.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "loopstone/base/error.hpp"

namespace loopstone {
namespace {

constexpr unsigned char kEndOfObject = 0x88;
constexpr unsigned char kNewFormat = 0x80;
constexpr std::size_t kLongestName = 100;
constexpr std::size_t kMostContainers = 8;
constexpr std::size_t kLongestLabel = 4096;
/// More than any object that is understood takes.
constexpr std::size_t kMostObjectBytes = std::size_t{1} << 20;
constexpr std::size_t kBlockBytes = std::size_t{1} << 16;
/// No robot is farther from where it began, as in other logs.
constexpr double kFarthestPoseM = 1e7;

/// What stands at the top of a rawlog, or in its frames and collections.
constexpr std::array<std::string_view, 3> kBeginnings{"CObservation", "CAction", "CSensoryFrame"};

std::string_view without_namespaces(std::string_view name) {
  const std::size_t colon = name.rfind(':');
  return colon == name.npos ? name : name.substr(colon + 1);
}

bool is_of_a_name(char c) {
  return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_' ||
         c == ':';
}

bool is_known_name(std::string_view name) {
  const std::string_view plain = without_namespaces(name);
  return std::any_of(kBeginnings.begin(), kBeginnings.end(),
                     [&](std::string_view known) { return plain.starts_with(known); });
}

/// Of a name that may be cut: whether its beginning fits.
bool may_become_known(std::string_view name) {
  constexpr std::string_view kNamespace = "mrpt::";
  if (name.substr(0, kNamespace.size()) == kNamespace.substr(0, name.size())) return true;
  return std::any_of(kBeginnings.begin(), kBeginnings.end(), [&](std::string_view known) {
    const std::size_t common = std::min(known.size(), name.size());
    return known.substr(0, common) == name.substr(0, common);
  });
}

/// Whether the first letter of a name that is known stands where it should.
bool may_begin(std::string_view five_bytes) {
  const bool is_new = (static_cast<unsigned char>(five_bytes[0]) & kNewFormat) != 0;
  const char letter = five_bytes[is_new ? 1 : 4];
  return letter == 'C' || letter == 'm';
}

/// MRPT counts 100 ns from 1601 on.
std::optional<Stamp> stamp_of_ticks(std::uint64_t ticks) {
  constexpr std::int64_t kTicksTo1970 = 116'444'736'000'000'000;
  constexpr std::int64_t kMostTicks = 46'000'000'000'000'000;  // 145 years, so that ns fit
  if (ticks == 0 || ticks > static_cast<std::uint64_t>(kTicksTo1970 + kMostTicks)) return {};
  const std::int64_t since_1970 = static_cast<std::int64_t>(ticks) - kTicksTo1970;
  if (since_1970 < -kMostTicks) return {};
  return Stamp{since_1970 * 100};
}

}  // namespace

/// The beginning of an object.
struct RawlogObjects::Head {
  std::string name{};  ///< without namespaces
  std::uint32_t version = 0;
  std::size_t bytes = 0;
  bool has_end = true;
};

namespace {

/// The head of an object, of any class; nothing when there is none.
template <typename Head>
std::optional<Head> head_in(std::string_view bytes) {
  if (bytes.empty()) return std::nullopt;
  const auto first = static_cast<unsigned char>(bytes[0]);
  const bool is_new = (first & kNewFormat) != 0;
  const std::size_t length = first & 0x7F;
  const std::size_t before = is_new ? 1 : 4;
  const std::size_t after = is_new ? 1 : 4;
  if (length == 0 || length > kLongestName || bytes.size() < before + length + after) return {};
  if (!is_new && bytes.substr(1, 3) != std::string_view("\0\0\0", 3)) return {};
  const std::string_view name = bytes.substr(before, length);
  if (!std::all_of(name.begin(), name.end(), is_of_a_name)) return {};
  Head head;
  head.name = std::string(without_namespaces(name));
  head.version = static_cast<unsigned char>(bytes[before + length]);
  head.bytes = before + length + after;
  head.has_end = is_new;
  if (head.version > 50) return {};
  return head;
}

}  // namespace

/// Takes numbers from bytes, and remembers that there were too few or that one can't be.
class RawlogObjects::Fields {
 public:
  explicit Fields(std::string_view bytes) : bytes_(bytes) {}

  template <typename Number>
  Number number() {
    Number value{};
    if (!take(sizeof value)) return value;
    std::memcpy(&value, bytes_.data() + done_ - sizeof value, sizeof value);
    return value;
  }
  bool flag() { return number<std::uint8_t>() != 0; }
  void skip(std::size_t bytes) { (void)take(bytes); }

  std::string text() {
    const auto length = number<std::uint32_t>();
    if (length > kLongestLabel) fail("a name of " + std::to_string(length) + " letters");
    if (!ok() || !take(length)) return {};
    return std::string(bytes_.substr(done_ - length, length));
  }
  std::optional<Stamp> stamp() { return stamp_of_ticks(number<std::uint64_t>()); }

  std::vector<float> ranges(std::uint32_t beams) {
    if (!ok() || !take(std::size_t{beams} * sizeof(float))) return {};
    std::vector<float> values(beams);
    const std::size_t size = values.size() * sizeof(float);
    if (size > 0) std::memcpy(values.data(), bytes_.data() + done_ - size, size);
    return values;
  }

  Pose2 pose2() {
    const auto head = begin("CPose2D");
    std::array<double, 3> values{};
    for (double& value : values) {
      value = head.version == 0 ? static_cast<double>(number<float>()) : number<double>();
    }
    if (head.version > 1) fail("a CPose2D of version " + std::to_string(head.version));
    end(head);
    for (const double value : values) {
      if (!(std::abs(value) <= kFarthestPoseM)) fail("a pose that can't be");
    }
    return ok() ? Pose2{values[0], values[1], wrap_angle(values[2])} : Pose2{};
  }

  RawlogPose3 pose3() {
    const auto head = begin("CPose3D");
    RawlogPose3 pose;
    if (head.version < 2) {
      pose = pose_of(matrix());
    } else if (head.version == 2) {
      for (double& value : pose.position_m) value = number<double>();
      std::array<double, 4> quaternion{};
      for (double& value : quaternion) value = number<double>();
      pose.rotation = rotation_of(quaternion);
    } else if (head.version == 3) {
      for (double& value : pose.position_m) value = number<double>();
      for (double& value : pose.rotation) value = number<double>();
    } else {
      fail("a CPose3D of version " + std::to_string(head.version));
    }
    end(head);
    for (const double value : pose.position_m) {
      if (!(std::abs(value) <= kFarthestPoseM)) fail("a place of a sensor that can't be");
    }
    for (const double value : pose.rotation) {
      if (!(std::abs(value) <= 1.001)) fail("a rotation that is none");
    }
    return pose;
  }

  /// A matrix object; for what it stands before in old versions.
  std::vector<double> matrix() {
    const auto head = begin("CMatrix");
    const bool doubles = head.name == "CMatrixD" || head.name == "CMatrixDouble";
    const auto rows = number<std::uint32_t>();
    const auto columns = number<std::uint32_t>();
    constexpr std::uint32_t kMost = 16;
    if (rows > kMost || columns > kMost) fail("a matrix of more than 16 rows or columns");
    std::vector<double> values;
    for (std::uint32_t i = 0; ok() && i < rows * columns; ++i) {
      values.push_back(doubles ? number<double>() : static_cast<double>(number<float>()));
    }
    end(head);
    return values;
  }

  /// The mean of the one kind of distribution that recorders wrote.
  Pose2 mean_of_gaussian() {
    const auto head = begin("CPosePDFGaussian");
    const Pose2 mean = pose2();
    if (head.version == 0) (void)matrix();
    if (head.version == 1) skip(6 * sizeof(float));
    if (head.version == 2) skip(6 * sizeof(double));
    if (head.version > 2) fail("a CPosePDFGaussian of version " + std::to_string(head.version));
    end(head);
    return mean;
  }

  void end(const Head& head) {
    if (ok() && head.has_end && number<std::uint8_t>() != kEndOfObject) {
      fail("the end of the " + head.name + " is not where it should be");
    }
  }
  void fail(const std::string& reason) {
    if (reason_.empty()) reason_ = reason;
  }
  [[nodiscard]] bool ok() const { return reason_.empty(); }
  [[nodiscard]] const std::string& reason() const { return reason_; }
  [[nodiscard]] std::size_t done() const { return done_; }

 private:
  bool take(std::size_t bytes) {
    if (bytes > bytes_.size() - done_) fail("the file ends within an object");
    if (!ok()) return false;
    done_ += bytes;
    return true;
  }
  Head begin(std::string_view name) {
    const auto head = head_in<Head>(bytes_.substr(done_));
    if (!head || !head->name.starts_with(name)) {
      fail("there is no " + std::string(name) + " where one should be");
      return {};
    }
    done_ += head->bytes;
    return *head;
  }
  /// The upper three rows of four columns.
  RawlogPose3 pose_of(const std::vector<double>& matrix) {
    RawlogPose3 pose;
    if (matrix.size() != 16) {
      fail("a place of a sensor that is no 4 x 4 matrix");
      return pose;
    }
    for (std::size_t row = 0; row < 3; ++row) {
      for (std::size_t column = 0; column < 3; ++column) {
        pose.rotation[3 * row + column] = matrix[4 * row + column];
      }
      pose.position_m[row] = matrix[4 * row + 3];
    }
    return pose;
  }
  /// \param q  w, x, y, z
  std::array<double, 9> rotation_of(const std::array<double, 4>& q) {
    const double norm = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    if (ok() && !(std::abs(norm - 1.0) < 0.01)) fail("a quaternion that is no rotation");
    const double w = q[0] / norm;
    const double x = q[1] / norm;
    const double y = q[2] / norm;
    const double z = q[3] / norm;
    return {1 - 2 * (y * y + z * z), 2 * (x * y - w * z),     2 * (x * z + w * y),
            2 * (x * y + w * z),     1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
            2 * (x * z - w * y),     2 * (y * z + w * x),     1 - 2 * (x * x + y * y)};
  }

  std::string_view bytes_;
  std::size_t done_ = 0;
  std::string reason_{};
};

namespace {

template <typename Fields>
RawlogScan scan_of(Fields& fields, std::uint32_t version) {
  RawlogScan scan;
  scan.aperture_rad = static_cast<double>(fields.template number<float>());
  scan.right_to_left = fields.flag();
  scan.max_range_m = static_cast<double>(fields.template number<float>());
  scan.robot_T_lidar = fields.pose3();
  if (version < 6) (void)fields.matrix();  // the covariance of that
  const auto beams = fields.template number<std::uint32_t>();
  if (beams > RawlogObjects::kMostBeams) fields.fail(std::to_string(beams) + " beams");
  scan.ranges_m = fields.ranges(beams);
  if (!fields.ok()) return scan;
  scan.valid.resize(beams);
  for (std::size_t i = 0; i < beams; ++i) {
    scan.valid[i] =
        version >= 1 ? fields.flag() : static_cast<double>(scan.ranges_m[i]) < scan.max_range_m;
  }
  if (version >= 2) fields.skip(sizeof(float));  // the error of a range
  if (version >= 3) scan.stamp = fields.stamp();
  if (version >= 4) fields.skip(sizeof(float));  // the width of a beam
  if (version >= 5) {
    scan.label = fields.text();
    scan.pitch_change_rad = fields.template number<double>();
  }
  if (version >= 7 && fields.flag()) fields.skip(std::size_t{beams} * sizeof(std::int32_t));
  const bool can_be = scan.aperture_rad > 0.0 && scan.aperture_rad < 6.3 && scan.max_range_m > 0.0;
  if (fields.ok() && !can_be) fields.fail("a scan whose angles or range can't be");
  if (fields.ok() && beams == 0) fields.fail("the scan has no beams");
  return scan;
}

template <typename Fields>
RawlogOdometry odometry_of(Fields& fields, std::uint32_t version) {
  RawlogOdometry odometry;
  odometry.odom_T_robot = fields.pose2();
  odometry.label = fields.text();
  odometry.stamp = fields.stamp();
  if (version == 0) return odometry;
  if (fields.flag() || version < 2) fields.skip(2 * sizeof(std::int32_t));
  if (fields.flag() || version < 2) {
    fields.skip(version < 2 ? 2 * sizeof(float) : 3 * sizeof(double));
  }
  return odometry;
}

/// The noise of the motion as the recorder configured it.
template <typename Fields>
void skip_motion_model(Fields& fields, std::uint32_t version) {
  constexpr std::size_t kInteger = sizeof(std::int32_t);
  constexpr std::size_t kFloat = sizeof(float);
  if (version == 2) {
    fields.skip(44);
  } else if (version == 3) {
    fields.skip(kInteger + 5 * kFloat + kInteger + 4 * kFloat);
  } else {
    fields.skip(kInteger + 6 * kFloat + kInteger + (version >= 5 ? 6 : 4) * kFloat);
  }
}

template <typename Fields>
RawlogMotion motion_of(Fields& fields, std::uint32_t version) {
  RawlogMotion motion;
  if (version < 2) {
    motion.increment = fields.mean_of_gaussian();
    motion.is_odometry = fields.template number<std::int32_t>() == 0;
  } else {
    motion.is_odometry = fields.template number<std::int32_t>() == 0;
    motion.increment = motion.is_odometry ? fields.pose2() : fields.mean_of_gaussian();
    if (motion.is_odometry) skip_motion_model(fields, version);
  }
  if (version == 0) return motion;
  const bool has_velocities = fields.flag();
  if (version < 7) fields.skip(2 * sizeof(float));
  if (version >= 7 && has_velocities) fields.skip(3 * sizeof(double));
  const bool has_encoders = fields.flag();
  if (version < 7 || has_encoders) fields.skip(2 * sizeof(std::int32_t));
  if (version >= 6) motion.stamp = fields.stamp();
  return motion;
}

}  // namespace

bool begins_as_rawlog(std::string_view head) {
  if (head.empty()) return false;
  const auto first = static_cast<unsigned char>(head[0]);
  const bool is_new = (first & kNewFormat) != 0;
  const std::size_t length = first & 0x7F;
  if (length < 7 || length > kLongestName) return false;
  const std::size_t before = is_new ? 1 : 4;
  if (head.size() <= before + 6) return false;
  if (!is_new && head.substr(1, 3) != std::string_view("\0\0\0", 3)) return false;
  const std::string_view name = head.substr(before, length);
  return std::all_of(name.begin(), name.end(), is_of_a_name) && may_become_known(name);
}

RawlogObjects::RawlogObjects(std::unique_ptr<ByteSource> source)
    : source_(std::move(source)), buffer_(2 * kMostObjectBytes) {}

/// Brings so many bytes ahead, if the file has them.
bool RawlogObjects::fill(std::size_t bytes) {
  if (held() >= bytes) return true;
  if (begin_ + bytes > buffer_.size()) {
    std::memmove(buffer_.data(), buffer_.data() + begin_, held());
    end_ -= begin_;
    begin_ = 0;
  }
  while (held() < bytes && !source_ended_) {
    const std::size_t room = std::min(buffer_.size() - end_, kBlockBytes);
    try {
      const std::size_t count = source_->read({buffer_.data() + end_, room});
      source_ended_ = count == 0;
      end_ += count;
    } catch (const DataError&) {
      failure_ = std::current_exception();
      source_ended_ = true;
    }
  }
  return held() >= bytes;
}

void RawlogObjects::pass(std::size_t bytes) {
  begin_ += bytes;
  offset_ += static_cast<std::int64_t>(bytes);
}

/// Passes the ends of frames and collections that are complete; false when one is not where it
/// should be.
bool RawlogObjects::at_end_of_containers() {
  while (!containers_.empty() && containers_.back().left == 0) {
    if (containers_.back().has_end) {
      if (!fill(1) || static_cast<unsigned char>(ahead()[0]) != kEndOfObject) return false;
      pass(1);
    }
    containers_.pop_back();
    if (!containers_.empty()) --containers_.back().left;
  }
  return true;
}

/// Goes to the next place where an object can begin.
bool RawlogObjects::find_next() {
  while (fill(1)) {
    (void)fill(kLongestName + 8);
    // Most bytes are told at a glance.
    const std::string_view bytes = ahead();
    std::size_t skipped = 0;
    while (skipped + 5 < bytes.size() && !may_begin(bytes.substr(skipped, 5))) ++skipped;
    if (skipped > 0) {
      pass(skipped);
      continue;
    }
    const auto head = head_in<Head>(bytes);
    if (head && is_known_name(head->name)) return true;
    pass(1);
  }
  return false;
}

RawlogObject RawlogObjects::read_object(const Head& head) {
  RawlogObject object{offset_, RawlogOther{head.name}};
  (void)fill(kMostObjectBytes);
  Fields fields(ahead().substr(head.bytes));
  bool is_scan = false;
  if (head.name == "CObservation2DRangeScan" && head.version <= 7) {
    object.content = scan_of(fields, head.version);
    is_scan = true;
  } else if (head.name == "CObservationOdometry" && head.version <= 2) {
    object.content = odometry_of(fields, head.version);
  } else if (head.name == "CActionRobotMovement2D" && head.version <= 7) {
    object.content = motion_of(fields, head.version);
  } else {
    is_lost_ = true;
    pass(head.bytes);
    return object;
  }
  fields.end(head);
  if (!fields.ok()) {
    object.content = RawlogBroken{head.name + ": " + fields.reason(), is_scan};
    is_lost_ = true;
    pass(head.bytes);
    return object;
  }
  pass(head.bytes + fields.done());
  return object;
}

std::optional<RawlogObject> RawlogObjects::ended() const {
  if (failure_) std::rethrow_exception(failure_);
  return std::nullopt;
}

std::optional<RawlogObject> RawlogObjects::next() {
  for (;;) {
    if (is_lost_) {
      containers_.clear();
      if (!find_next()) return ended();
      is_lost_ = false;
    }
    const bool containers_fit = at_end_of_containers();
    if (containers_fit && !fill(1)) return ended();
    (void)fill(kLongestName + 8);
    const auto head = containers_fit ? head_in<Head>(ahead()) : std::nullopt;
    if (!head) {
      is_lost_ = true;
      return RawlogObject{offset_, RawlogBroken{"no object begins where one should", false}};
    }
    const bool is_frame = head->name == "CSensoryFrame" && head->version <= 2;
    const bool is_collection = head->name == "CActionCollection" && head->version == 0;
    if (!is_frame && !is_collection) {
      const std::optional<Stamp> of_frame =
          containers_.empty() ? std::nullopt : containers_.back().stamp;
      RawlogObject object = read_object(*head);
      if (!containers_.empty()) --containers_.back().left;
      auto* const scan = std::get_if<RawlogScan>(&object.content);
      if (scan != nullptr && of_frame) scan->stamp = of_frame;
      return object;
    }
    (void)fill(head->bytes + 16);
    Fields fields(ahead().substr(head->bytes));
    Container container{0, head->has_end, {}};
    if (is_frame && head->version < 2) fields.skip(sizeof(std::uint32_t));  // an old number
    if (is_frame && head->version == 0) container.stamp = fields.stamp();
    container.left = fields.number<std::uint32_t>();
    if (!fields.ok() || containers_.size() >= kMostContainers) {
      is_lost_ = true;
      pass(head->bytes);
      return RawlogObject{offset_, RawlogBroken{head->name + " that is cut", false}};
    }
    pass(head->bytes + fields.done());
    containers_.push_back(container);
  }
}

}  // namespace loopstone
