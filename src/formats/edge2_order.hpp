#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "loopstone/formats/g2o.hpp"

namespace loopstone {

/// Six numbers of an information matrix, as a line has them.
using InformationNumbers = std::array<double, 6>;

/// `order` is not kGuess.
[[nodiscard]] Eigen::Matrix3d information_from(const InformationNumbers& v, InformationOrder order);

/// By the pivots of a Cholesky factorisation.
[[nodiscard]] bool is_positive_definite(const Eigen::Matrix3d& matrix);

struct OrderGuess {
  InformationOrder order = InformationOrder::kToro;
  std::string reason;  ///< for the user
};

/// The order in which EDGE2 lines give their information: the one in which all of them are positive
/// definite; when both or neither are, the one that leaves heading and position uncorrelated; else
/// TORO's, which the tag is of.
[[nodiscard]] OrderGuess guess_edge2_order(const std::vector<InformationNumbers>& edges);

}  // namespace loopstone
