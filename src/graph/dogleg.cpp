#include "graph/dogleg.hpp"

#include <algorithm>
#include <cmath>

namespace loopstone {

namespace {

using Steps = std::span<const Eigen::Vector3d>;

/// a^T H b.
double product(const BlockMatrix& h, Steps a, Steps b) {
  double sum = 0.0;
  for (std::size_t j = 0; j < a.size(); ++j) {
    sum += a[j].dot(h.diagonal[j] * b[j]);
    for (int p = h.column_start[j]; p < h.column_start[j + 1]; ++p) {
      const auto i = static_cast<std::size_t>(h.rows[static_cast<std::size_t>(p)]);
      const Eigen::Matrix3d& block = h.below[static_cast<std::size_t>(p)];
      sum += a[i].dot(block * b[j]) + b[i].dot(block * a[j]);
    }
  }
  return sum;
}

/// a^T diag(H) b.
double scaled_dot(const BlockMatrix& h, Steps a, Steps b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    sum += a[i].dot(h.diagonal[i].diagonal().cwiseProduct(b[i]));
  }
  return sum;
}

double dot(Steps a, Steps b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i].dot(b[i]);
  return sum;
}

}  // namespace

void Dogleg::linearise(const NormalEquations& equations,
                       std::span<const Eigen::Vector3d> newton_step) {
  const BlockMatrix& h = equations.hessian();
  const auto& gradient = equations.gradient();
  newton_.assign(newton_step.begin(), newton_step.end());
  cauchy_.resize(gradient.size());
  for (std::size_t i = 0; i < gradient.size(); ++i) {
    cauchy_[i] = -gradient[i].cwiseQuotient(h.diagonal[i].diagonal());
  }
  const double slope = dot(gradient, cauchy_);
  const double bend = product(h, cauchy_, cauchy_);
  const double length = bend > 0.0 ? -slope / bend : 0.0;
  for (Eigen::Vector3d& step : cauchy_) step *= length;

  newton_length_ = std::sqrt(scaled_dot(h, newton_, newton_));
  cauchy_length_ = std::sqrt(scaled_dot(h, cauchy_, cauchy_));
  dot_ = scaled_dot(h, newton_, cauchy_);
  gradient_newton_ = dot(gradient, newton_);
  gradient_cauchy_ = dot(gradient, cauchy_);
  curvature_newton_ = product(h, newton_, newton_);
  curvature_cauchy_ = product(h, cauchy_, cauchy_);
  curvature_both_ = product(h, newton_, cauchy_);
}

double Dogleg::choose_step(std::span<Eigen::Vector3d> step) {
  // step = a * newton + b * cauchy.
  double a = 1.0;
  double b = 0.0;
  is_newton_step_ = newton_length_ <= radius_;
  if (!is_newton_step_ && cauchy_length_ >= radius_) {
    a = 0.0;
    b = radius_ / cauchy_length_;
  } else if (!is_newton_step_) {
    // |cauchy + a (newton - cauchy)| = radius.
    const double square =
        newton_length_ * newton_length_ - 2.0 * dot_ + cauchy_length_ * cauchy_length_;
    const double half = dot_ - cauchy_length_ * cauchy_length_;
    const double rest = radius_ * radius_ - cauchy_length_ * cauchy_length_;
    a = std::clamp((-half + std::sqrt(std::max(half * half + square * rest, 0.0))) / square, 0.0,
                   1.0);
    b = 1.0 - a;
  }
  step_length_ = std::min(radius_, newton_length_);
  for (std::size_t i = 0; i < step.size(); ++i) step[i] = a * newton_[i] + b * cauchy_[i];
  return -2.0 * (a * gradient_newton_ + b * gradient_cauchy_) - a * a * curvature_newton_ -
         2.0 * a * b * curvature_both_ - b * b * curvature_cauchy_;
}

void Dogleg::adapt(double gain) {
  if (gain > 0.75) {
    radius_ = std::max(radius_, 3.0 * step_length_);
  } else if (!(gain > 0.25)) {
    radius_ = 0.25 * step_length_;
  }
}

}  // namespace loopstone
