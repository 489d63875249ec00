#include "slam/robust_fit.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <vector>

#include "loopstone/base/median.hpp"
#include "loopstone/slam/calibration.hpp"

namespace loopstone {

namespace {

/// Fewer observations of a stretch say nothing of its own.
constexpr Eigen::Index kFewestOfBlock = 15;

/// Of each kind of row.
Eigen::VectorXd noise_of(const Eigen::VectorXd& residuals, Eigen::Index kinds) {
  Eigen::VectorXd noise(kinds);
  for (Eigen::Index kind = 0; kind < kinds; ++kind) {
    std::vector<double> sizes;
    for (Eigen::Index i = kind; i < residuals.size(); i += kinds)
      sizes.push_back(std::abs(residuals[i]));
    noise[kind] = std::max(kSigmaPerMedian * median_of(sizes), kCalibration.noise_floor);
  }
  return noise;
}

Eigen::VectorXd weights_of(const Eigen::VectorXd& residuals, const Eigen::VectorXd& noise) {
  Eigen::VectorXd weights(residuals.size());
  for (Eigen::Index i = 0; i < residuals.size(); ++i) {
    const double sigma = noise[i % noise.size()];
    const double far = residuals[i] / (sigma * kCalibration.outlier_sigmas);
    const double root = 1.0 / (1.0 + far * far);
    weights[i] = root * root / (sigma * sigma);
  }
  return weights;
}

/// Sum of the scores' products, neighbours' too, by Bartlett's weights.
Eigen::MatrixXd meat_of(const LinearProblem& problem, const Eigen::VectorXd& weighted) {
  const Eigen::Index count = problem.observations();
  Eigen::MatrixXd scores = Eigen::MatrixXd::Zero(count, problem.a.cols());
  for (Eigen::Index i = 0; i < weighted.size(); ++i)
    scores.row(i / problem.kinds) += weighted[i] * problem.a.row(i);
  // Sums in order; blocks, which a plain product takes of a long matrix, depend on the processor.
  Eigen::MatrixXd meat = scores.transpose().lazyProduct(scores);
  const Eigen::Index lags = std::min<Eigen::Index>(kCalibration.lags, count);
  for (Eigen::Index lag = 1; lag < lags; ++lag) {
    const Eigen::MatrixXd product =
        scores.bottomRows(count - lag).transpose().lazyProduct(scores.topRows(count - lag));
    const double share = 1.0 - static_cast<double>(lag) / static_cast<double>(lags);
    meat += share * (product + product.transpose());
  }
  return meat;
}

}  // namespace

LinearProblem LinearProblem::part(Eigen::Index first, Eigen::Index count) const {
  return {a.middleRows(first * kinds, count * kinds), y.segment(first * kinds, count * kinds),
          kinds, prior, prior_sigma};
}

LinearFit robust_fit(const LinearProblem& problem) {
  const Eigen::VectorXd prior_information = problem.prior_sigma.array().square().inverse();
  LinearFit fit{.x = problem.prior};
  Eigen::VectorXd weights = Eigen::VectorXd::Ones(problem.y.size());
  Eigen::MatrixXd information;
  for (int pass = 0; pass < kCalibration.passes; ++pass) {
    information = problem.a.transpose().lazyProduct(weights.asDiagonal() * problem.a);
    information.diagonal() += prior_information;
    const Eigen::VectorXd right = problem.a.transpose() * weights.cwiseProduct(problem.y) +
                                  prior_information.cwiseProduct(problem.prior);
    fit.x = information.ldlt().solve(right);
    fit.residuals = problem.y - problem.a * fit.x;
    weights = weights_of(fit.residuals, noise_of(fit.residuals, problem.kinds));
  }
  information = problem.a.transpose().lazyProduct(weights.asDiagonal() * problem.a);
  information.diagonal() += prior_information;
  const Eigen::MatrixXd bread = information.inverse();
  Eigen::MatrixXd meat = meat_of(problem, weights.cwiseProduct(fit.residuals));
  meat.diagonal() += prior_information;
  fit.covariance = bread * meat * bread;
  return fit;
}

Eigen::VectorXd scatter_of_blocks(const LinearProblem& problem, int blocks) {
  const Eigen::Index size = problem.a.cols();
  const Eigen::Index count =
      std::min<Eigen::Index>(blocks, problem.observations() / kFewestOfBlock);
  Eigen::VectorXd factors = Eigen::VectorXd::Ones(size);
  if (count < 2) return factors;
  Eigen::MatrixXd values(size, count);
  Eigen::MatrixXd information(size, count);
  for (Eigen::Index block = 0; block < count; ++block) {
    const Eigen::Index first = block * problem.observations() / count;
    const Eigen::Index end = (block + 1) * problem.observations() / count;
    const LinearFit fit = robust_fit(problem.part(first, end - first));
    values.col(block) = fit.x;
    information.col(block) = fit.covariance.diagonal().cwiseInverse();
  }
  for (Eigen::Index i = 0; i < size; ++i) {
    const double mean = values.row(i).dot(information.row(i)) / information.row(i).sum();
    const double chi2 =
        ((values.row(i).array() - mean).square() * information.row(i).array()).sum();
    factors[i] = std::max(1.0, std::sqrt(chi2 / static_cast<double>(count - 1)));
  }
  return factors;
}

}  // namespace loopstone
