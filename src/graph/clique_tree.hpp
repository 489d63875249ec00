#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "graph/front_kernels.hpp"
#include "graph/front_tree.hpp"

namespace loopstone {

/// A linearised edge between two variables, or on one (then second is -1): its share of H and of
/// the gradient.
struct LinearFactor {
  int first = -1;
  int second = -1;
  Eigen::Matrix3d first_first = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d first_second = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d second_second = Eigen::Matrix3d::Zero();
  Eigen::Vector3d gradient_first = Eigen::Vector3d::Zero();
  Eigen::Vector3d gradient_second = Eigen::Vector3d::Zero();
};

/// The factor of H delta = -gradient as a tree of dense fronts that can be changed from the root
/// down. Each front keeps what it hands to its parent, so that the fronts below a change are not
/// looked at.
/// Source: Kaess et al. 2012, "iSAM2", algorithms 4 to 7.
class CliqueTree {
 public:
  struct Result {
    bool solved = true;  ///< false: not positive definite; the tree is unusable
    std::size_t eliminated = 0;
    std::vector<int> changed;  ///< variables whose delta is another now
  };

  /// Forgets everything.
  void clear();
  void resize(std::size_t variables);

  /// Eliminates anew the variables touched (with all that depend on them), and those of no clique
  /// yet, `newest` last; then finds their deltas and passes them on.
  /// \param factors_of  the factors of each variable
  Result update(std::span<const int> touched, int newest, std::span<const LinearFactor> factors,
                const std::vector<std::vector<int>>& factors_of, double negligible,
                std::size_t most);
  /// Finds the deltas of the variables below those whose deltas changed, leaving out changes below
  /// `negligible`; after about `most` variables the rest is left to the next call. Returns the
  /// variables.
  std::vector<int> pass_on(double negligible, std::size_t most);

  [[nodiscard]] const std::vector<Eigen::Vector3d>& delta() const { return delta_; }
  /// For a variable that is linearised anew; it must be touched by the next update.
  void reset_delta(int variable) {
    delta_[static_cast<std::size_t>(variable)].setZero();
    passed_on_[static_cast<std::size_t>(variable)].setZero();
  }

 private:
  struct Clique {
    std::vector<int> pivots;  ///< variables
    std::vector<int> rows;    ///< variables below the pivots
    int parent = -1;
    std::vector<int> children;
    std::vector<double>
        values;  ///< panel, update, inverse diagonal, forward solution, what is left for the rows
    bool alive = false;
    bool queued = false;      ///< a delta of its rows may have changed
    std::uint32_t since = 0;  ///< the update from which on changes matter to it

    [[nodiscard]] std::size_t pivot_count() const { return 3 * pivots.size(); }
    [[nodiscard]] std::size_t below_count() const { return 3 * rows.size(); }
    [[nodiscard]] std::size_t value_count() const;
    [[nodiscard]] DenseFront dense();
    [[nodiscard]] double* forward();    ///< of the pivots
    [[nodiscard]] double* left_over();  ///< right-hand side handed to the rows, padded
  };
  /// Values of cliques that are gone, for new ones of about their size: large pieces of fresh
  /// memory are dear.
  class SpareValues {
   public:
    [[nodiscard]] std::vector<double> zeros(std::size_t count);
    void take_back(std::vector<double> values);

   private:
    struct Shelf {
      std::size_t index = 0;
      std::size_t capacity = 0;
    };
    [[nodiscard]] Shelf shelf(std::size_t count);
    std::vector<std::vector<std::vector<double>>> shelves_;
  };
  /// The variables to eliminate, numbered.
  struct Part {
    std::vector<int> variables;
    std::vector<int> orphans;  ///< cliques that stay, without a parent now
  };
  [[nodiscard]] Part detach(std::span<const int> touched);
  void order(const Part& part, int newest, std::span<const LinearFactor> factors,
             const std::vector<std::vector<int>>& factors_of);
  [[nodiscard]] bool eliminate(const Part& part, std::span<const LinearFactor> factors,
                               const std::vector<std::vector<int>>& factors_of);
  void order_small(const Part& part, int last, std::span<const LinearFactor> factors,
                   const std::vector<std::vector<int>>& factors_of);
  void order_large(const Part& part, int last, std::span<const LinearFactor> factors,
                   const std::vector<std::vector<int>>& factors_of);
  /// The fronts of a part, children before parents.
  struct Layout {
    FrontTree tree;
    std::vector<int> variable_at;              ///< of each place
    std::vector<std::vector<int>> orphans_of;  ///< of each front
  };
  /// Finds the fronts of the part in its order, and renumbers the order as the fronts have it.
  [[nodiscard]] Layout lay_out(const Part& part, std::span<const LinearFactor> factors,
                               const std::vector<std::vector<int>>& factors_of);
  /// An empty clique for a front.
  [[nodiscard]] int begin_clique(const Front& front, const std::vector<int>& variable_at);
  /// Adds to a clique the factors of its pivots, each once.
  void add_factors(int clique, const Front& front, std::span<const LinearFactor> factors,
                   const std::vector<std::vector<int>>& factors_of);
  /// Adds to a clique what is left of a new one below it.
  void add_child(int child, const Front& child_front, int clique);
  /// Adds to a clique what is left of one that stayed.
  void add_orphan(int orphan, int clique, const Front& front);
  /// Where variables stand in the rows of a front.
  [[nodiscard]] std::vector<std::size_t> positions_in(const Front& front,
                                                      const std::vector<int>& variables) const;
  /// Factorises a clique, and leaves for its rows what its pivots say of them. False: not positive
  /// definite.
  [[nodiscard]] bool eliminate_pivots(int clique);
  /// In the order of elimination; of a variable of the part.
  [[nodiscard]] int place_of(int variable) const {
    return order_[static_cast<std::size_t>(local_[static_cast<std::size_t>(variable)])];
  }
  void solve_new_cliques(double negligible, std::vector<int>& changed);
  void queue(int clique, std::uint32_t since);
  void solve_clique(int clique, double negligible, std::vector<int>& changed);
  [[nodiscard]] int new_clique();

  std::vector<Clique> cliques_;
  std::vector<int> free_;
  SpareValues spare_;
  std::vector<int> queue_;  ///< cliques to solve again
  std::size_t next_queued_ = 0;
  std::vector<int> clique_of_;  ///< of each variable, -1: none yet
  std::vector<Eigen::Vector3d> delta_;
  std::vector<Eigen::Vector3d> passed_on_;  ///< deltas that the cliques below were solved with
  std::vector<int> unattached_;             ///< variables of no clique

  // Of the update under way.
  std::vector<int> local_;  ///< number in the part, -1: not in it
  std::vector<int> order_;  ///< place of each number
  std::vector<int> new_cliques_;
  std::vector<std::uint32_t> changed_in_;
  std::uint32_t update_ = 0;
  std::vector<double> below_;
  std::vector<double> x_;
};

}  // namespace loopstone
