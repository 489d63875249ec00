#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "arrays.hpp"
#include "bindings.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/evaluation/trajectory_error.hpp"

namespace loopstone::python {

namespace {

/// Both errors of a trajectory.
struct Evaluation {
  AbsoluteError absolute{};
  RelativeError relative{};
};

Spacing spacing_of(const std::string& unit) {
  if (unit == "frames") return Spacing::kFrames;
  if (unit == "m") return Spacing::kMetres;
  if (unit == "s") return Spacing::kSeconds;
  throw UsageError("rpe_unit = " + unit + ": must be one of m, s, frames");
}

Evaluation evaluate(const Trajectory& estimate, const Trajectory& reference,
                    const std::string& align, double rpe_delta, const std::string& rpe_unit) {
  const auto alignment = find_word<Alignment>(align);
  if (!alignment) throw UsageError("align = " + align + ": must be one of se2, none");
  const Spacing spacing = spacing_of(rpe_unit);
  if (!(rpe_delta > 0.0)) throw UsageError("rpe_delta: must be greater than 0");
  const nb::gil_scoped_release unlocked;
  Evaluation evaluation{absolute_error(estimate, reference, *alignment),
                        relative_error(estimate, reference, rpe_delta, spacing)};
  if (evaluation.absolute.poses == 0)
    throw UsageError("the estimate has no time in common with the reference");
  return evaluation;
}

/// \param errors  tells them of an evaluation
template <typename ErrorsOf>
void def_errors(nb::class_<Evaluation>& cls, const std::string& prefix, const char* shape,
                const std::string& of, ErrorsOf errors_of) {
  static_assert(sizeof(Stamp) == sizeof(std::int64_t));
  const auto errors = [errors_of](nb::handle_t<Evaluation> self) -> const PoseErrors& {
    return errors_of(nb::cast<const Evaluation&>(self));
  };
  def_array(
      cls, (prefix + "stamps_ns").c_str(),
      [errors](nb::handle_t<Evaluation> self) {
        const std::vector<Stamp>& stamps = errors(self).stamps;
        const std::int64_t* first = stamps.empty() ? nullptr : &stamps.front().nanoseconds;
        return view_of<std::int64_t>({first, stamps.size()}, self);
      },
      (std::string(shape) + " int64 [ns] of " + of + ", a read-only view.").c_str());
  def_array(
      cls, (prefix + "translation_errors_m").c_str(),
      [errors](nb::handle_t<Evaluation> self) {
        return view_of<double>(errors(self).translation_m, self);
      },
      (std::string(shape) + " errors of " + of + " [m], a read-only view.").c_str());
  def_array(
      cls, (prefix + "rotation_errors_rad").c_str(),
      [errors](nb::handle_t<Evaluation> self) {
        return view_of<double>(errors(self).rotation_rad, self);
      },
      (std::string(shape) + " of the heading, not negative [rad], a read-only view.").c_str());
}

}  // namespace

void bind_evaluation(nb::module_& m) {
  nb::class_<ErrorStatistics> statistics(m, "ErrorStatistics", "Of errors, all of one unit.");
  statistics.def_ro("mean", &ErrorStatistics::mean, "Of all.");
  statistics.def_ro("std", &ErrorStatistics::std, "With n - 1.");
  statistics.def_ro("rmse", &ErrorStatistics::rmse, "Root of the mean square.");
  statistics.def_ro("median", &ErrorStatistics::median, "Half are larger.");
  statistics.def_ro("max", &ErrorStatistics::max, "The worst.");
  statistics.def("__repr__", [](const ErrorStatistics& s) {
    return "<ErrorStatistics rmse " + std::to_string(s.rmse) + ", max " + std::to_string(s.max) +
           ">";
  });

  nb::class_<Evaluation> evaluation(m, "Evaluation", "How far a trajectory is from the truth.");
  evaluation.def_prop_ro(
      "ate_translation_m", [](const Evaluation& e) { return e.absolute.translation_m; },
      "Absolute trajectory error [m], after the alignment.");
  evaluation.def_prop_ro(
      "ate_rotation_rad", [](const Evaluation& e) { return e.absolute.rotation_rad; },
      "Of the heading [rad].");
  evaluation.def_prop_ro(
      "rpe_translation_m", [](const Evaluation& e) { return e.relative.translation_m; },
      "Relative pose error [m], over the stretch that was asked for.");
  evaluation.def_prop_ro(
      "rpe_rotation_rad", [](const Evaluation& e) { return e.relative.rotation_rad; },
      "Of the heading [rad].");
  evaluation.def_prop_ro(
      "poses", [](const Evaluation& e) { return e.absolute.poses; }, "That were compared.");
  evaluation.def_prop_ro(
      "poses_missing", [](const Evaluation& e) { return e.absolute.poses_missing; },
      "Reference poses outside the estimate's time.");
  evaluation.def_prop_ro(
      "pairs", [](const Evaluation& e) { return e.relative.pairs; }, "Of the relative error.");
  def_array(
      evaluation, "reference_T_estimate",
      [](const Evaluation& e) { return to_array(e.absolute.reference_T_estimate); },
      "(3,) the alignment that was applied.");
  def_errors(evaluation, "", "(P,)", "each pose that was compared",
             [](const Evaluation& e) -> const PoseErrors& { return e.absolute.by_pose; });
  def_errors(evaluation, "rpe_", "(S,)", "each stretch, at its beginning",
             [](const Evaluation& e) -> const PoseErrors& { return e.relative.by_pair; });
  evaluation.def("__repr__", [](const Evaluation& e) {
    return "<Evaluation: ATE " + std::to_string(e.absolute.translation_m.rmse) + " m rmse>";
  });
  m.def("evaluate", evaluate, nb::arg("estimate"), nb::arg("reference"), nb::arg("align"),
        nb::arg("rpe_delta"), nb::arg("rpe_unit"));
}

}  // namespace loopstone::python
