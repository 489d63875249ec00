// PCL (https://pointclouds.org) on clouds: reads PCD and PLY into points of doubles, as ours does.
//   pcl_files make FOLDER POINTS    writes a cloud in every variant that it writes
// and what ../reader_trials.hpp tells.

#include <pcl/io/pcd_io.h>
#include <pcl/io/ply_io.h>
#include <pcl/point_types.h>

#include <Eigen/Core>

#include "../reader_trials.hpp"

namespace {

using namespace loopstone::bench;

[[noreturn]] void fail(const char* reason) { throw std::runtime_error(reason); }

template <typename Number>
void fill_axis(const pcl::PCLPointCloud2& blob, std::size_t offset, int axis,
               std::vector<Eigen::Vector3d>& points) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    Number value{};
    std::memcpy(&value, blob.data.data() + i * blob.point_step + offset, sizeof value);
    points[i](axis) = static_cast<double>(value);
  }
}

void fill_axis(const pcl::PCLPointCloud2& blob, const pcl::PCLPointField& field, int axis,
               std::vector<Eigen::Vector3d>& points) {
  switch (field.datatype) {
    case pcl::PCLPointField::FLOAT32:
      return fill_axis<float>(blob, field.offset, axis, points);
    case pcl::PCLPointField::FLOAT64:
      return fill_axis<double>(blob, field.offset, axis, points);
    case pcl::PCLPointField::INT8:
      return fill_axis<std::int8_t>(blob, field.offset, axis, points);
    case pcl::PCLPointField::UINT8:
      return fill_axis<std::uint8_t>(blob, field.offset, axis, points);
    case pcl::PCLPointField::INT16:
      return fill_axis<std::int16_t>(blob, field.offset, axis, points);
    case pcl::PCLPointField::UINT16:
      return fill_axis<std::uint16_t>(blob, field.offset, axis, points);
    case pcl::PCLPointField::INT32:
      return fill_axis<std::int32_t>(blob, field.offset, axis, points);
    case pcl::PCLPointField::UINT32:
      return fill_axis<std::uint32_t>(blob, field.offset, axis, points);
    default:
      fail("a coordinate is of no type that is known");
  }
}

std::vector<Eigen::Vector3d> points_of(const pcl::PCLPointCloud2& blob) {
  const std::size_t count = std::size_t{blob.width} * blob.height;
  require_value_bytes(count, sizeof(Eigen::Vector3d));
  if (blob.data.size() < count * blob.point_step) fail("there are fewer points than promised");
  std::vector<Eigen::Vector3d> points(count, Eigen::Vector3d::Zero());
  int axes = 0;
  for (const pcl::PCLPointField& field : blob.fields) {
    if (field.name.size() != 1 || field.name[0] < 'x' || field.name[0] > 'z') continue;
    fill_axis(blob, field, field.name[0] - 'x', points);
    axes |= 1 << (field.name[0] - 'x');
  }
  if ((axes & 3) != 3) fail("there is no x or no y");
  require_cloud(points);
  return points;
}

/// PCL 1.13 reads through a null pointer when a head names no fields (mended in 1.14), so it is
/// asked before.
void require_fields(const std::string& path) {
  pcl::PCLPointCloud2 head;
  if (pcl::PCDReader().readHeader(path, head) < 0 || head.fields.empty()) {
    fail("PCL can't read its head");
  }
}

template <typename Reader>
void read_cloud(const std::string& path, ValueDigest* digest) {
  if constexpr (std::is_same_v<Reader, pcl::PCDReader>) require_fields(path);
  Reader reader;
  pcl::PCLPointCloud2 blob;
  Eigen::Vector4f origin;
  Eigen::Quaternionf orientation;
  int version = 0;
  if (reader.read(path, blob, origin, orientation, version, 0) < 0) fail("PCL can't read it");
  digest_cloud(points_of(blob), digest);
}

pcl::PointCloud<pcl::PointXYZ> walls(std::size_t count) {
  pcl::PointCloud<pcl::PointXYZ> cloud;
  std::uint32_t state = 1;
  for (std::size_t i = 0; i < count; ++i) {
    state = state * 1664525U + 1013904223U;
    const float along = 0.001F * static_cast<float>(i % 20000);
    const float noise = 1e-9F * static_cast<float>(state);
    const float up = 0.01F * static_cast<float>(i / 20000);
    i % 2 == 0 ? cloud.push_back({along, noise, up}) : cloud.push_back({noise, along, up});
  }
  return cloud;
}

}  // namespace

int main(int argc, char** argv) {
  pcl::console::setVerbosityLevel(pcl::console::L_ALWAYS);
  if (argc == 4 && std::string_view(argv[1]) == "make") {
    const auto cloud = walls(std::stoul(argv[3]));
    const std::string folder = std::string(argv[2]) + "/";
    pcl::io::savePCDFileASCII(folder + "text.pcd", cloud);
    pcl::io::savePCDFileBinary(folder + "binary.pcd", cloud);
    pcl::io::savePCDFileBinaryCompressed(folder + "compressed.pcd", cloud);
    pcl::io::savePLYFileASCII(folder + "text.ply", cloud);
    pcl::io::savePLYFileBinary(folder + "binary.ply", cloud);
    return 0;
  }
  return reader_main(argc, argv,
                     {{".pcd", read_cloud<pcl::PCDReader>}, {".ply", read_cloud<pcl::PLYReader>}});
}
