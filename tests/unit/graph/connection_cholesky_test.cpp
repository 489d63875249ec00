#include "graph/connection_cholesky.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <complex>
#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <utility>
#include <vector>

#include "loopstone/base/rng.hpp"

namespace loopstone {
namespace {

using Pairs = std::vector<std::pair<int, int>>;

template <typename Block>
constexpr bool kIsReal = std::is_same_v<Block, RealBlock<3>>;

template <typename Block>
constexpr int kSize = static_cast<int>(Block::Real::RowsAtCompileTime);

Pairs random_pairs(int size, int extra, Rng& rng) {
  Pairs pairs;
  for (int i = 0; i + 1 < size; ++i) pairs.emplace_back(i, i + 1);
  for (int i = 0; i < extra; ++i) {
    const int a = static_cast<int>(rng.below(static_cast<std::uint64_t>(size)));
    const int b = static_cast<int>(rng.below(static_cast<std::uint64_t>(size)));
    if (a != b) pairs.emplace_back(a, b);
  }
  return pairs;
}

template <typename Block>
Block random_block(Rng& rng) {
  Block block;
  for (int i = 0; i < block.re.size(); ++i) block.re(i) = rng.uniform(-1.0, 1.0);
  if constexpr (!kIsReal<Block>) {
    for (int i = 0; i < block.im.size(); ++i) block.im(i) = rng.uniform(-1.0, 1.0);
  }
  return block;
}

template <typename Block>
Eigen::MatrixXcd dense(const Block& block) {
  if constexpr (kIsReal<Block>) {
    return block.re.template cast<std::complex<double>>();
  } else {
    return block.re.template cast<std::complex<double>>() +
           std::complex<double>(0.0, 1.0) * block.im.template cast<std::complex<double>>();
  }
}

/// A sum of r r^H over pairs, r = (B at one node, C at the other): positive definite with a little
/// on the diagonal.
template <typename Block>
struct Example {
  ConnectionCholesky<Block> sparse;
  Eigen::MatrixXcd matrix;
};

template <typename Block>
Example<Block> example(const EliminationPattern& pattern, const Pairs& pairs, Rng& rng) {
  constexpr int n = kSize<Block>;
  const auto size = static_cast<int>(pattern.size());
  Example<Block> result{ConnectionCholesky<Block>(pattern),
                        Eigen::MatrixXcd::Zero(n * size, n * size)};
  const auto add = [&](Block& target, int row, int column, const Eigen::MatrixXcd& value) {
    target.re += value.real();
    if constexpr (!kIsReal<Block>) target.im += value.imag();
    result.matrix.block(n * row, n * column, n, n) += value;
    if (row != column) result.matrix.block(n * column, n * row, n, n) += value.adjoint();
  };
  for (const auto& [a, b] : pairs) {
    const int low = std::min(pattern.place[static_cast<std::size_t>(a)],
                             pattern.place[static_cast<std::size_t>(b)]);
    const int high = std::max(pattern.place[static_cast<std::size_t>(a)],
                              pattern.place[static_cast<std::size_t>(b)]);
    const Eigen::MatrixXcd at_low = dense(random_block<Block>(rng));
    const Eigen::MatrixXcd at_high = dense(random_block<Block>(rng));
    add(result.sparse.diagonal(low), low, low, at_low * at_low.adjoint());
    add(result.sparse.diagonal(high), high, high, at_high * at_high.adjoint());
    add(result.sparse.below(pattern.find(high, low)), high, low, at_high * at_low.adjoint());
  }
  for (int i = 0; i < size; ++i) {
    add(result.sparse.diagonal(i), i, i, 0.5 * Eigen::MatrixXcd::Identity(n, n));
  }
  return result;
}

template <typename Block>
class ConnectionCholeskyOf : public ::testing::Test {};
using Blocks = ::testing::Types<ComplexBlock<1>, ComplexBlock<2>, RealBlock<3>>;
TYPED_TEST_SUITE(ConnectionCholeskyOf, Blocks);

TYPED_TEST(ConnectionCholeskyOf, SolvesAsADenseMatrixDoes) {
  constexpr int n = kSize<TypeParam>;
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    Rng rng(seed);
    const Pairs pairs = random_pairs(25, 20, rng);
    const EliminationPattern pattern = elimination_pattern(25, pairs);
    auto [sparse, matrix] = example<TypeParam>(pattern, pairs, rng);
    ASSERT_TRUE(sparse.factorise());
    std::vector<typename TypeParam::Values> b(25);
    Eigen::VectorXcd dense_b(25 * n);
    for (std::size_t i = 0; i < b.size(); ++i) {
      for (int k = 0; k < n; ++k) {
        const std::complex<double> value(rng.normal(), kIsReal<TypeParam> ? 0.0 : rng.normal());
        b[i](k, 0) = value.real();
        if constexpr (!kIsReal<TypeParam>) b[i](k, 1) = value.imag();
        dense_b(n * static_cast<int>(i) + k) = value;
      }
    }
    sparse.solve_in_place(b);
    const Eigen::VectorXcd expected = matrix.llt().solve(dense_b);
    for (std::size_t i = 0; i < b.size(); ++i) {
      for (int k = 0; k < n; ++k) {
        const std::complex<double> wanted = expected(n * static_cast<int>(i) + k);
        EXPECT_NEAR(b[i](k, 0), wanted.real(), 1e-9);
        if constexpr (!kIsReal<TypeParam>) {
          EXPECT_NEAR(b[i](k, 1), wanted.imag(), 1e-9);
        }
      }
    }
  }
}

TYPED_TEST(ConnectionCholeskyOf, TellsWhatIsNotPositiveDefinite) {
  Rng rng(7);
  const Pairs pairs = random_pairs(12, 8, rng);
  const EliminationPattern pattern = elimination_pattern(12, pairs);
  for (int place = 0; place < 12; ++place) {
    auto sparse = example<TypeParam>(pattern, pairs, rng).sparse;
    sparse.diagonal(place).re(kSize<TypeParam> - 1, kSize<TypeParam> - 1) -= 100.0;
    EXPECT_FALSE(sparse.factorise()) << place;
  }
}

}  // namespace
}  // namespace loopstone
