#pragma once

#include <Eigen/Core>

namespace loopstone {

/// y = A x + noise, with outliers: `kinds` rows follow from each observation, and each kind has a
/// noise of its own.
struct LinearProblem {
  Eigen::MatrixXd a{};
  Eigen::VectorXd y{};
  Eigen::Index kinds = 1;
  Eigen::VectorXd prior{};        ///< of x; weak, for what the data leave open
  Eigen::VectorXd prior_sigma{};  ///< its standard deviations

  [[nodiscard]] Eigen::Index observations() const { return y.size() / kinds; }
  /// Those of so many observations.
  [[nodiscard]] LinearProblem part(Eigen::Index first, Eigen::Index count) const;
};

struct LinearFit {
  Eigen::VectorXd x{};
  Eigen::MatrixXd covariance{};
  Eigen::VectorXd residuals{};
};

/// Least squares by Geman and McClure's weights, the noise by the residuals' median. The covariance
/// is the sandwich's with neighbours that share errors (Newey and West 1987), and the prior's where
/// the data are silent. Observations in the order in which they were made.
[[nodiscard]] LinearFit robust_fit(const LinearProblem& problem);

/// By how much the results of `blocks` stretches scatter beyond their covariances: for each entry
/// of x a factor of its standard deviation, 1 at least. (Birge 1932.)
[[nodiscard]] Eigen::VectorXd scatter_of_blocks(const LinearProblem& problem, int blocks);

}  // namespace loopstone
