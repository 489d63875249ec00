#include <fmt/format.h>

#include <iterator>

#include "loopstone/report/plan_outputs.hpp"

namespace loopstone {

namespace {

/// Pairs of a group code and a value, one a line each.
class DxfText {
 public:
  void put(int code, std::string_view value) {
    fmt::format_to(std::back_inserter(text_), "{:3}\n{}\n", code, value);
  }
  void put(int code, int value) { put(code, fmt::format("{}", value)); }
  void put_number(int code, double value) { put(code, fmt::format("{:.6f}", value)); }
  /// \param first  10 for a point, 11 for the second one of a line
  void put_point(int first, const Eigen::Vector2d& point) {
    put_number(first, point.x());
    put_number(first + 10, point.y());
    put_number(first + 20, 0.0);
  }
  void line(std::string_view layer, const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
    put(0, "LINE");
    put(8, layer);
    put_point(10, from);
    put_point(11, to);
  }
  void polygon(std::string_view layer, const Polygon2& polygon) {
    put(0, "POLYLINE");
    put(8, layer);
    put(66, 1);  // vertices follow
    put_point(10, {0.0, 0.0});
    put(70, 1);  // closed
    for (const Eigen::Vector2d& corner : polygon.corners) {
      put(0, "VERTEX");
      put(8, layer);
      put_point(10, corner);
    }
    put(0, "SEQEND");
    put(8, layer);
  }
  void text(std::string_view layer, const Eigen::Vector2d& at, double height_m,
            std::string_view words) {
    put(0, "TEXT");
    put(8, layer);
    put_point(10, at);
    put_number(40, height_m);
    put(1, words);
    put(72, 1);  // centred on the second point
    put_point(11, at);
  }
  [[nodiscard]] std::string take() { return std::move(text_); }

 private:
  std::string text_{};
};

void add_header(const PlanBox& box, DxfText& dxf) {
  dxf.put(999, "Loopstone, plan of a map; metres");
  dxf.put(0, "SECTION");
  dxf.put(2, "HEADER");
  dxf.put(9, "$ACADVER");
  dxf.put(1, "AC1009");
  dxf.put(9, "$EXTMIN");
  dxf.put_point(10, box.low);
  dxf.put(9, "$EXTMAX");
  dxf.put_point(10, box.high);
  dxf.put(0, "ENDSEC");
}

struct DxfLayer {
  const char* name;
  int colour;  ///< AutoCAD colour index
  const char* line;
};

constexpr std::array<DxfLayer, 6> kLayers{{{"STRUCTURE", 7, "CONTINUOUS"},
                                           {"HIDDEN", 8, "DASHED"},
                                           {"MOVABLE", 3, "CONTINUOUS"},
                                           {"ROOMS", 5, "CONTINUOUS"},
                                           {"DOORS", 1, "CONTINUOUS"},
                                           {"AREAS", 5, "CONTINUOUS"}}};

void add_tables(DxfText& dxf) {
  dxf.put(0, "SECTION");
  dxf.put(2, "TABLES");
  dxf.put(0, "TABLE");
  dxf.put(2, "LTYPE");
  dxf.put(70, 2);
  for (const bool dashed : {false, true}) {
    dxf.put(0, "LTYPE");
    dxf.put(2, dashed ? "DASHED" : "CONTINUOUS");
    dxf.put(70, 0);
    dxf.put(3, dashed ? "__ __ __" : "Solid line");
    dxf.put(72, 65);
    dxf.put(73, dashed ? 2 : 0);
    dxf.put_number(40, dashed ? 0.3 : 0.0);
    if (!dashed) continue;
    dxf.put_number(49, 0.2);
    dxf.put_number(49, -0.1);
  }
  dxf.put(0, "ENDTAB");
  dxf.put(0, "TABLE");
  dxf.put(2, "LAYER");
  dxf.put(70, static_cast<int>(kLayers.size()));
  for (const DxfLayer& layer : kLayers) {
    dxf.put(0, "LAYER");
    dxf.put(2, layer.name);
    dxf.put(70, 0);
    dxf.put(62, layer.colour);
    dxf.put(6, layer.line);
  }
  dxf.put(0, "ENDTAB");
  dxf.put(0, "ENDSEC");
}

const char* layer_of(PlanLayer layer) { return kLayers[static_cast<std::size_t>(layer)].name; }

}  // namespace

std::string format_plan_dxf(const VectorPlan& plan) {
  DxfText dxf;
  add_header(box_of(plan), dxf);
  add_tables(dxf);
  dxf.put(0, "SECTION");
  dxf.put(2, "ENTITIES");
  for (const PlanSegment& segment : plan.segments)
    dxf.line(layer_of(segment.layer), segment.from, segment.to);
  for (const PlanDoor& door : plan.doors) dxf.line("DOORS", door.from, door.to);
  for (std::size_t i = 0; i < plan.rooms.size(); ++i) {
    const PlanRoom& room = plan.rooms[i];
    dxf.polygon("ROOMS", room.outline.polygon);
    for (const PlanOutline& hole : room.holes) dxf.polygon("ROOMS", hole.polygon);
    dxf.text("AREAS", label_place(room), 0.25, fmt::format("R{} {:.2f} m2", i + 1, room.area_m2));
  }
  dxf.put(0, "ENDSEC");
  dxf.put(0, "EOF");
  return dxf.take();
}

}  // namespace loopstone
