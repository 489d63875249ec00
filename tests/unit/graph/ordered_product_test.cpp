#include "graph/ordered_product.hpp"

#include <gtest/gtest.h>

#include "loopstone/base/rng.hpp"

namespace loopstone {
namespace {

Eigen::MatrixXd any_matrix(Rng& rng, Eigen::Index rows, Eigen::Index columns) {
  Eigen::MatrixXd result(rows, columns);
  for (double& value : result.reshaped()) value = rng.uniform(-1.0, 1.0);
  return result;
}

TEST(OrderedProduct, IsTheProduct) {
  Rng rng(1);
  for (const Eigen::Index length : {1, 3, 4, 7, 130}) {
    const Eigen::MatrixXd a = any_matrix(rng, 9, length);
    const Eigen::MatrixXd b = any_matrix(rng, length, 5);
    const Eigen::MatrixXd before = any_matrix(rng, 9, 5);
    Eigen::MatrixXd sums = before;
    add_product(sums, a, b, -1.0);
    EXPECT_TRUE(sums.isApprox(before - a * b, 1e-12)) << length;
  }
}

TEST(OrderedProduct, OfARowDependsOnNoOther) {
  Rng rng(2);
  const Eigen::MatrixXd a = any_matrix(rng, 11, 600);
  const Eigen::MatrixXd b = any_matrix(rng, 600, 2);
  Eigen::MatrixXd all = Eigen::MatrixXd::Zero(11, 2);
  add_product(all, a, b, 1.0);
  for (Eigen::Index row = 0; row < a.rows(); ++row) {
    Eigen::MatrixXd one = Eigen::MatrixXd::Zero(1, 2);
    add_product(one, a.row(row), b, 1.0);
    EXPECT_EQ(one, all.row(row));
  }
}

TEST(OrderedProduct, InvertsALowerTriangle) {
  Rng rng(3);
  for (const Eigen::Index size : {1, 3, 6, 40}) {
    Eigen::MatrixXd a = any_matrix(rng, size, size);
    a.diagonal().array() += 3.0;
    const Eigen::MatrixXd lower = a.triangularView<Eigen::Lower>();
    const Eigen::MatrixXd inverse = inverse_of_lower(a);
    EXPECT_TRUE((lower * inverse).isIdentity(1e-9)) << size;
    EXPECT_TRUE(inverse.isLowerTriangular());
  }
}

}  // namespace
}  // namespace loopstone
