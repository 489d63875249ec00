#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <string>

#include "arrays.hpp"
#include "bindings.hpp"
#include "loopstone/slam/loop_closure.hpp"
#include "loopstone/slam/map_verdict.hpp"

namespace loopstone::python {

namespace {

template <typename Enum>
std::string word(Enum value) {
  return std::string(loopstone::to_string(value));
}

void bind_closure(nb::module_& m) {
  nb::class_<LoopClosure> closure(
      m, "LoopClosure", "A place that was recognised, or looked like it, with the evidence.");
  closure.def_prop_ro(
      "from_node", [](const LoopClosure& c) { return c.from.index; },
      "Of the graph; while the robot drives, the number of the submap.");
  closure.def_prop_ro(
      "to_node", [](const LoopClosure& c) { return c.to.index; }, "Likewise.");
  closure.def_prop_ro(
      "from_submap", [](const LoopClosure& c) { return c.from_submap.index; }, "The older one.");
  closure.def_prop_ro(
      "to_submap", [](const LoopClosure& c) { return c.to_submap.index; }, "The newer one.");
  def_array(
      closure, "from_T_to", [](const LoopClosure& c) { return to_array(c.from_T_to); },
      "(3,) x, y [m], yaw [rad], as measured by registration.");
  def_array(
      closure, "covariance",
      [](const LoopClosure& c) { return to_array(Eigen::MatrixXd(c.covariance)); },
      "(3, 3) of from_T_to [m^2, m rad, rad^2].");
  closure.def_ro("score", &LoopClosure::score, "[0, 1], share of points explained.");
  closure.def_ro("overlap", &LoopClosure::overlap,
                 "[0, 1], share of points that fall where the older submap was observed.");
  closure.def_ro(
      "agreement", &LoopClosure::agreement,
      "[0, 1], of those, share on a surface that faces the same way; or, where that is more, "
      "of each submap's surfaces that the other one could see, share that it saw.");
  closure.def_prop_ro(
      "chi2",
      [](const LoopClosure& c) { return c.chi2 ? nb::object(nb::float_(*c.chi2)) : nb::none(); },
      nb::sig("def chi2(self) -> float | None"),
      "Disagreement with the graph's poses; None of what was never in the graph.");
  closure.def_prop_ro("stands", &LoopClosure::stands, "It is an edge of the graph.");
  closure.def_prop_ro(
      "state", [](const LoopClosure& c) { return word(c.state); },
      "``waiting``, ``standing``, ``rejected`` or ``revoked``.");
  closure.def_prop_ro(
      "reason", [](const LoopClosure& c) { return word(c.reason); },
      "Why it does not stand, in words; empty when it does.");
  closure.def("__repr__", [](const LoopClosure& c) {
    return "<LoopClosure " + std::to_string(c.from.index) + " -> " + std::to_string(c.to.index) +
           ", " + word(c.state) + ">";
  });
}

}  // namespace

void bind_verdict(nb::module_& m) {
  bind_closure(m);
  nb::class_<QualityMeasure> measure(m, "QualityMeasure", "One figure and what it means.");
  measure.def_ro("name", &QualityMeasure::name, "With its unit at the end, as in summary.json.");
  measure.def_ro("title", &QualityMeasure::title, "In words.");
  measure.def_ro("value", &QualityMeasure::value,
                 "In the unit of its name; of an unknown one it means nothing.");
  measure.def_prop_ro(
      "verdict", [](const QualityMeasure& q) { return word(q.verdict); },
      "``unknown``, ``good``, ``doubtful`` or ``bad``.");
  measure.def_ro("sentence", &QualityMeasure::sentence, "What it means for the map.");
  measure.def("__repr__", [](const QualityMeasure& q) {
    return "<QualityMeasure " + q.name + " = " + std::to_string(q.value) + ": " + word(q.verdict) +
           ">";
  });

  nb::class_<MapVerdict> verdict(m, "MapVerdict",
                                 "How good a map is, as far as its own scans can tell.");
  verdict.def_prop_ro(
      "overall", [](const MapVerdict& v) { return word(v.overall); },
      "``unknown``, ``good``, ``doubtful`` or ``bad``: the worst of what is known.");
  verdict.def_ro("sentence", &MapVerdict::sentence, "What that means, in words.");
  verdict.def_ro("measures", &MapVerdict::measures, "Always the same ones, in the same order.");
  verdict.def("__str__", [](const MapVerdict& v) { return word(v.overall) + ": " + v.sentence; });
  verdict.def("__repr__", [](const MapVerdict& v) {
    return "<MapVerdict " + word(v.overall) + ": " + v.sentence + ">";
  });
}

}  // namespace loopstone::python
