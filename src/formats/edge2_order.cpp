#include "formats/edge2_order.hpp"

#include <algorithm>

namespace loopstone {

Eigen::Matrix3d information_from(const InformationNumbers& v, InformationOrder order) {
  Eigen::Matrix3d information;
  if (order == InformationOrder::kToro) {
    information << v[0], v[1], v[4],  //
        v[1], v[2], v[5],             //
        v[4], v[5], v[3];
  } else {
    information << v[0], v[1], v[2],  //
        v[1], v[3], v[4],             //
        v[2], v[4], v[5];
  }
  return information;
}

bool is_positive_definite(const Eigen::Matrix3d& m) {
  const double pivot1 = m(0, 0);
  const double pivot2 = m(1, 1) - m(0, 1) * m(0, 1) / pivot1;
  const double rest = m(1, 2) - m(0, 1) * m(0, 2) / pivot1;
  const double pivot3 = m(2, 2) - m(0, 2) * m(0, 2) / pivot1 - rest * rest / pivot2;
  return pivot1 > 0.0 && pivot2 > 0.0 && pivot3 > 0.0;
}

OrderGuess guess_edge2_order(const std::vector<InformationNumbers>& edges) {
  const auto all = [&edges](auto&& holds) {
    return std::all_of(edges.begin(), edges.end(), holds);
  };
  const auto definite_as = [&](InformationOrder order) {
    return all([order](const InformationNumbers& v) {
      return is_positive_definite(information_from(v, order));
    });
  };
  const bool toro = definite_as(InformationOrder::kToro);
  const bool g2o = definite_as(InformationOrder::kG2o);
  constexpr const char* kToroOrder = "xx xy yy tt xt yt (TORO's order)";
  constexpr const char* kG2oOrder = "xx xy xt yy yt tt (g2o's order)";
  const auto reads = [](const char* order, const char* why) {
    return std::string("EDGE2: the information is read as ") + order + ": " + why;
  };
  if (toro != g2o) {
    return {toro ? InformationOrder::kToro : InformationOrder::kG2o,
            reads(toro ? kToroOrder : kG2oOrder,
                  "in the other order not every matrix would be positive definite")};
  }
  const bool toro_uncorrelated =
      all([](const InformationNumbers& v) { return v[4] == 0.0 && v[5] == 0.0; });
  const bool g2o_uncorrelated =
      all([](const InformationNumbers& v) { return v[2] == 0.0 && v[4] == 0.0; });
  if (toro_uncorrelated != g2o_uncorrelated) {
    return {toro_uncorrelated ? InformationOrder::kToro : InformationOrder::kG2o,
            reads(toro_uncorrelated ? kToroOrder : kG2oOrder,
                  "that leaves heading and position uncorrelated")};
  }
  return {InformationOrder::kToro,
          reads(kToroOrder, "nothing in the numbers tells; if it is wrong, name the order")};
}

}  // namespace loopstone
