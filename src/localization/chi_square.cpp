#include "loopstone/localization/chi_square.hpp"

#include <algorithm>
#include <cmath>

namespace loopstone {

double chi_square_quantile(double degrees_of_freedom, double z_quantile) {
  if (degrees_of_freedom <= 0.0) return 0.0;
  const double spread = 2.0 / (9.0 * degrees_of_freedom);
  const double root = std::max(0.0, 1.0 - spread + z_quantile * std::sqrt(spread));
  return degrees_of_freedom * root * root * root;
}

}  // namespace loopstone
