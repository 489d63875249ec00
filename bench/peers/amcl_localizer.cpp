// nav2's AMCL on a recording that is all there: its filter, motion model, sensor model and map are
// those of the source package amcl 0.1.2 on PyPI (https://github.com/damanikjosh/amcl_python,
// GPL-3), which takes them from nav2. That is why this is a program of its own, which nothing that
// ships includes or links: it reads two files and prints lines.
//
// What nav2 does in its node stands here: when the filter is updated, what becomes of ranges that
// are none, which hypothesis is the pose, and that between updates the pose goes on by odometry.
// The Python module of that package is no use for it: it has the beam model alone, which is not
// nav2's default, and no start from nowhere.
//
//     amcl_localizer CELLS FEED KEY=VALUE...
//
// CELLS: width height resolution x y of the lower left corner, then bytes from there on: 0 free, 1
// unknown, 2 occupied. FEED: `laser x y yaw`, then for each scan `stamp x y yaw range_max angle
// step count r1..rn`, odom_T_robot. KEY: nav2's parameters by their names, `seed`, and
// `start=X,Y,YAW,SIGMA_M,SIGMA_RAD` (without: anywhere). Prints `stamp x y yaw xx yy yawyaw`.
//
// A map's origin is the corner of its first cell, which nav2 takes for the middle of that: half a
// cell is added here, so that it stands where the map says.

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <map>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "nav2_amcl/angleutils.hpp"
#include "nav2_amcl/map/map.hpp"
#include "nav2_amcl/motion_model/differential_motion_model.hpp"
#include "nav2_amcl/pf/pf.hpp"
#include "nav2_amcl/sensors/laser/laser.hpp"

namespace {

using Settings = std::map<std::string, std::string>;

/// What nav2's documentation gives as defaults.
const Settings kDefaults{{"min_particles", "500"},
                         {"max_particles", "2000"},
                         {"max_beams", "60"},
                         {"sigma_hit", "0.2"},
                         {"z_hit", "0.5"},
                         {"z_rand", "0.5"},
                         {"laser_likelihood_max_dist", "2.0"},
                         {"laser_model_type", "likelihood_field"},
                         {"do_beamskip", "0"},
                         {"beam_skip_distance", "0.5"},
                         {"beam_skip_threshold", "0.3"},
                         {"beam_skip_error_threshold", "0.9"},
                         {"alpha1", "0.2"},
                         {"alpha2", "0.2"},
                         {"alpha3", "0.2"},
                         {"alpha4", "0.2"},
                         {"alpha5", "0.2"},
                         {"update_min_d", "0.25"},
                         {"update_min_a", "0.2"},
                         {"resample_interval", "1"},
                         {"pf_err", "0.05"},
                         {"pf_z", "0.99"},
                         {"recovery_alpha_slow", "0"},
                         {"recovery_alpha_fast", "0"},
                         {"seed", "1"},
                         {"start", ""}};

double number(const Settings& settings, const std::string& key) {
  return std::stod(settings.at(key));
}

Settings settings_of(int count, char** words) {
  Settings settings = kDefaults;
  for (int i = 3; i < count; ++i) {
    const std::string word = words[i];
    const std::size_t equals = word.find('=');
    if (equals == word.npos || settings.count(word.substr(0, equals)) == 0) {
      throw std::runtime_error(word + ": no such parameter");
    }
    settings[word.substr(0, equals)] = word.substr(equals + 1);
  }
  return settings;
}

map_t* read_cells(const char* path) {
  std::ifstream file(path, std::ios::binary);
  map_t* map = map_alloc();
  double x = 0.0;
  double y = 0.0;
  file >> map->size_x >> map->size_y >> map->scale >> x >> y;
  file.get();
  const std::size_t count =
      static_cast<std::size_t>(map->size_x) * static_cast<std::size_t>(map->size_y);
  std::vector<char> bytes(count);
  if (!file.read(bytes.data(), static_cast<std::streamsize>(count))) {
    throw std::runtime_error(std::string(path) + ": too short");
  }
  map->origin_x = x + (map->size_x / 2 + 0.5) * map->scale;
  map->origin_y = y + (map->size_y / 2 + 0.5) * map->scale;
  map->cells = static_cast<map_cell_t*>(std::calloc(count, sizeof(map_cell_t)));
  for (std::size_t i = 0; i < count; ++i) {
    map->cells[i].occ_state = static_cast<int8_t>(bytes[i] - 1);
  }
  return map;
}

/// The middle of a free cell, any heading.
pf_vector_t pose_on_free_cell(void* data) {
  const map_t& map = *static_cast<map_t*>(data);
  for (;;) {
    const int i = static_cast<int>(drand48() * map.size_x);
    const int j = static_cast<int>(drand48() * map.size_y);
    if (map.cells[i + j * map.size_x].occ_state != -1) continue;
    pf_vector_t pose = pf_vector_zero();
    pose.v[0] = map.origin_x + (i - map.size_x / 2) * map.scale;
    pose.v[1] = map.origin_y + (j - map.size_y / 2) * map.scale;
    pose.v[2] = (2.0 * drand48() - 1.0) * M_PI;
    return pose;
  }
}

struct Scan {
  std::string stamp;
  pf_vector_t odom_T_robot = pf_vector_zero();
  double range_max = 0.0;
  std::vector<std::pair<double, double>> beams;  ///< range [m], angle [rad] in the laser's frame
};

/// False at the end.
bool read_scan(std::istream& file, Scan& scan) {
  std::string line;
  if (!std::getline(file, line)) return false;
  const std::size_t space = line.find(' ');
  scan.stamp = line.substr(0, space);
  const char* at = line.c_str() + space;
  const auto next = [&at] {
    char* end = nullptr;
    const double value = std::strtod(at, &end);
    if (end == at) throw std::runtime_error("a line of the feed is too short");
    at = end;
    return value;
  };
  for (double& value : scan.odom_T_robot.v) value = next();
  scan.range_max = next();
  const double angle = next();
  const double step = next();
  scan.beams.resize(static_cast<std::size_t>(next()));
  for (std::size_t i = 0; i < scan.beams.size(); ++i) {
    scan.beams[i] = {next(), angle + step * static_cast<double>(i)};
  }
  return true;
}

std::unique_ptr<nav2_amcl::Laser> laser_of(const Settings& settings, map_t* map) {
  const auto value = [&](const char* key) { return number(settings, key); };
  const auto beams = static_cast<std::size_t>(value("max_beams"));
  if (settings.at("laser_model_type") == "likelihood_field") {
    return std::make_unique<nav2_amcl::LikelihoodFieldModel>(
        value("z_hit"), value("z_rand"), value("sigma_hit"), value("laser_likelihood_max_dist"),
        beams, map);
  }
  return std::make_unique<nav2_amcl::LikelihoodFieldModelProb>(
      value("z_hit"), value("z_rand"), value("sigma_hit"), value("laser_likelihood_max_dist"),
      value("do_beamskip") > 0.0, value("beam_skip_distance"), value("beam_skip_threshold"),
      value("beam_skip_error_threshold"), beams, map);
}

void start(pf_t* filter, map_t* map, const std::string& words) {
  if (words.empty()) {
    pf_init_model(filter, pose_on_free_cell, map);
    return;
  }
  std::istringstream text(words);
  pf_vector_t mean = pf_vector_zero();
  double sigma_m = 0.0;
  double sigma_rad = 0.0;
  char comma = 0;
  text >> mean.v[0] >> comma >> mean.v[1] >> comma >> mean.v[2] >> comma >> sigma_m >> comma >>
      sigma_rad;
  if (!text) throw std::runtime_error("start=" + words + ": X,Y,YAW,SIGMA_M,SIGMA_RAD");
  pf_matrix_t covariance = pf_matrix_zero();
  covariance.m[0][0] = covariance.m[1][1] = sigma_m * sigma_m;
  covariance.m[2][2] = sigma_rad * sigma_rad;
  pf_init(filter, mean, covariance);
}

/// The mean of the heaviest cluster of particles.
pf_vector_t heaviest(pf_t* filter) {
  pf_vector_t best = pf_vector_zero();
  double most = -1.0;
  const int clusters = filter->sets[filter->current_set].cluster_count;
  for (int i = 0; i < clusters; ++i) {
    double weight = 0.0;
    pf_vector_t mean;
    pf_matrix_t covariance;
    if (pf_get_cluster_stats(filter, i, &weight, &mean, &covariance) == 0) break;
    if (weight > most) {
      most = weight;
      best = mean;
    }
  }
  return best;
}

class Amcl {
 public:
  Amcl(const Settings& settings, map_t* map, pf_vector_t robot_T_laser)
      : map_(map),
        laser_(laser_of(settings, map)),
        update_min_d_(number(settings, "update_min_d")),
        update_min_a_(number(settings, "update_min_a")),
        resample_interval_(static_cast<int>(number(settings, "resample_interval"))) {
    const auto value = [&](const char* key) { return number(settings, key); };
    filter_ =
        pf_alloc(static_cast<int>(value("min_particles")), static_cast<int>(value("max_particles")),
                 value("recovery_alpha_slow"), value("recovery_alpha_fast"), pose_on_free_cell);
    filter_->pop_err = value("pf_err");
    filter_->pop_z = value("pf_z");
    srand48(static_cast<long>(value("seed")));
    start(filter_, map, settings.at("start"));
    motion_.initialize(value("alpha1"), value("alpha2"), value("alpha3"), value("alpha4"),
                       value("alpha5"));
    laser_->SetLaserPose(robot_T_laser);
  }

  void add(const Scan& scan) {
    const pf_vector_t& now = scan.odom_T_robot;
    pf_vector_t delta = pf_vector_zero();
    for (int i = 0; i < 2; ++i) delta.v[i] = now.v[i] - used_.v[i];
    delta.v[2] = nav2_amcl::angleutils::angle_diff(now.v[2], used_.v[2]);
    const bool moved = std::abs(delta.v[0]) > update_min_d_ ||
                       std::abs(delta.v[1]) > update_min_d_ || std::abs(delta.v[2]) > update_min_a_;
    if (began_ && !moved) return;
    if (began_) motion_.odometryUpdate(filter_, now, delta);
    began_ = true;
    used_ = now;
    weigh(scan);
    if (++updates_ % resample_interval_ == 0) pf_update_resample(filter_, map_);
    map_T_robot_ = heaviest(filter_);
  }

  /// At the last scan that was added, or by odometry since.
  [[nodiscard]] pf_vector_t pose(const pf_vector_t& odom_T_robot) const {
    const double turn = map_T_robot_.v[2] - used_.v[2];
    const double x = odom_T_robot.v[0] - used_.v[0];
    const double y = odom_T_robot.v[1] - used_.v[1];
    pf_vector_t pose = map_T_robot_;
    pose.v[0] += std::cos(turn) * x - std::sin(turn) * y;
    pose.v[1] += std::sin(turn) * x + std::cos(turn) * y;
    pose.v[2] += odom_T_robot.v[2] - used_.v[2];
    return pose;
  }
  [[nodiscard]] const pf_matrix_t& covariance() const {
    return filter_->sets[filter_->current_set].cov;
  }

 private:
  void weigh(const Scan& scan) {
    nav2_amcl::LaserData data;
    data.laser = laser_.get();
    data.range_count = static_cast<int>(scan.beams.size());
    data.range_max = scan.range_max;
    data.ranges = new double[scan.beams.size()][2];  // it deletes them
    for (std::size_t i = 0; i < scan.beams.size(); ++i) {
      data.ranges[i][0] = scan.beams[i].first;
      data.ranges[i][1] = scan.beams[i].second;
    }
    laser_->sensorUpdate(filter_, &data);
  }

  map_t* map_;
  std::unique_ptr<nav2_amcl::Laser> laser_;
  nav2_amcl::DifferentialMotionModel motion_;
  pf_t* filter_ = nullptr;  ///< until the process ends
  double update_min_d_;
  double update_min_a_;
  int resample_interval_;
  int updates_ = 0;
  bool began_ = false;
  pf_vector_t used_ = pf_vector_zero();  ///< odom_T_robot of the last update
  pf_vector_t map_T_robot_ = pf_vector_zero();
};

void run(int count, char** words) {
  const Settings settings = settings_of(count, words);
  std::ifstream feed(words[2]);
  std::string word;
  pf_vector_t robot_T_laser = pf_vector_zero();
  feed >> word >> robot_T_laser.v[0] >> robot_T_laser.v[1] >> robot_T_laser.v[2];
  if (!feed || word != "laser") throw std::runtime_error("the feed has no laser");
  feed.ignore();
  Amcl amcl(settings, read_cells(words[1]), robot_T_laser);
  Scan scan;
  while (read_scan(feed, scan)) {
    amcl.add(scan);
    const pf_vector_t pose = amcl.pose(scan.odom_T_robot);
    const pf_matrix_t& covariance = amcl.covariance();
    std::printf("%s %.6f %.6f %.6f %.6g %.6g %.6g\n", scan.stamp.c_str(), pose.v[0], pose.v[1],
                pose.v[2], covariance.m[0][0], covariance.m[1][1], covariance.m[2][2]);
  }
}

}  // namespace

int main(int count, char** words) {
  try {
    if (count < 3) throw std::runtime_error("amcl_localizer CELLS FEED KEY=VALUE...");
    run(count, words);
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "amcl_localizer: " << error.what() << '\n';
    return 1;
  }
}
