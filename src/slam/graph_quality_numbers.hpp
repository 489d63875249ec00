#pragma once

namespace loopstone {

/// What the graph's judgement decides by.
struct GraphQualityNumbers {
  int most_nodes = 20000;
  int most_rank = 2;
  double open_share = 0.01;
  double open_chi2 = 1.0;
};
inline constexpr GraphQualityNumbers kGraphQuality{};

template <typename Visitor>
void visit_numbers(const GraphQualityNumbers& n, Visitor&& visit) {
  visit("most_nodes", n.most_nodes,
        "chosen: a certificate is an answer within a fraction of a second up to about this size");
  visit("most_rank", n.most_rank,
        "chosen: one way out of a local minimum; a judgement may take less time than a solution");
  visit("open_share", n.open_share,
        "derived: chi-square of n loops varies by sqrt(2 / 3n), 5 % of 300 loops; a solution that "
        "is better by less says the same of the edges");
  visit("open_chi2", n.open_chi2,
        "chosen: so much of chi-square is one edge one standard deviation off; a solution that is "
        "better by less is no other one");
}

}  // namespace loopstone
