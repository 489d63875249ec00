#include "bindings.hpp"
#include "loopstone/version.hpp"

NB_MODULE(_core, m) {
  using namespace loopstone::python;
  m.doc() = "The C++ library of Loopstone; `import loopstone` is what to use.";
  m.attr("version") = nanobind::str(loopstone::kVersion.data(), loopstone::kVersion.size());
  bind_errors(m);
  bind_options(m);
  bind_pose(m);
  bind_robot(m);
  bind_messages(m);
  bind_log(m);
  bind_conversion(m);
  bind_calibration(m);
  bind_trajectory(m);
  bind_maps(m);
  bind_texture(m);
  bind_landmarks(m);
  bind_graph(m);
  bind_verdict(m);
  bind_map_result(m);
  bind_map_calls(m);
  bind_editor(m);
  bind_site_records(m);
  bind_site_maps(m);
  bind_site_calls(m);
  bind_plans(m);
  bind_mapper(m);
  bind_localization(m);
  bind_relocalization(m);
  bind_match(m);
  bind_evaluation(m);
  bind_simulation(m);
}
