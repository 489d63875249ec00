// matio (https://github.com/tbeu/matio) on MATLAB files: reads every real matrix of numbers as
// doubles, as ours does, and steps over the rest.
//   mat_files make FOLDER SCANS    writes so many laser scans in every variant
// and what ../reader_trials.hpp tells.

#include <matio.h>

#include <array>
#include <memory>

#include "../reader_trials.hpp"

namespace {

using namespace loopstone::bench;
using Variable = std::unique_ptr<matvar_t, void (*)(matvar_t*)>;

struct CloseMat {
  void operator()(mat_t* mat) const { Mat_Close(mat); }
};
using Mat = std::unique_ptr<mat_t, CloseMat>;

bool had_error = false;

/// What the library would print. Some damage it only tells so.
void note_error(int level, char*) {
  had_error = had_error || (level & (MATIO_LOG_LEVEL_ERROR | MATIO_LOG_LEVEL_CRITICAL)) != 0;
}

[[noreturn]] void fail(const char* reason) { throw std::runtime_error(reason); }

template <typename Number>
void append(const matvar_t& variable, std::size_t count, std::vector<double>& values) {
  const auto* const from = static_cast<const Number*>(variable.data);
  for (std::size_t i = 0; i < count; ++i) values.push_back(static_cast<double>(from[i]));
}

std::vector<double> values_of(const matvar_t& variable, std::size_t count) {
  std::vector<double> values;
  if (count == 0) return values;
  if (variable.data == nullptr) fail("a matrix has no numbers");
  values.reserve(count);
  switch (variable.class_type) {
    case MAT_C_DOUBLE:
      append<double>(variable, count, values);
      break;
    case MAT_C_SINGLE:
      append<float>(variable, count, values);
      break;
    case MAT_C_INT8:
      append<std::int8_t>(variable, count, values);
      break;
    case MAT_C_UINT8:
      append<std::uint8_t>(variable, count, values);
      break;
    case MAT_C_INT16:
      append<std::int16_t>(variable, count, values);
      break;
    case MAT_C_UINT16:
      append<std::uint16_t>(variable, count, values);
      break;
    case MAT_C_INT32:
      append<std::int32_t>(variable, count, values);
      break;
    case MAT_C_UINT32:
      append<std::uint32_t>(variable, count, values);
      break;
    case MAT_C_INT64:
      append<std::int64_t>(variable, count, values);
      break;
    case MAT_C_UINT64:
      append<std::uint64_t>(variable, count, values);
      break;
    default:
      fail("a matrix is of another class");
  }
  return values;
}

struct Matrix {
  std::string name;
  std::size_t rows = 0;
  std::size_t columns = 0;
  std::vector<double> values{};
};

void read_mat(const std::string& path, ValueDigest* digest) {
  had_error = false;
  Mat_LogInitFunc("mat_files", note_error);
  const Mat mat(Mat_Open(path.c_str(), MAT_ACC_RDONLY));
  if (!mat) fail("is no MATLAB file that matio opens");
  std::vector<Matrix> matrices;
  while (true) {
    const Variable variable(Mat_VarReadNextInfo(mat.get()), Mat_VarFree);
    if (!variable) break;
    const bool is_matrix = variable->class_type >= MAT_C_DOUBLE &&
                           variable->class_type <= MAT_C_UINT64 && variable->rank == 2 &&
                           variable->isComplex == 0;
    if (!is_matrix) continue;
    const std::size_t rows = variable->dims[0];
    const std::size_t columns = variable->dims[1];
    require_value_bytes(rows, 8);
    require_value_bytes(columns, 8);
    require_value_bytes(std::uint64_t{rows} * columns, 8);
    if (Mat_VarReadDataAll(mat.get(), variable.get()) != 0) fail("a matrix can't be read");
    matrices.push_back({variable->name == nullptr ? "" : variable->name, rows, columns,
                        values_of(*variable, rows * columns)});
  }
  if (had_error) fail("matio told of an error");
  if (digest == nullptr) return;
  for (const Matrix& matrix : matrices) {
    digest->add_sizes(matrix.name, matrix.rows, matrix.columns);
    digest->add_all(matrix.values);
  }
}

// What is written.

template <typename Number>
Variable matrix(const char* name, matio_classes kind, matio_types type, std::size_t rows,
                std::size_t columns, std::vector<Number> values) {
  std::array<std::size_t, 2> sizes{rows, columns};
  return {Mat_VarCreate(name, kind, type, 2, sizes.data(), values.data(), 0), Mat_VarFree};
}

/// Distances to the walls of a room with noise [m], in steps of a millimetre.
std::vector<double> ranges_of(std::size_t scans, std::size_t beams) {
  std::vector<double> ranges(scans * beams);
  std::uint32_t state = 1;
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    state = state * 1664525U + 1013904223U;
    const std::size_t beam = i / scans;
    ranges[i] = 0.001 * static_cast<double>(2000 + 17 * (beam % 90) + (state >> 27U));
  }
  return ranges;
}

struct Variant {
  const char* name;
  mat_ft version;
  matio_compression compression;
  bool is_single = false;
  bool has_others = false;
};

void write_others(mat_t* mat, matio_compression compression) {
  std::array<std::size_t, 3> cube{2, 2, 2};
  std::array<double, 8> numbers{1, 2, 3, 4, 5, 6, 7, 8};
  const Variable three(
      Mat_VarCreate("cube", MAT_C_DOUBLE, MAT_T_DOUBLE, 3, cube.data(), numbers.data(), 0),
      Mat_VarFree);
  Mat_VarWrite(mat, three.get(), compression);
  std::array<std::size_t, 2> line{1, 5};
  std::string text = "lidar";
  const Variable words(
      Mat_VarCreate("sensor", MAT_C_CHAR, MAT_T_UINT8, 2, line.data(), text.data(), 0),
      Mat_VarFree);
  Mat_VarWrite(mat, words.get(), compression);
  std::array<std::size_t, 2> one{1, 1};
  const std::array<const char*, 2> fields{"count", nullptr};
  const Variable record(Mat_VarCreateStruct2("head", 2, one.data(), fields.data()), Mat_VarFree);
  double count = 4;
  Mat_VarSetStructFieldByName(
      record.get(), "count", 0,
      Mat_VarCreate(nullptr, MAT_C_DOUBLE, MAT_T_DOUBLE, 2, one.data(), &count, 0));
  Mat_VarWrite(mat, record.get(), compression);
}

void write_variant(const std::string& folder, const Variant& variant, std::size_t scans) {
  constexpr std::size_t kBeams = 360;
  const std::string path = folder + "/" + variant.name + ".mat";
  const Mat mat(Mat_CreateVer(path.c_str(), nullptr, variant.version));
  if (!mat) fail("can't be written");
  const std::vector<double> ranges = ranges_of(scans, kBeams);
  std::vector<double> stamps;
  for (std::size_t i = 0; i < scans; ++i) stamps.push_back(0.1 * static_cast<double>(i));
  const Variable times = matrix("stamps", MAT_C_DOUBLE, MAT_T_DOUBLE, scans, 1, stamps);
  Mat_VarWrite(mat.get(), times.get(), variant.compression);
  if (variant.has_others) write_others(mat.get(), variant.compression);
  const Variable all = variant.is_single
                           ? matrix("ranges", MAT_C_SINGLE, MAT_T_SINGLE, scans, kBeams,
                                    std::vector<float>(ranges.begin(), ranges.end()))
                           : matrix("ranges", MAT_C_DOUBLE, MAT_T_DOUBLE, scans, kBeams, ranges);
  Mat_VarWrite(mat.get(), all.get(), variant.compression);
}

const std::vector<Variant> kVariants{
    {"doubles", MAT_FT_MAT5, MAT_COMPRESSION_NONE},
    {"doubles_compressed", MAT_FT_MAT5, MAT_COMPRESSION_ZLIB},
    {"singles", MAT_FT_MAT5, MAT_COMPRESSION_NONE, true},
    {"singles_compressed", MAT_FT_MAT5, MAT_COMPRESSION_ZLIB, true},
    {"others_between", MAT_FT_MAT5, MAT_COMPRESSION_NONE, false, true},
    {"others_between_compressed", MAT_FT_MAT5, MAT_COMPRESSION_ZLIB, false, true},
    {"version_4", MAT_FT_MAT4, MAT_COMPRESSION_NONE},
    {"version_7.3", MAT_FT_MAT73, MAT_COMPRESSION_ZLIB},
};

}  // namespace

int main(int argc, char** argv) {
  if (argc == 4 && std::string_view(argv[1]) == "make") {
    for (const Variant& variant : kVariants) write_variant(argv[2], variant, std::stoul(argv[3]));
    return 0;
  }
  return reader_main(argc, argv, {{".mat", read_mat}});
}
