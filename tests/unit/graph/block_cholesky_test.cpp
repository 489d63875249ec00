#include "graph/block_cholesky.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <numeric>

#include "graph/selected_inverse.hpp"
#include "loopstone/base/rng.hpp"

namespace loopstone {
namespace {

using Pairs = std::vector<std::pair<int, int>>;

Pairs random_pairs(int size, int count, Rng& rng) {
  Pairs pairs;
  for (int i = 0; i < count; ++i) {
    const int a = static_cast<int>(rng.below(static_cast<std::uint64_t>(size)));
    const int b = static_cast<int>(rng.below(static_cast<std::uint64_t>(size)));
    if (a != b) pairs.emplace_back(a, b);
  }
  return pairs;
}

/// Random blocks, diagonally dominant.
BlockMatrix random_matrix(int size, const Pairs& pairs, Rng& rng) {
  BlockMatrix matrix = block_matrix(size, pairs);
  const auto random_block = [&rng] {
    Eigen::Matrix3d block;
    for (int i = 0; i < 9; ++i) block(i) = rng.uniform(-1.0, 1.0);
    return block;
  };
  for (Eigen::Matrix3d& block : matrix.below) block = random_block();
  for (Eigen::Matrix3d& block : matrix.diagonal) {
    const Eigen::Matrix3d a = random_block();
    block = a * a.transpose() + 3.0 * static_cast<double>(size) * Eigen::Matrix3d::Identity();
  }
  return matrix;
}

Eigen::MatrixXd dense(const BlockMatrix& matrix, double damping = 0.0) {
  const auto size = static_cast<Eigen::Index>(matrix.diagonal.size());
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(3 * size, 3 * size);
  for (Eigen::Index j = 0; j < size; ++j) {
    const auto column = static_cast<std::size_t>(j);
    result.block<3, 3>(3 * j, 3 * j) = matrix.diagonal[column];
    for (int p = matrix.column_start[column]; p < matrix.column_start[column + 1]; ++p) {
      const auto i = static_cast<std::size_t>(p);
      result.block<3, 3>(3 * matrix.rows[i], 3 * j) = matrix.below[i];
      result.block<3, 3>(3 * j, 3 * matrix.rows[i]) = matrix.below[i].transpose();
    }
  }
  result.diagonal() *= 1.0 + damping;
  return result;
}

TEST(BlockCholesky, SolvesWhatADenseSolverSolves) {
  Rng rng(11);
  for (const int size : {1, 2, 3, 8, 40}) {
    for (const double damping : {0.0, 0.3}) {
      const BlockMatrix matrix = random_matrix(size, random_pairs(size, 2 * size, rng), rng);
      std::vector<Eigen::Vector3d> b(static_cast<std::size_t>(size));
      Eigen::VectorXd b_dense(3 * size);
      for (int i = 0; i < size; ++i) {
        for (int k = 0; k < 3; ++k) b_dense(3 * i + k) = rng.uniform(-1.0, 1.0);
        b[static_cast<std::size_t>(i)] = b_dense.segment<3>(3 * i);
      }
      BlockCholesky cholesky(matrix);
      ASSERT_TRUE(cholesky.factorise(matrix, damping));
      const auto x = cholesky.solve(b);
      const Eigen::VectorXd expected = dense(matrix, damping).llt().solve(b_dense);
      for (int i = 0; i < size; ++i) {
        EXPECT_LT((x[static_cast<std::size_t>(i)] - expected.segment<3>(3 * i)).norm(), 1e-12);
      }
    }
  }
}

TEST(BlockCholesky, FactorisesOtherValuesOfTheSamePattern) {
  Rng rng(12);
  const Pairs pairs = random_pairs(20, 40, rng);
  const BlockMatrix first = random_matrix(20, pairs, rng);
  const BlockMatrix second = random_matrix(20, pairs, rng);
  const std::vector<Eigen::Vector3d> b(20, Eigen::Vector3d(1.0, 2.0, 3.0));
  BlockCholesky reused(first);
  ASSERT_TRUE(reused.factorise(first, 0.0));
  ASSERT_TRUE(reused.factorise(second, 0.0));
  BlockCholesky fresh(second);
  ASSERT_TRUE(fresh.factorise(second, 0.0));
  EXPECT_EQ(reused.solve(b), fresh.solve(b));
}

TEST(BlockCholesky, ProductsThroughTheInverseAreThoseOfTheDenseInverse) {
  Rng rng(14);
  for (const int size : {1, 2, 9, 50}) {
    const BlockMatrix matrix = random_matrix(size, random_pairs(size, size, rng), rng);
    BlockCholesky cholesky(matrix);
    ASSERT_TRUE(cholesky.factorise(matrix, 0.0));
    const Eigen::MatrixXd inverse = dense(matrix).inverse();
    for (int trial = 0; trial < 20; ++trial) {
      Eigen::MatrixXd j = Eigen::MatrixXd::Zero(3, 3 * size);
      std::vector<BlockCholesky::RowsAt> rows;
      for (int k = 0; k < 2; ++k) {  // the same block twice adds up
        const int block = static_cast<int>(rng.below(static_cast<std::uint64_t>(size)));
        Eigen::Matrix3d values;
        for (int i = 0; i < 9; ++i) values(i) = rng.uniform(-1.0, 1.0);
        rows.push_back({block, values});
        j.middleCols<3>(3 * block) += values;
      }
      const Eigen::Matrix3d expected = j * inverse * j.transpose();
      EXPECT_LT((cholesky.through_inverse(rows) - expected).norm(), 1e-14);
    }
  }
}

TEST(BlockCholesky, ColoursNoiseAsTheInverseSays) {
  Rng rng(16);
  for (const int size : {1, 2, 9, 50}) {
    const BlockMatrix matrix = random_matrix(size, random_pairs(size, size, rng), rng);
    BlockCholesky cholesky(matrix);
    ASSERT_TRUE(cholesky.factorise(matrix, 0.0));
    // C C^T with each column what becomes of one unit of noise.
    Eigen::MatrixXd colour(3 * size, 3 * size);
    for (Eigen::Index column = 0; column < colour.cols(); ++column) {
      std::vector<Eigen::Vector3d> z(static_cast<std::size_t>(size), Eigen::Vector3d::Zero());
      z[static_cast<std::size_t>(column / 3)][column % 3] = 1.0;
      cholesky.colour_in_place(z);
      for (int i = 0; i < size; ++i)
        colour.col(column).segment<3>(3 * i) = z[static_cast<std::size_t>(i)];
    }
    const Eigen::MatrixXd inverse = dense(matrix).inverse();
    EXPECT_LT((colour * colour.transpose() - inverse).norm(), 1e-12 * inverse.norm());
  }
}

TEST(SelectedInverse, IsTheDenseInverseWithinThePattern) {
  Rng rng(15);
  for (const int size : {1, 2, 9, 30, 80}) {
    const Pairs pairs = random_pairs(size, size + size / 2, rng);
    const BlockMatrix matrix = random_matrix(size, pairs, rng);
    BlockCholesky cholesky(matrix);
    ASSERT_TRUE(cholesky.factorise(matrix, 0.0));
    const SelectedInverse selected(cholesky);
    const Eigen::MatrixXd inverse = dense(matrix).inverse();
    for (int i = 0; i < size; ++i) {
      EXPECT_LT((selected.block(i, i) - inverse.block<3, 3>(3 * i, 3 * i)).norm(), 1e-14);
    }
    for (const auto& [a, b] : pairs) {
      EXPECT_LT((selected.block(a, b) - inverse.block<3, 3>(3 * a, 3 * b)).norm(), 1e-14);
      EXPECT_LT((selected.block(b, a) - inverse.block<3, 3>(3 * b, 3 * a)).norm(), 1e-14);
    }
  }
}

TEST(BlockCholesky, RefusesWhatIsNotPositiveDefinite) {
  Rng rng(13);
  for (int wrong = 0; wrong < 6; ++wrong) {
    BlockMatrix matrix = random_matrix(6, random_pairs(6, 10, rng), rng);
    matrix.diagonal[static_cast<std::size_t>(wrong)](2, 2) = -1.0;
    BlockCholesky cholesky(matrix);
    EXPECT_FALSE(cholesky.factorise(matrix, 0.0));
  }
  BlockMatrix matrix = random_matrix(3, {}, rng);
  matrix.diagonal[1](0, 0) = std::numeric_limits<double>::quiet_NaN();
  BlockCholesky cholesky(matrix);
  EXPECT_FALSE(cholesky.factorise(matrix, 0.0));
}

TEST(FillReducingOrder, IsAPermutation) {
  Rng rng(14);
  std::vector<int> order = fill_reducing_order(50, random_pairs(50, 100, rng));
  std::sort(order.begin(), order.end());
  std::vector<int> expected(50);
  std::iota(expected.begin(), expected.end(), 0);
  EXPECT_EQ(order, expected);
}

TEST(FillReducingOrder, LeavesAStarWithoutFill) {
  // Eliminating the hub first would join all the others.
  Pairs pairs;
  for (int i = 1; i < 30; ++i) pairs.emplace_back(0, i);
  const std::vector<int> order = fill_reducing_order(30, pairs);
  for (auto& [a, b] : pairs) {
    a = order[static_cast<std::size_t>(a)];
    b = order[static_cast<std::size_t>(b)];
  }
  // Some more for zeros of merged supernodes; the worst order has 435.
  EXPECT_LT(BlockCholesky(block_matrix(30, pairs)).fill(), 60U);
}

}  // namespace
}  // namespace loopstone
