// xtensor (https://github.com/xtensor-stack/xtensor) on arrays of NumPy: of at most two dimensions,
// as doubles, as ours reads them, and what ../reader_trials.hpp tells. The type must be known
// before, so one after the other is tried.

#include <xtensor/xnpy.hpp>

#include "../reader_trials.hpp"

namespace {

using namespace loopstone::bench;

template <typename Number>
void read_as(const std::string& path, ValueDigest* digest) {
  const auto array = xt::load_npy<Number>(path);
  if (array.dimension() > 2) throw std::invalid_argument("has more than two dimensions");
  const std::size_t rows = array.dimension() < 1 ? 1 : array.shape(0);
  const std::size_t columns = array.dimension() < 2 ? 1 : array.shape(1);
  // As ours hands it on: in the order of memory, whatever that is.
  const std::vector<double> values(array.storage().begin(), array.storage().end());
  if (digest == nullptr) return;
  digest->add_sizes("", rows, columns);
  for (std::size_t row = 0; row < rows; ++row) {
    for (std::size_t column = 0; column < columns; ++column) {
      const auto value = array.dimension() == 2   ? array(row, column)
                         : array.dimension() == 1 ? array(row)
                                                  : values.at(0);
      digest->add(static_cast<double>(value));
    }
  }
}

template <typename First, typename... Rest>
void read_one_of(const std::string& path, ValueDigest* digest) {
  try {
    return read_as<First>(path, digest);
  } catch (const std::runtime_error&) {
    if constexpr (sizeof...(Rest) == 0) throw;
  }
  if constexpr (sizeof...(Rest) > 0) read_one_of<Rest...>(path, digest);
}

}  // namespace

int main(int argc, char** argv) {
  return reader_main(argc, argv,
                     {{".npy", read_one_of<double, float, std::int64_t, std::int32_t, std::int16_t,
                                           std::uint16_t, std::uint8_t, bool>}});
}
