#include "loopstone/base/error_function.hpp"

#include <cmath>
#include <cstddef>
#include <numbers>

namespace loopstone {
namespace {

/// Numerator and denominator of a quotient of polynomials, highest powers first.
template <std::size_t N, std::size_t D>
struct Quotient {
  double above[N];
  double below[D];

  [[nodiscard]] double at(double x) const {
    double numerator = 0.0;
    for (const double factor : above) numerator = numerator * x + factor;
    double denominator = 0.0;
    for (const double factor : below) denominator = denominator * x + factor;
    return numerator / denominator;
  }
};

// Cody 1969, tables II to IV: the least errors among quotients of these degrees.
constexpr double kSmall = 0.46875;
constexpr double kMiddle = 4.0;
constexpr double kNothingLeft = 26.6;  // beyond, erfc is less than the smallest normal number

/// erf(x) / x by x^2, up to kSmall.
constexpr Quotient<5, 5> kNearZero{
    {1.85777706184603153e-1, 3.16112374387056560e0, 1.13864154151050156e2, 3.77485237685302021e2,
     3.20937758913846947e3},
    {1.0, 2.36012909523441209e1, 2.44024637934444173e2, 1.28261652607737228e3,
     2.84423683343917062e3}};

/// erfc(x) exp(x^2) by x, up to kMiddle.
constexpr Quotient<9, 9> kNearOne{
    {2.15311535474403846e-8, 5.64188496988670089e-1, 8.88314979438837594e0, 6.61191906371416295e1,
     2.98635138197400131e2, 8.81952221241769090e2, 1.71204761263407058e3, 2.05107837782607147e3,
     1.23033935479799725e3},
    {1.0, 1.57449261107098347e1, 1.17693950891312499e2, 5.37181101862009858e2,
     1.62138957456669019e3, 3.29079923573345963e3, 4.36261909014324716e3, 3.43936767414372164e3,
     1.23033935480374942e3}};

/// What 1 / sqrt(pi) has to lose, over 1 / x^2, by 1 / x^2: x exp(x^2) erfc(x) beyond kMiddle.
constexpr Quotient<6, 6> kFarAway{
    {1.63153871373020978e-2, 3.05326634961232344e-1, 3.60344899949804439e-1, 1.25781726111229246e-1,
     1.60837851487422766e-2, 6.58749161529837803e-4},
    {1.0, 2.56852019228982242e0, 1.87295284992346047e0, 5.27905102951428412e-1,
     6.05183413124413191e-2, 2.33520497626869185e-3}};

/// exp(-x^2), whose exponent is split so that x^2 loses nothing to rounding.
double exp_of_minus_square(double x) {
  const double coarse = std::trunc(x * 16.0) / 16.0;
  return std::exp(-coarse * coarse) * std::exp(-(x - coarse) * (x + coarse));
}

/// erfc(x) for x > kSmall.
double tail(double x) {
  if (x > kNothingLeft) return 0.0;
  if (x <= kMiddle) return exp_of_minus_square(x) * kNearOne.at(x);
  const double square = 1.0 / (x * x);
  const double share = std::numbers::inv_sqrtpi - square * kFarAway.at(square);
  return exp_of_minus_square(x) * share / x;
}

}  // namespace

double error_function(double x) {
  if (std::abs(x) <= kSmall) return x * kNearZero.at(x * x);
  if (std::isnan(x)) return x;
  return std::copysign(1.0 - tail(std::abs(x)), x);
}

double complementary_error_function(double x) {
  if (std::abs(x) <= kSmall) return 1.0 - error_function(x);
  if (std::isnan(x)) return x;
  return x > 0.0 ? tail(x) : 2.0 - tail(-x);
}

}  // namespace loopstone
