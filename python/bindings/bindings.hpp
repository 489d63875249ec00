#pragma once

#include <nanobind/nanobind.h>

// What each file of this folder adds to the extension module; module.cpp calls them in this order.

namespace loopstone::python {

namespace nb = nanobind;

void bind_errors(nb::module_& m);
void bind_options(nb::module_& m);
void bind_pose(nb::module_& m);
void bind_robot(nb::module_& m);
void bind_messages(nb::module_& m);
void bind_log(nb::module_& m);
void bind_conversion(nb::module_& m);
void bind_calibration(nb::module_& m);
void bind_trajectory(nb::module_& m);
void bind_maps(nb::module_& m);
void bind_texture(nb::module_& m);
void bind_landmarks(nb::module_& m);
void bind_graph(nb::module_& m);
void bind_verdict(nb::module_& m);
void bind_map_result(nb::module_& m);
void bind_map_calls(nb::module_& m);
void bind_editor(nb::module_& m);
void bind_site_records(nb::module_& m);
void bind_site_maps(nb::module_& m);
void bind_site_calls(nb::module_& m);
void bind_plans(nb::module_& m);
void bind_mapper(nb::module_& m);
void bind_localization(nb::module_& m);
void bind_relocalization(nb::module_& m);
void bind_match(nb::module_& m);
void bind_evaluation(nb::module_& m);
void bind_simulation(nb::module_& m);

}  // namespace loopstone::python
