// Compares the texture of a floor with the true floor of a simulation:
//   measure_texture TEXTURE FLOOR SEED [ESTIMATE.tum REFERENCE.tum]
// TEXTURE: folder of texture.png, coverage.png and texture.yaml. FLOOR, SEED: as given to
// `loopstone simulate --floor --seed`. With two trajectories the texture is first moved by what
// lays the estimate on the reference, then by the few millimetres that lay the texture itself on
// the true floor: the frame of a map is its own, one rigid motion for all of it. The truth of a
// cell is the mean of the pattern over the cell, in linear light, as sRGB. Prints one JSON object:
//   psnr_db over the seen cells;
//   psnr_levelled_db after one common gain (no camera knows how bright a floor is);
//   letters of 5 cm: how many lie in seen floor, how many are read (see Reader).

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <map>
#include <string>
#include <vector>

#include "loopstone/base/error.hpp"
#include "loopstone/base/linear_light.hpp"
#include "loopstone/evaluation/trajectory_error.hpp"
#include "loopstone/formats/image.hpp"
#include "loopstone/formats/texture_files.hpp"
#include "loopstone/formats/tum.hpp"
#include "loopstone/simulation/floor_pattern.hpp"

namespace loopstone::bench {
namespace {

/// The texture as cells of its own map, and where that map lies on the true one.
struct Texture {
  GridFrame frame;
  Image colours;
  Image coverage;
  Pose2 truth_T_map{};

  [[nodiscard]] bool seen(Cell cell) const {
    return frame.contains(cell) && coverage.sample(frame.rows - 1 - cell.row, cell.column) == 255;
  }
  [[nodiscard]] std::array<double, 3> light(Cell cell) const {
    std::array<double, 3> rgb{};
    for (int c = 0; c < 3; ++c) {
      rgb[static_cast<std::size_t>(c)] =
          linear_of_srgb(colours.sample(frame.rows - 1 - cell.row, cell.column, c) / 255.0);
    }
    return rgb;
  }
};

Texture read_texture(const std::string& folder) {
  const TextureInfo info = read_texture_yaml(folder + "/texture.yaml");
  Texture texture;
  texture.colours = read_image(info.image);
  if (!info.coverage) throw DataError({folder + "/texture.yaml"}, "names no coverage picture");
  texture.coverage = read_image(*info.coverage);
  texture.frame = info.frame(texture.colours.width, texture.colours.height);
  return texture;
}

struct Likeness {
  std::int64_t cells = 0;
  double psnr_db = 0.0;
  double psnr_levelled_db = 0.0;
  double gain = 1.0;
};

double psnr(double squares, std::int64_t samples) {
  return 10.0 * std::log10(static_cast<double>(samples) / std::max(squares, 1e-12));
}

/// Squared differences in sRGB over every `every`-th cell in both directions, with the texture's
/// map lying so.
double difference(const Texture& texture, const FloorPattern& floor, const Pose2& truth_T_map,
                  int every) {
  double sum = 0.0;
  for (int row = 0; row < texture.frame.rows; row += every) {
    for (int column = 0; column < texture.frame.columns; column += every) {
      const Cell cell{column, row};
      if (!texture.seen(cell)) continue;
      const Eigen::Vector2d centre = texture.frame.centre_of(cell);
      const LinearColour mean = floor.mean_over(truth_T_map * Pose2{centre.x(), centre.y(), 0.0},
                                                texture.frame.resolution);
      const auto light = texture.light(cell);
      for (int c = 0; c < 3; ++c) {
        const double error = srgb_of_linear(light[static_cast<std::size_t>(c)]) -
                             srgb_of_linear(static_cast<double>(mean[c]));
        sum += error * error;
      }
    }
  }
  return sum;
}

/// The rigid motion near the given one under which the texture is most like the floor (compass
/// search, Hooke and Jeeves 1961), turning about the texture's middle.
Pose2 best_fit(const Texture& texture, const FloorPattern& floor) {
  constexpr int kEvery = 7;
  const Eigen::Vector2d middle =
      texture.frame.origin +
      0.5 * texture.frame.resolution * Eigen::Vector2d(texture.frame.columns, texture.frame.rows);
  const Pose2 map_T_middle{middle.x(), middle.y(), 0.0};
  Pose2 truth_T_middle = texture.truth_T_map * map_T_middle;
  double best = difference(texture, floor, texture.truth_T_map, kEvery);
  for (double step_m = 0.002; step_m > 0.0001; step_m *= 0.5) {
    const double step_rad = step_m / 5.0;
    bool moved = true;
    while (moved) {
      moved = false;
      for (const Pose2& step :
           {Pose2{step_m, 0.0, 0.0}, Pose2{-step_m, 0.0, 0.0}, Pose2{0.0, step_m, 0.0},
            Pose2{0.0, -step_m, 0.0}, Pose2{0.0, 0.0, step_rad}, Pose2{0.0, 0.0, -step_rad}}) {
        const Pose2 tried = truth_T_middle * step;
        const double value = difference(texture, floor, tried * map_T_middle.inverse(), kEvery);
        if (value < best) {
          best = value;
          truth_T_middle = tried;
          moved = true;
        }
      }
    }
  }
  return truth_T_middle * map_T_middle.inverse();
}

Likeness compare(const Texture& texture, const FloorPattern& floor) {
  std::vector<std::array<double, 3>> found;
  std::vector<std::array<double, 3>> truth;
  for (int row = 0; row < texture.frame.rows; ++row) {
    for (int column = 0; column < texture.frame.columns; ++column) {
      const Cell cell{column, row};
      if (!texture.seen(cell)) continue;
      const Eigen::Vector2d centre = texture.frame.centre_of(cell);
      const Pose2 truth_T_cell = texture.truth_T_map * Pose2{centre.x(), centre.y(), 0.0};
      const LinearColour mean = floor.mean_over(truth_T_cell, texture.frame.resolution);
      found.push_back(texture.light(cell));
      truth.push_back({static_cast<double>(mean.x()), static_cast<double>(mean.y()),
                       static_cast<double>(mean.z())});
    }
  }
  Likeness likeness;
  likeness.cells = static_cast<std::int64_t>(found.size());
  double products = 0.0;
  double squares_found = 0.0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    for (std::size_t c = 0; c < 3; ++c) {
      products += found[i][c] * truth[i][c];
      squares_found += found[i][c] * found[i][c];
    }
  }
  likeness.gain = squares_found > 0.0 ? products / squares_found : 1.0;
  const auto squares = [&](double gain) {
    double sum = 0.0;
    for (std::size_t i = 0; i < found.size(); ++i) {
      for (std::size_t c = 0; c < 3; ++c) {
        const double error =
            srgb_of_linear(std::clamp(gain * found[i][c], 0.0, 1.0)) - srgb_of_linear(truth[i][c]);
        sum += error * error;
      }
    }
    return sum;
  };
  likeness.psnr_db = psnr(squares(1.0), 3 * likeness.cells);
  likeness.psnr_levelled_db = psnr(squares(likeness.gain), 3 * likeness.cells);
  return likeness;
}

/// Reads letters as a machine may: the patch of a letter is compared, by normalised correlation of
/// brightness, with what the same patch of the true floor looks like for every kind of letter,
/// through the same cells. Read: its own kind is the most alike.
class Reader {
 public:
  Reader(const FloorPattern& floor, double cell_m) : floor_(floor), cell_m_(cell_m) {
    const Eigen::Vector2d period = floor.period_m();
    for (const FloorLetter& letter : floor.letters_in({{0.0, 0.0}, period})) {
      if (is_wanted(letter)) kinds_.try_emplace(letter.letter, true_patch(letter));
    }
  }

  [[nodiscard]] static bool is_wanted(const FloorLetter& letter) {
    return std::abs(letter.height_m - 0.05) < 1e-3 && letter.letter != ' ';
  }
  /// Points of a letter's patch, its own frame: 5 x 7 times 2 samples, and a rim of one.
  [[nodiscard]] static std::vector<Eigen::Vector2d> points(const FloorLetter& letter) {
    constexpr int kColumns = 9;
    constexpr int kRows = 12;
    std::vector<Eigen::Vector2d> made;
    for (int row = 0; row < kRows; ++row) {
      for (int column = 0; column < kColumns; ++column) {
        made.emplace_back(letter.height_m * 0.75 * (column + 0.5) / kColumns,
                          letter.height_m * (row + 0.5) / kRows);
      }
    }
    return made;
  }
  [[nodiscard]] bool reads(const FloorLetter& letter, const std::vector<double>& patch) const {
    char best = ' ';
    double highest = -2.0;
    for (const auto& [kind, truth] : kinds_) {
      const double value = correlation(patch, truth);
      if (value > highest) {
        highest = value;
        best = kind;
      }
    }
    return best == letter.letter;
  }
  [[nodiscard]] std::size_t kinds() const { return kinds_.size(); }

 private:
  [[nodiscard]] std::vector<double> true_patch(const FloorLetter& letter) const {
    std::vector<double> patch;
    for (const Eigen::Vector2d& point : points(letter)) {
      const Eigen::Vector2d at = letter.map_T_letter * point;
      patch.push_back(static_cast<double>(
          floor_.mean_over(Pose2{at.x(), at.y(), letter.map_T_letter.yaw}, cell_m_).sum()));
    }
    return patch;
  }
  [[nodiscard]] static double correlation(const std::vector<double>& a,
                                          const std::vector<double>& b) {
    const auto n = static_cast<double>(a.size());
    double sum_a = 0.0, sum_b = 0.0, aa = 0.0, bb = 0.0, ab = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i) {
      sum_a += a[i];
      sum_b += b[i];
      aa += a[i] * a[i];
      bb += b[i] * b[i];
      ab += a[i] * b[i];
    }
    const double variance = (aa - sum_a * sum_a / n) * (bb - sum_b * sum_b / n);
    return variance > 0.0 ? (ab - sum_a * sum_b / n) / std::sqrt(variance) : 0.0;
  }

  const FloorPattern& floor_;
  double cell_m_;
  std::map<char, std::vector<double>> kinds_{};
};

/// Brightness between the cells' centres; false where a cell isn't seen.
bool bilinear(const Texture& texture, const Eigen::Vector2d& map_point, double& brightness) {
  const Eigen::Vector2d at =
      (map_point - texture.frame.origin) / texture.frame.resolution - Eigen::Vector2d(0.5, 0.5);
  const int column = floor_to_int(at.x());
  const int row = floor_to_int(at.y());
  brightness = 0.0;
  for (const int dy : {0, 1}) {
    for (const int dx : {0, 1}) {
      const Cell cell{column + dx, row + dy};
      if (!texture.seen(cell)) return false;
      const auto rgb = texture.light(cell);
      const double weight = (dx == 0 ? 1.0 - (at.x() - column) : at.x() - column) *
                            (dy == 0 ? 1.0 - (at.y() - row) : at.y() - row);
      brightness += weight * (rgb[0] + rgb[1] + rgb[2]);
    }
  }
  return true;
}

int measure(const std::vector<std::string>& arguments) {
  Texture texture = read_texture(arguments[0]);
  const FloorPattern floor =
      make_floor(arguments[1], std::strtoull(arguments[2].c_str(), nullptr, 10));
  if (arguments.size() == 5) {
    texture.truth_T_map =
        absolute_error(read_tum(arguments[3]), read_tum(arguments[4]), Alignment::kSe2)
            .reference_T_estimate;
    texture.truth_T_map = best_fit(texture, floor);
  }
  const Likeness likeness = compare(texture, floor);

  const Pose2 map_T_truth = texture.truth_T_map.inverse();
  const Reader reader(floor, texture.frame.resolution);
  const GridFrame& frame = texture.frame;
  Extent extent{{1e300, 1e300}, {-1e300, -1e300}};
  for (const Eigen::Vector2d& corner :
       {Eigen::Vector2d(0, 0), Eigen::Vector2d(frame.columns, 0),
        Eigen::Vector2d(frame.columns, frame.rows), Eigen::Vector2d(0, frame.rows)}) {
    const Eigen::Vector2d at =
        texture.truth_T_map * Eigen::Vector2d(frame.origin + frame.resolution * corner);
    extent.low = extent.low.cwiseMin(at);
    extent.high = extent.high.cwiseMax(at);
  }
  std::int64_t letters = 0;
  std::int64_t letters_read = 0;
  for (const FloorLetter& letter : floor.letters_in(extent)) {
    if (!Reader::is_wanted(letter)) continue;
    std::vector<double> patch;
    for (const Eigen::Vector2d& point : Reader::points(letter)) {
      double brightness = 0.0;
      if (!bilinear(texture, map_T_truth * (letter.map_T_letter * point), brightness)) break;
      patch.push_back(brightness);
    }
    if (patch.size() < Reader::points(letter).size()) continue;
    ++letters;
    letters_read += reader.reads(letter, patch) ? 1 : 0;
  }
  std::printf(
      "{\"cells\": %lld, \"resolution_m\": %g, \"psnr_db\": %.3f, \"psnr_levelled_db\": %.3f, "
      "\"gain\": "
      "%.4f, \"letters\": %lld, \"letters_read\": %lld, \"kinds\": %zu}\n",
      static_cast<long long>(likeness.cells), frame.resolution, likeness.psnr_db,
      likeness.psnr_levelled_db, likeness.gain, static_cast<long long>(letters),
      static_cast<long long>(letters_read), reader.kinds());
  return 0;
}

}  // namespace
}  // namespace loopstone::bench

int main(int argc, char** argv) {
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  if (arguments.size() != 3 && arguments.size() != 5) {
    std::fprintf(stderr, "measure_texture TEXTURE FLOOR SEED [ESTIMATE.tum REFERENCE.tum]\n");
    return 2;
  }
  try {
    return loopstone::bench::measure(arguments);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
