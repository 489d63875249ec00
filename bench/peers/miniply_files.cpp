// miniply (https://github.com/vilya/miniply) on clouds: the vertices of a PLY file as doubles, as
// ours reads them, and what ../reader_trials.hpp tells.

#include <Eigen/Core>

#include "../reader_trials.hpp"
#include "miniply.h"

namespace {

using namespace loopstone::bench;

void read_ply(const std::string& path, ValueDigest* digest) {
  miniply::PLYReader reader(path.c_str());
  if (!reader.valid()) throw std::runtime_error("is no PLY file that miniply opens");
  while (reader.has_element() && !reader.element_is(miniply::kPLYVertexElement)) {
    reader.next_element();
  }
  if (!reader.has_element()) throw std::runtime_error("has no element vertex");
  require_value_bytes(reader.num_rows(), sizeof(Eigen::Vector3d));
  std::uint32_t axes[3];
  const bool has_z = reader.find_properties(axes, 3, "x", "y", "z");
  if (!has_z && !reader.find_properties(axes, 2, "x", "y")) {
    throw std::runtime_error("has no x or no y");
  }
  if (!reader.load_element()) throw std::runtime_error("its vertices can't be read");
  const std::uint32_t count = has_z ? 3 : 2;
  std::vector<double> values(std::size_t{count} * reader.num_rows());
  if (!reader.extract_properties(axes, count, miniply::PLYPropertyType::Double, values.data())) {
    throw std::runtime_error("its vertices are no numbers");
  }
  std::vector<Eigen::Vector3d> points(reader.num_rows(), Eigen::Vector3d::Zero());
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (std::uint32_t axis = 0; axis < count; ++axis) points[i](axis) = values[i * count + axis];
  }
  require_cloud(points);
  digest_cloud(points, digest);
}

}  // namespace

int main(int argc, char** argv) { return reader_main(argc, argv, {{".ply", read_ply}}); }
