#include "loopstone/registration/correlative_search.hpp"

#include "registration/lattice_search.hpp"

namespace loopstone {

SearchResult search_branch_and_bound(std::span<const Eigen::Vector2d> source,
                                     const MaxPyramid& target, const SearchWindow& window,
                                     double min_score,
                                     const std::optional<ExcludedPoses>& excluded) {
  if (source.empty()) return {};
  return LatticeSearch(source, target, window).best(min_score, excluded);
}

}  // namespace loopstone
