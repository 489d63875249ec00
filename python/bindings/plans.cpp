#include <fmt/format.h>
#include <nanobind/nanobind.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "arrays.hpp"
#include "bindings.hpp"
#include "json.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/formats/machine_memory.hpp"
#include "loopstone/formats/output_place.hpp"
#include "loopstone/formats/text_file.hpp"
#include "loopstone/geometry/angle.hpp"
#include "loopstone/plan/extract_plan.hpp"
#include "loopstone/report/plan_outputs.hpp"
#include "maps.hpp"
#include "methods.hpp"
#include "path_like.hpp"
#include "sites.hpp"
#include "work.hpp"

namespace loopstone::python {

namespace {

/// A plan, and how it lies to the map that it was drawn from.
struct FloorPlan {
  VectorPlan in_map{};
  std::string name{};
  Pose2 plan_T_map{};
  VectorPlan plan = in_map;
};

/// Latitude, longitude, bearing of the map's x axis [deg].
using Anchor = std::tuple<double, double, double>;

template <typename Enum>
std::string word(Enum value) {
  return std::string(loopstone::to_string(value));
}

GeoAnchor anchor_of(const Anchor& given) {
  const auto& [latitude, longitude, bearing] = given;
  const GeoAnchor anchor{latitude, longitude, bearing};
  if (!is_on_earth(anchor)) {
    throw UsageError(
        fmt::format("anchor ({}, {}, {}): must be (latitude, longitude, bearing) in degrees: "
                    "latitude within 89.9, longitude within 180, bearing of the map's x axis "
                    "clockwise from north within 360",
                    latitude, longitude, bearing));
  }
  return anchor;
}

PlanTitle title_of(const FloorPlan& self, const std::optional<std::string>& title,
                   const std::optional<Anchor>& anchor) {
  std::optional<GeoAnchor> on_earth;
  if (anchor) on_earth = anchor_of(*anchor);
  return plan_title(title.value_or(self.name), self.plan_T_map, on_earth);
}

/// \param format  makes the file's content
template <typename Format>
void write(const PathLike& path, bool force, Format&& format) {
  const nb::gil_scoped_release unlocked;
  if (!force) require_free_name(path.value);
  write_text_file(path.value, format());
}

std::vector<std::string> sides_of(const PlanOutline& outline) {
  std::vector<std::string> words;
  for (const PlanSide side : outline.sides) words.push_back(word(side));
  return words;
}

nb::object room_or_none(int room) { return room < 0 ? nb::none() : nb::object(nb::int_(room)); }

void bind_segment(nb::module_& m) {
  nb::class_<PlanSegment> segment(
      m, "PlanSegment",
      "A straight piece of surface as it is seen from one side: a wall that is seen from both has\n"
      "two. Who goes from its start to its end has free space on his left. Standard deviations "
      "are\n"
      "about the map, not about the world.");
  def_array(
      segment, "start", [](const PlanSegment& s) { return to_array(s.from); }, "(2,) x, y [m].");
  def_array(
      segment, "end", [](const PlanSegment& s) { return to_array(s.to); }, "(2,) x, y [m].");
  def_array(
      segment, "normal", [](const PlanSegment& s) { return to_array(s.normal()); },
      "(2,) of length 1, towards the free side.");
  segment.def_prop_ro("length_m", &PlanSegment::length_m, "From start to end.");
  segment.def_prop_ro(
      "layer", [](const PlanSegment& s) { return word(s.layer); },
      "``structure``: walls and pillars; ``hidden``: wall that furniture hides, drawn through;\n"
      "``movable``: furniture and other things that stand about.");
  segment.def_ro("sigma_across_m", &PlanSegment::sigma_across_m,
                 "Standard deviation of the line, at its middle.");
  segment.def_ro("sigma_yaw_rad", &PlanSegment::sigma_yaw_rad, "Of its direction.");
  segment.def_ro("sigma_start_m", &PlanSegment::sigma_from_m, "Of its start, along the line.");
  segment.def_ro("sigma_end_m", &PlanSegment::sigma_to_m, "Of its end, along the line.");
  segment.def_ro("squared", &PlanSegment::squared,
                 "Its direction is that of an axis, from which it could not be told.");
  segment.def("__repr__", [](const PlanSegment& s) {
    return fmt::format("<PlanSegment ({:.2f}, {:.2f}) to ({:.2f}, {:.2f}) m: {}>", s.from.x(),
                       s.from.y(), s.to.x(), s.to.y(), word(s.layer));
  });
}

void bind_room(nb::module_& m) {
  nb::class_<PlanRoom> room(m, "PlanRoom", "A piece of floor that walls and doors go round.");
  def_array(
      room, "polygon", [](const PlanRoom& r) { return corners_of(r.outline.polygon); },
      "(V, 2) its corners [m], counter-clockwise along the faces of its walls; the floor under\n"
      "furniture belongs to it.");
  room.def_prop_ro(
      "sides", [](const PlanRoom& r) { return sides_of(r.outline); },
      "What the outline runs along from each corner to the next: ``wall``, ``hidden``, ``door`` "
      "or\n``open``, where nothing is known.");
  room.def_prop_ro(
      "holes",
      [](const PlanRoom& r) {
        nb::list holes;
        for (const PlanOutline& hole : r.holes) holes.append(corners_of(hole.polygon));
        return holes;
      },
      nb::sig("def holes(self) -> list[numpy.typing.NDArray[numpy.float64]]"),
      "(V, 2) each, clockwise: walls and rooms that it goes round.");
  room.def_ro("area_m2", &PlanRoom::area_m2, "Without its holes.");
  room.def_ro("area_sigma_m2", &PlanRoom::area_sigma_m2, "Standard deviation of that.");
  room.def_prop_ro("closed", &PlanRoom::is_closed, "There are walls and doors all around.");
  room.def_ro("perimeter_m", &PlanRoom::perimeter_m, "Of the outline and of holes.");
  room.def_ro("open_m", &PlanRoom::open_m, "Of that, where no wall was seen.");
  room.def_ro("hidden_m", &PlanRoom::hidden_m, "Of that, where a wall was drawn through.");
  room.def_ro("doors", &PlanRoom::doors, "Its doors: places in the plan's ``doors``.");
  def_array(
      room, "label", [](const PlanRoom& r) { return to_array(label_place(r)); },
      "(2,) where its name stands best [m]: farthest from its walls.");
  room.def("__repr__", [](const PlanRoom& r) {
    return fmt::format("<PlanRoom of {:.2f} m2, {} doors{}>", r.area_m2, r.doors.size(),
                       r.is_closed() ? "" : ", not all seen");
  });
}

void bind_door(nb::module_& m) {
  nb::class_<PlanDoor> door(m, "PlanDoor",
                            "An opening between two jambs: a door, or what is wider than one.");
  door.def_prop_ro(
      "kind", [](const PlanDoor& d) { return std::string(d.is_opening() ? "opening" : "door"); },
      "``door``, or ``opening`` where it is wider than 1.4 m.");
  def_array(
      door, "start", [](const PlanDoor& d) { return to_array(d.from); },
      "(2,) one of its jambs, in the middle of the wall [m].");
  def_array(
      door, "end", [](const PlanDoor& d) { return to_array(d.to); }, "(2,) the other one.");
  door.def_ro("width_m", &PlanDoor::width_m, "Clear, between the jambs.");
  door.def_ro("width_sigma_m", &PlanDoor::width_sigma_m, "Standard deviation of that.");
  door.def_ro("depth_m", &PlanDoor::depth_m, "Of the wall; 0: only one of its faces was seen.");
  door.def_prop_ro(
      "room", [](const PlanDoor& d) { return room_or_none(d.room); },
      nb::sig("def room(self) -> int | None"),
      "Of which room it is a door: a place in the plan's ``rooms``; None: outside, or unexplored.");
  door.def_prop_ro(
      "other_room", [](const PlanDoor& d) { return room_or_none(d.other_room); },
      nb::sig("def other_room(self) -> int | None"), "Likewise, on its other side.");
  door.def("__repr__",
           [](const PlanDoor& d) { return fmt::format("<PlanDoor of {:.2f} m>", d.width_m); });
}

void bind_axis(nb::module_& m) {
  nb::class_<PlanAxis> axis(m, "PlanAxis",
                            "A direction along which walls run, and at right angles to it.");
  axis.def_ro("yaw_rad", &PlanAxis::yaw_rad, "[-pi/4, pi/4), frame of the plan.");
  axis.def_ro("sigma_rad", &PlanAxis::sigma_rad, "Standard deviation of that.");
  axis.def_ro("share", &PlanAxis::share, "Of the length of all segments, those that run along it.");
  axis.def("__repr__", [](const PlanAxis& a) {
    return fmt::format("<PlanAxis at {:.3f} deg, {:.0f} % of all walls>", degrees(a.yaw_rad),
                       100.0 * a.share);
  });
}

std::optional<PlanLayer> layer_of(const std::optional<std::string>& name) {
  if (!name) return {};
  const auto layer = find_word<PlanLayer>(*name);
  if (!layer) throw UsageError("layer: must be structure, hidden or movable, not " + *name);
  return layer;
}

Array<double, nb::shape<-1, 2, 2>> lines_of(const FloorPlan& self,
                                            const std::optional<std::string>& name) {
  const auto layer = layer_of(name);
  std::vector<double> values;
  for (const PlanSegment& s : self.plan.segments) {
    if (!layer || s.layer == *layer)
      values.insert(values.end(), {s.from.x(), s.from.y(), s.to.x(), s.to.y()});
  }
  const std::size_t count = values.size() / 4;
  return array_of<double, nb::shape<-1, 2, 2>>(std::move(values), {count, 2, 2});
}

void def_parts(nb::class_<FloorPlan>& cls) {
  cls.def_prop_ro(
      "segments", [](const FloorPlan& self) { return self.plan.segments; },
      "All straight pieces of surface, of all layers.");
  cls.def_prop_ro(
      "walls",
      [](const FloorPlan& self) {
        std::vector<PlanSegment> walls = self.plan.segments;
        std::erase_if(walls, [](const PlanSegment& s) { return s.layer != PlanLayer::kStructure; });
        return walls;
      },
      "Those of the layer ``structure``.");
  cls.def_prop_ro(
      "rooms", [](const FloorPlan& self) { return self.plan.rooms; }, "Largest first.");
  cls.def_prop_ro(
      "doors", [](const FloorPlan& self) { return self.plan.doors; }, "Doors and openings.");
  cls.def_prop_ro(
      "axes", [](const FloorPlan& self) { return self.plan.axes; },
      "Greatest share first; none: walls run anyhow.");
  cls.def("lines", lines_of, nb::arg("layer") = nb::none(),
          nb::sig("def lines(self, layer: typing.Literal['structure', 'hidden', 'movable'] | None "
                  "= None) -> numpy.typing.NDArray[numpy.float64]"),
          "(N, 2, 2) start and end of each segment [m], of one layer or of all.");
  cls.def(
      "length_m",
      [](const FloorPlan& self, const std::string& name) {
        return length_of(self.plan, *layer_of(name));
      },
      nb::arg("layer") = "structure",
      nb::sig("def length_m(self, layer: typing.Literal['structure', 'hidden', 'movable'] = "
              "'structure') -> float"),
      "Of all segments of a layer.");
  cls.def_prop_ro(
      "extent",
      [](const FloorPlan& self) {
        const PlanBox box = box_of(self.plan);
        return std::tuple(box.low.x(), box.high.x(), box.low.y(), box.high.y());
      },
      "(left, right, bottom, top) [m].");
  cls.def_prop_ro(
      "from_scans", [](const FloorPlan& self) { return self.plan.from_scans; },
      "Its lines go through what the laser measured; else through the cells of the map, which is\n"
      "coarser.");
}

void def_frame(nb::class_<FloorPlan>& cls) {
  def_array(
      cls, "plan_T_map", [](const FloorPlan& self) { return to_array(self.plan_T_map); },
      "(3,) x, y [m], yaw [rad]: 0 unless it was straightened.");
  cls.def(
      "straightened",
      [](const FloorPlan& self) {
        const Pose2 plan_T_map = straight_T_map(self.in_map);
        return FloorPlan{self.in_map, self.name, plan_T_map, plan_T_map * self.in_map};
      },
      "The same plan, turned so that most walls run along x and y.");
}

constexpr const char* kSheet =
    "A sheet of paper, A4 to A0, with areas and dimensions, as ``loopstone export`` writes it.\n"
    "``title``: instead of the name of the map. ``anchor``: (latitude, longitude, bearing of the\n"
    "map's x axis clockwise from north) [deg]; there is an arrow to the north then. Raises\n"
    "UsageError where there is a file already, unless forced.";

void def_files(nb::class_<FloorPlan>& cls) {
  const auto sheet = [&cls](const char* name,
                            std::string (*format)(const VectorPlan&, const PlanTitle&)) {
    cls.def(
        name,
        [format](const FloorPlan& self, const PathLike& path,
                 const std::optional<std::string>& title, const std::optional<Anchor>& anchor,
                 bool force) {
          write(path, force, [&] { return format(self.plan, title_of(self, title, anchor)); });
        },
        nb::arg("path"), nb::kw_only(), nb::arg("title") = nb::none(),
        nb::arg("anchor") = nb::none(), nb::arg("force") = false, kSheet);
  };
  sheet("write_svg", format_plan_svg);
  sheet("write_pdf", format_plan_pdf);
  cls.def(
      "write_dxf",
      [](const FloorPlan& self, const PathLike& path, bool force) {
        write(path, force, [&] { return format_plan_dxf(self.plan); });
      },
      nb::arg("path"), nb::kw_only(), nb::arg("force") = false,
      "For CAD: DXF release 12, metres, layers STRUCTURE, HIDDEN, MOVABLE, ROOMS, DOORS, AREAS.");
  cls.def(
      "write_geojson",
      [](const FloorPlan& self, const PathLike& path, const Anchor& anchor, bool force) {
        write(path, force, [&] { return format_plan_geojson(self.in_map, anchor_of(anchor)); });
      },
      nb::arg("path"), nb::arg("anchor"), nb::kw_only(), nb::arg("force") = false,
      "On the earth: ``anchor`` is (latitude, longitude) of the map's origin and the bearing of\n"
      "its x axis, clockwise from true north [deg]. Straightened or not, it is the same.");
  cls.def(
      "to_geojson",
      [](const FloorPlan& self, const Anchor& anchor) {
        return parse_json(format_plan_geojson(self.in_map, anchor_of(anchor)));
      },
      nb::arg("anchor"),
      nb::sig("def to_geojson(self, anchor: tuple[float, float, float]) -> dict[str, typing.Any]"),
      "What write_geojson() writes: a FeatureCollection.");
  cls.def("_repr_svg_",
          [](const FloorPlan& self) { return format_plan_svg(self.plan, title_of(self, {}, {})); });
}

}  // namespace

void bind_plans(nb::module_& m) {
  bind_segment(m);
  bind_room(m);
  bind_door(m);
  bind_axis(m);
  nb::class_<FloorPlan> cls(m, "FloorPlan",
                            "A map as lines, rooms and doors; in the frame of the map unless it "
                            "was straightened.");
  def_parts(cls);
  def_frame(cls);
  def_files(cls);
  def_python(cls, "plot", "loopstone._plot", "plot_plan",
             "def plot(self, ax: matplotlib.axes.Axes | None = None) -> matplotlib.axes.Axes",
             "Draws rooms, walls and doors, metres on the axes. Needs loopstone[plot].");
  cls.def("__repr__", [](const FloorPlan& self) {
    return fmt::format("<FloorPlan of {} segments, {} rooms, {} doors>", self.plan.segments.size(),
                       self.plan.rooms.size(), self.plan.doors.size());
  });
  m.def(
      "read_floor_plan",
      [](const PathLike& path, int threads) {
        return work(nb::none(), [&](Work& /*own*/) {
          return FloorPlan{read_plan(path.value, machine_memory_budget(), Threads{threads}),
                           plan_name(path.value)};
        });
      },
      nb::arg("path"), nb::arg("threads"));
  m.def(
      "floor_plan_of_result",
      [](const Mapped& map, int threads) {
        return work(nb::none(), [&](Work& /*own*/) {
          return FloorPlan{plan_of(map.result, map.state.get(), Threads{threads}),
                           plan_name(map.info.log_path)};
        });
      },
      nb::arg("map"), nb::arg("threads"));
  m.def(
      "floor_plan_of_site_map",
      [](const SiteMapped& map, int threads) {
        return work(nb::none(), [&](Work& /*own*/) {
          return FloorPlan{plan_of(map.result, map.scans, walls_of(map.edits), Threads{threads}),
                           plan_name(map.info.log_path)};
        });
      },
      nb::arg("map"), nb::arg("threads"));
  m.def(
      "floor_plan_of_cells",
      [](const GridMap& map) {
        return work(nb::none(), [&](Work& /*own*/) {
          return FloorPlan{extract_plan(*map.cells, samples_of_cells(*map.cells)), "map"};
        });
      },
      nb::arg("map"));
}

}  // namespace loopstone::python
