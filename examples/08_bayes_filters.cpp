// The same corridor for both Bayes filters, and what the resampling schemes differ in.
// docs/bayes_filters.md shows these lines.
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "loopstone/localization/histogram_filter.hpp"
#include "loopstone/localization/renewal.hpp"

using namespace loopstone;

namespace {

// A corridor of 10 m that closes on itself, with three doors.
bool is_door(double x_m) {
  return std::abs(x_m - 2.0) < 0.3 || std::abs(x_m - 3.5) < 0.3 || std::abs(x_m - 7.5) < 0.3;
}

double chance_near(const HistogramFilter& belief, int cell) {
  double sum = 0.0;
  for (int i = cell - 4; i <= cell + 4; ++i) sum += belief.probability({i, 0});
  return sum;
}

double histogram_filter() {
  // [histogram filter]
  HistogramFilter belief({.columns = 100, .column_edge = GridEdge::kRing});  // cells of 0.1 m
  const auto sees_door = [](Cell cell) { return is_door(0.1 * cell.column) ? 0.8 : 0.1; };
  (void)belief.update(sees_door);
  belief.predict(normal_kernel(15.0, 1.0));  // 1.5 m, give or take 0.1 m
  const double evidence = belief.update(sees_door);
  // [end]
  std::printf("histogram filter: evidence of the second door %.3f, at the middle door with %.3f\n",
              evidence, chance_near(belief, 35));
  return chance_near(belief, 35);
}

double particle_filter() {
  // [particle filter]
  Rng rng(1);
  std::vector<double> anywhere(5000);
  for (double& x_m : anywhere) x_m = rng.uniform(0.0, 10.0);
  ParticleFilter<double> filter(anywhere);
  const auto stay = [](double x_m, Rng&) { return x_m; };
  const auto drive = [](double x_m, Rng& noise) {
    return std::fmod(x_m + noise.normal(1.5, 0.1), 10.0);
  };
  const auto sees_door = [](double x_m) { return std::log(is_door(x_m) ? 0.8 : 0.1); };
  (void)filter_step(filter, stay, sees_door, Renewal<double>{}, rng);
  const FilterStep step = filter_step(filter, drive, sees_door, Renewal<double>{}, rng);
  // [end]
  double near = 0.0;
  for (std::size_t i = 0; i < filter.size(); ++i) {
    if (std::abs(filter.states()[i] - 3.5) < 0.45) near += std::exp(filter.log_weights()[i]);
  }
  std::printf(
      "particle filter:  evidence of the second door %.3f, at the middle door with %.3f\n\n",
      std::exp(step.log_evidence), near);
  return near;
}

/// How far the mean of the particles strays from that of the weights, by resampling alone.
double stray(ResamplingScheme scheme, std::size_t particles) {
  Rng rng(2);
  constexpr int kDraws = 4000;
  double sum = 0.0;
  for (int draw = 0; draw < kDraws; ++draw) {
    std::vector<double> weights(particles);
    std::vector<double> states(particles);
    double total = 0.0;
    double mean = 0.0;
    for (std::size_t i = 0; i < particles; ++i) {
      states[i] = rng.normal();
      weights[i] = std::exp(-2.0 * (states[i] - 1.0) * (states[i] - 1.0));
      total += weights[i];
      mean += weights[i] * states[i];
    }
    double resampled = 0.0;
    for (const std::size_t index : resample_indices(scheme, weights, particles, rng))
      resampled += states[index];
    sum += std::pow(resampled / static_cast<double>(particles) - mean / total, 2);
  }
  return std::sqrt(sum / kDraws);
}

}  // namespace

int main() {
  const bool agree = std::abs(histogram_filter() - particle_filter()) < 0.05;
  std::printf("rms error that resampling adds to the mean\nparticles ");
  for (const std::string_view word : kWords<ResamplingScheme>) std::printf("%13s", word.data());
  for (const std::size_t particles : {10, 100, 1000}) {
    std::printf("\n%9zu ", particles);
    for (const auto& [scheme, word] : kWordTable<ResamplingScheme>)
      std::printf("%13.4f", stray(scheme, particles));
  }
  std::printf("\n");
  return agree ? 0 : 1;
}
