// Aligns the partial clouds of the UCSD warm-up to their models from no guess: rmse over all
// observed points, time, and how both hold when the cloud is first turned and moved at random,
// shuffled, and thinned.
//   bench_cloud_match [--data DIR] [--json OUT] [--seeds N] [--turns any|about_z] [--starts N]

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>
#include <vector>

#include "loopstone/base/rng.hpp"
#include "loopstone/formats/point_cloud_file.hpp"
#include "loopstone/registration/cloud_search.hpp"
#include "support/recorded_data.hpp"

namespace loopstone {
namespace {

using Points = std::vector<Eigen::Vector3d>;

/// The models are in millimetres, the observed clouds in metres.
constexpr double kModelUnitM = 1e-3;

/// rmse [mm], the best of four peers, each from 36 headings.
struct Object {
  std::string name;
  std::array<double, 4> reference_mm;
};
const std::array<Object, 2> kObjects{
    {{"drill", {1.967, 1.920, 2.387, 3.215}}, {"liq_container", {1.379, 1.439, 1.258, 1.424}}}};

double cpu_ms() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

Pose3 random_motion(Rng& rng, bool about_z) {
  const Eigen::Vector3d shift(rng.normal(), rng.normal(), rng.normal());
  if (about_z) {
    return Pose3::from_roll_pitch_yaw(shift, 0.0, 0.0,
                                      rng.uniform(-std::numbers::pi, std::numbers::pi));
  }
  const Eigen::Vector4d q(rng.normal(), rng.normal(), rng.normal(), rng.normal());
  return {shift, Eigen::Quaterniond(q).normalized()};
}

Points turned_and_shuffled(const Points& cloud, const Pose3& motion, Rng& rng) {
  Points points;
  points.reserve(cloud.size());
  for (const auto& point : cloud) points.emplace_back(motion * point);
  for (std::size_t i = points.size(); i > 1; --i) std::swap(points[i - 1], points[rng.below(i)]);
  return points;
}

/// Over all points of a cloud, whichever of them the pose was found with.
double rmse_mm(const Points& cloud, const Pose3& pose, const CloudModel<3>& model) {
  const auto& frame = model.frame();
  double sum = 0.0;
  for (const auto& point : cloud) {
    const Eigen::Vector3d placed = frame.rotation * (pose * point - frame.centre);
    sum +=
        static_cast<double>(model.field().nearest_point(placed.cast<float>()).squared_distance_m2);
  }
  return 1e3 * std::sqrt(sum / static_cast<double>(cloud.size()));
}

nlohmann::json measure(const std::string& name, double reference_mm, const Points& cloud,
                       const CloudModel<3>& model, double model_ms,
                       const CloudSearchOptions& options, int seeds) {
  constexpr std::size_t kThinned = 2500;
  const auto plain = search_alignment<3>(cloud, model, options);
  std::vector<double> times;
  double worst_mm = 0.0;
  double worst_thinned_mm = 0.0;
  double spread_rad = 0.0;
  int least_agreeing = plain.agreeing;
  for (int seed = 0; seed < seeds; ++seed) {
    Rng rng(static_cast<std::uint64_t>(seed) + 1);
    const Pose3 motion = random_motion(rng, options.turns == SearchTurns::kAboutZ);
    const Points source = turned_and_shuffled(cloud, motion, rng);
    const double begin = cpu_ms();
    const auto found = search_alignment<3>(source, model, options);
    times.push_back(cpu_ms() - begin);
    const Pose3 pose = found.match.target_T_source * motion;
    worst_mm = std::max(worst_mm, rmse_mm(cloud, pose, model));
    spread_rad =
        std::max(spread_rad, pose.rotation.angularDistance(plain.match.target_T_source.rotation));
    least_agreeing = std::min(least_agreeing, found.agreeing);

    const std::span<const Eigen::Vector3d> thinned(source.data(),
                                                   std::min(kThinned, source.size()));
    const auto of_few = search_alignment<3>(thinned, model, options);
    worst_thinned_mm =
        std::max(worst_thinned_mm, rmse_mm(cloud, of_few.match.target_T_source * motion, model));
  }
  return {{"name", name},
          {"points", cloud.size()},
          {"rmse_mm", rmse_mm(cloud, plain.match.target_T_source, model)},
          {"reference_mm", reference_mm},
          {"starts", plain.starts},
          {"finalists", plain.finalists},
          {"agreeing", plain.agreeing},
          {"least_agreeing", least_agreeing},
          {"runner_up_rmse_mm", plain.runner_up ? 1e3 * plain.runner_up->rmse_m : 0.0},
          {"status", std::string(to_string(plain.match.status))},
          {"ms", median(times) + model_ms},
          {"search_ms", median(times)},
          {"model_ms", model_ms},
          {"seeds", seeds},
          {"worst_rmse_mm", worst_mm},
          {"worst_turn_between_seeds_deg", spread_rad * 180.0 / std::numbers::pi},
          {"worst_rmse_of_2500_points_mm", worst_thinned_mm}};
}

}  // namespace
}  // namespace loopstone

int main(int argc, char** argv) {
  using namespace loopstone;
  std::string data = test::recorded_data("ucsd/icp_warm_up");
  std::string json_path;
  CloudSearchOptions options;
  int seeds = 20;
  for (int i = 1; i + 1 < argc; i += 2) {
    const std::string flag = argv[i];
    if (flag == "--data") data = argv[i + 1];
    if (flag == "--json") json_path = argv[i + 1];
    if (flag == "--seeds") seeds = std::max(1, std::atoi(argv[i + 1]));
    if (flag == "--turns") options.turns = find_word<SearchTurns>(argv[i + 1]).value();
    if (flag == "--starts") options.starts = std::max(1, std::atoi(argv[i + 1]));
  }
  nlohmann::json rows = nlohmann::json::array();
  for (const auto& object : kObjects) {
    const std::filesystem::path folder = std::filesystem::path(data) / object.name;
    if (data.empty() || !std::filesystem::exists(folder / "model.mat")) {
      std::fprintf(stderr, "%s: no model.mat there; --data names the folder of the warm-up\n",
                   folder.c_str());
      continue;
    }
    Points model_points = read_point_cloud(folder / "model.mat").points;
    for (auto& point : model_points) point *= kModelUnitM;
    std::vector<double> model_times;
    for (int i = 0; i < 5; ++i) {
      const double begin = cpu_ms();
      const CloudModel<3> model(model_points);
      model_times.push_back(cpu_ms() - begin);
    }
    const CloudModel<3> model(model_points);
    for (std::size_t i = 0; i < object.reference_mm.size(); ++i) {
      const Points cloud = read_point_cloud(folder / (std::to_string(i) + ".npy")).points;
      rows.push_back(measure(object.name + " " + std::to_string(i), object.reference_mm[i], cloud,
                             model, median(model_times), options, seeds));
      std::printf("%s\n", rows.back().dump().c_str());
      std::fflush(stdout);
    }
  }
  if (!json_path.empty()) {
    std::ofstream(json_path) << nlohmann::json{{"section", "clouds"}, {"rows", rows}}.dump(2)
                             << "\n";
  }
  return 0;
}
