#include <fmt/format.h>

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <variant>

#include "commands.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/formats/text_file.hpp"
#include "loopstone/geometry/angle.hpp"
#include "loopstone/plan/extract_plan.hpp"
#include "loopstone/report/plan_outputs.hpp"
#include "output_path.hpp"
#include "parse_pose.hpp"
#include "result.hpp"

namespace loopstone::app {

namespace {

struct Arguments {
  std::string map;
  std::string svg;
  std::string pdf;
  std::string dxf;
  std::string geojson;
  std::string anchor;
  std::string title;
  bool straighten = false;
  bool force = false;
};

constexpr const char* kFooter = R"(
Draws a map as lines: walls as they are seen from their free side, each with its own uncertainty; what furniture hides of
them; furniture; rooms with area and doors. A folder made with `loopstone map --keep-state` is drawn through what the laser
measured, to millimetres; else lines go through the cells of the map, to a cell or half of one. Right angles are drawn
only where measurements can't tell them from right. docs/plans.md has what each thing is and how well it is known.

--svg, --pdf   a sheet of paper, A4 to A0, at a round scale, with areas, dimensions, scale bar and legend
--dxf          release 12, in metres; layers STRUCTURE, HIDDEN, MOVABLE, ROOMS, DOORS, AREAS
--geojson      on the earth: needs --anchor, where the map's origin lies and where its x axis points

Examples:
  loopstone map LOG -o out --keep-state
  loopstone export out --pdf plan.pdf --dxf plan.dxf --straighten
  loopstone export map.yaml --geojson plan.geojson --anchor 48.26555,11.67110,93.5)";

std::optional<GeoAnchor> anchor_of(const Arguments& arguments) {
  if (arguments.anchor.empty()) {
    if (!arguments.geojson.empty()) {
      throw UsageError("--geojson needs --anchor LAT,LON,BEARING: where on the earth the map lies");
    }
    return std::nullopt;
  }
  const std::vector<double> v = parse_numbers("--anchor", arguments.anchor);
  if (v.size() != 3 || !is_on_earth({v[0], v[1], v[2]})) {
    throw UsageError("--anchor " + arguments.anchor +
                     ": must be LAT,LON,BEARING in degrees: latitude within 89.9, longitude within "
                     "180, bearing of the map's x axis clockwise from north within 360");
  }
  return GeoAnchor{v[0], v[1], v[2]};
}

Outputs outputs_of(const Arguments& arguments, const AppContext& context) {
  Outputs outputs(context, arguments.force);
  outputs.reads(arguments.map);
  int count = 0;
  const auto add = [&](const char* flag, const std::string& path) {
    if (path.empty()) return;
    outputs.add_file(flag, path);
    ++count;
  };
  add("--svg", arguments.svg);
  add("--pdf", arguments.pdf);
  add("--dxf", arguments.dxf);
  add("--geojson", arguments.geojson);
  if (count == 0)
    throw UsageError("nothing to write: give --svg, --pdf, --dxf or --geojson, or several of them");
  return outputs;
}

nlohmann::ordered_json json_of(const VectorPlan& plan) {
  auto rooms = nlohmann::ordered_json::array();
  for (const PlanRoom& room : plan.rooms) {
    rooms.push_back({{"area_m2", room.area_m2},
                     {"area_sigma_m2", room.area_sigma_m2},
                     {"closed", room.is_closed()},
                     {"open_m", room.open_m},
                     {"hidden_m", room.hidden_m},
                     {"perimeter_m", room.perimeter_m},
                     {"doors", room.doors.size()}});
  }
  auto doors = nlohmann::ordered_json::array();
  const auto number = [](int room) {
    return room < 0 ? nlohmann::ordered_json() : nlohmann::ordered_json(room + 1);
  };
  for (const PlanDoor& door : plan.doors) {
    doors.push_back({{"kind", door.is_opening() ? "opening" : "door"},
                     {"width_m", door.width_m},
                     {"width_sigma_m", door.width_sigma_m},
                     {"depth_m", door.depth_m},
                     {"rooms", {number(door.room), number(door.other_room)}}});
  }
  auto axes = nlohmann::ordered_json::array();
  for (const PlanAxis& axis : plan.axes)
    axes.push_back(
        {{"yaw_rad", axis.yaw_rad}, {"sigma_rad", axis.sigma_rad}, {"share", axis.share}});
  return {{"rooms", rooms},
          {"doors", doors},
          {"axes", axes},
          {"numbers", numbers_json(plan_numbers())}};
}

void print(const VectorPlan& plan, double seconds, const AppContext& context) {
  Result result;
  double area_m2 = 0.0;
  int open = 0;
  for (const PlanRoom& room : plan.rooms) {
    area_m2 += room.area_m2;
    open += static_cast<int>(!room.is_closed());
  }
  result.add("source", "lines through", plan.from_scans ? "scans" : "cells")
      .add("segments", "segments", static_cast<std::int64_t>(plan.segments.size()))
      .add("structure_m", "walls", length_of(plan, PlanLayer::kStructure), "m", 1)
      .add("hidden_m", "walls behind things", length_of(plan, PlanLayer::kHidden), "m", 1)
      .add("movable_m", "things", length_of(plan, PlanLayer::kMovable), "m", 1)
      .add_row("rooms", fmt::format("{}, {} of them not all seen", plan.rooms.size(), open))
      .add("area_m2", "area of rooms", area_m2, "m2", 1)
      .add_row("doors", fmt::format("{}", plan.doors.size()));
  for (const PlanAxis& axis : plan.axes) {
    result.add_row("axis",
                   fmt::format("{:.3f} +- {:.3f} deg, {:.0f} % of all", degrees(axis.yaw_rad),
                               degrees(axis.sigma_rad), 100.0 * axis.share));
  }
  const nlohmann::ordered_json parts = json_of(plan);
  for (const auto& [key, value] : parts.items()) result.add_json(key, value);
  result.add("wall_time_s", "time", seconds, "s", 2);
  result.print(context);
}

ExitCode run(const Arguments& arguments, const AppContext& context) {
  const auto start = std::chrono::steady_clock::now();
  const std::optional<GeoAnchor> anchor = anchor_of(arguments);
  const Outputs outputs = outputs_of(arguments, context);
  outputs.check();
  const VectorPlan in_map = read_plan(arguments.map, context.memory(), context.threads());
  if (!in_map.from_scans)
    context.note(
        "lines go through the cells of the map; where a map was made with --keep-state "
        "they go through what the laser measured, which is finer");
  const Pose2 plan_T_map = arguments.straighten ? straight_T_map(in_map) : Pose2{};
  const VectorPlan plan = plan_T_map * in_map;
  const PlanTitle title = plan_title(
      arguments.title.empty() ? plan_name(arguments.map) : arguments.title, plan_T_map, anchor);
  outputs.prepare();
  if (!arguments.svg.empty()) write_text_file(arguments.svg, format_plan_svg(plan, title));
  if (!arguments.pdf.empty()) write_text_file(arguments.pdf, format_plan_pdf(plan, title));
  if (!arguments.dxf.empty()) write_text_file(arguments.dxf, format_plan_dxf(plan));
  if (!arguments.geojson.empty())
    write_text_file(arguments.geojson, format_plan_geojson(in_map, *anchor));
  print(plan, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(),
        context);
  return kExitDone;
}

}  // namespace

void add_export_command(CLI::App& app, AppContext& context) {
  auto arguments = std::make_shared<Arguments>();
  CLI::App* command =
      app.add_subcommand("export", "Draw a map as a floor plan: walls, rooms, doors");
  command
      ->add_option("MAP", arguments->map,
                   "a folder that `loopstone map` made, a map_server map.yaml, or a site")
      ->required();
  command->add_option("--svg", arguments->svg, "write the plan as SVG")->type_name("FILE");
  command->add_option("--pdf", arguments->pdf, "write the plan as PDF")->type_name("FILE");
  command->add_option("--dxf", arguments->dxf, "write the plan as DXF")->type_name("FILE");
  command->add_option("--geojson", arguments->geojson, "write the plan as GeoJSON; needs --anchor")
      ->type_name("FILE");
  command
      ->add_option("--anchor", arguments->anchor,
                   "latitude and longitude of the map's origin, and the bearing of its x axis, "
                   "clockwise from true north [deg]")
      ->type_name("LAT,LON,BEARING");
  command->add_flag("--straighten", arguments->straighten,
                    "turn the plan so that most walls run along x and y (not GeoJSON)");
  command
      ->add_option("--title", arguments->title,
                   "what stands on the sheet; default: the name of MAP")
      ->type_name("TEXT");
  add_force_flag(*command, arguments->force);
  context.add_common_flags(*command);
  context.add_threads_flag(*command);
  command->footer(kFooter);
  context.on_run(*command, [arguments, &context] { return run(*arguments, context); });
}

}  // namespace loopstone::app
