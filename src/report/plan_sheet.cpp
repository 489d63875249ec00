#include "report/plan_sheet.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "loopstone/geometry/angle.hpp"
#include "report/plan_dimensions.hpp"
#include "report/round_length.hpp"

namespace loopstone {

namespace {

constexpr double kMarginMm = 10.0;
constexpr double kTitleMm = 24.0;   ///< height of the strip below the plan
constexpr double kAroundMm = 16.0;  ///< for the dimensions of the whole
constexpr double kBandM = 0.12;     ///< tone behind the faces of walls

constexpr unsigned kInk = 0x1a1a1a;
constexpr unsigned kWallTone = 0x5b5f66;
constexpr unsigned kHiddenTone = 0xb9bcc2;
constexpr unsigned kRoomTone = 0xfbfaf7;
constexpr unsigned kOpenTone = 0xeef3f8;
constexpr unsigned kThingTone = 0x8a8f98;
constexpr unsigned kSizeTone = 0x3c6e9e;

struct PaperSize {
  const char* name;
  double long_mm;
  double short_mm;
};
constexpr std::array<PaperSize, 5> kPapers{{{"A4", 297.0, 210.0},
                                            {"A3", 420.0, 297.0},
                                            {"A2", 594.0, 420.0},
                                            {"A1", 841.0, 594.0},
                                            {"A0", 1189.0, 841.0}}};

/// A sheet on which the plan fits, and 1 : scale.
struct Layout {
  PaperSize paper{};
  bool landscape = true;
  int scale = 100;

  [[nodiscard]] double width_mm() const { return landscape ? paper.long_mm : paper.short_mm; }
  [[nodiscard]] double height_mm() const { return landscape ? paper.short_mm : paper.long_mm; }
  [[nodiscard]] Eigen::Vector2d room_mm() const {
    return {width_mm() - 2.0 * kMarginMm - 2.0 * kAroundMm,
            height_mm() - 2.0 * kMarginMm - kTitleMm - 2.0 * kAroundMm};
  }
};

/// The scales of building plans; paper grows before a plan becomes too small to be read.
Layout layout_of(const Eigen::Vector2d& size_m) {
  struct Choice {
    int scale;
    std::size_t papers;  ///< so many from the smallest on
  };
  constexpr std::array<Choice, 9> kChoices{{{50, 1},
                                            {100, 3},
                                            {200, 4},
                                            {500, 5},
                                            {1000, 5},
                                            {2000, 5},
                                            {5000, 5},
                                            {10000, 5},
                                            {100000, 5}}};
  Layout layout;
  for (const Choice& choice : kChoices) {
    for (std::size_t i = 0; i < choice.papers; ++i) {
      for (const bool landscape : {true, false}) {
        layout = {kPapers[i], landscape, choice.scale};
        const Eigen::Vector2d needs_mm = 1000.0 / choice.scale * size_m;
        if ((needs_mm.array() <= layout.room_mm().array()).all()) return layout;
      }
    }
  }
  return layout;
}

SheetStyle line_style(double width_mm, unsigned colour, std::vector<double> dashes_mm = {}) {
  return {.width_mm = width_mm, .line = colour, .dashes_mm = std::move(dashes_mm)};
}

SheetStyle fill_style(unsigned colour) { return {.filled = true, .fill = colour}; }

class SheetDrawer {
 public:
  SheetDrawer(const VectorPlan& plan, const PlanTitle& title)
      : plan_(plan), title_(title), box_(box_of(plan)), layout_(layout_of(box_.size())) {
    sheet_.width_mm = layout_.width_mm();
    sheet_.height_mm = layout_.height_mm();
    const Eigen::Vector2d size_mm = mm_per_m() * box_.size();
    const Eigen::Vector2d free_mm = layout_.room_mm() - size_mm;
    corner_mm_ =
        Eigen::Vector2d(kMarginMm + kAroundMm, kMarginMm + kTitleMm + kAroundMm) + 0.5 * free_mm;
  }

  PlanSheet draw() {
    add_frame();
    add_rooms();
    add_layer(PlanLayer::kMovable, line_style(0.18, kThingTone));
    add_layer(PlanLayer::kHidden, line_style(0.25, kInk, {1.2, 0.8}));
    add_layer(PlanLayer::kStructure, line_style(0.35, kInk));
    add_doors();
    add_dimensions();
    add_labels();
    add_title();
    return std::move(sheet_);
  }

 private:
  [[nodiscard]] double mm_per_m() const { return 1000.0 / layout_.scale; }
  [[nodiscard]] Eigen::Vector2d mm(const Eigen::Vector2d& point_m) const {
    return corner_mm_ + mm_per_m() * (point_m - box_.low);
  }
  [[nodiscard]] std::vector<Eigen::Vector2d> mm(const Polygon2& polygon) const {
    std::vector<Eigen::Vector2d> ring;
    for (const Eigen::Vector2d& corner : polygon.corners) ring.push_back(mm(corner));
    return ring;
  }
  SheetGroup& group(const char* id) {
    sheet_.groups.push_back({.id = id});
    return sheet_.groups.back();
  }
  static void rectangle(SheetGroup& group, const Eigen::Vector2d& low, const Eigen::Vector2d& high,
                        const SheetStyle& style) {
    group.shapes.push_back({{{low, {high.x(), low.y()}, high, {low.x(), high.y()}}}, true, style});
  }
  static void line(SheetGroup& group, const Eigen::Vector2d& from, const Eigen::Vector2d& to,
                   const SheetStyle& style) {
    group.shapes.push_back({{{from, to}}, false, style});
  }

  void add_frame() {
    SheetGroup& frame = group("frame");
    const Eigen::Vector2d low(kMarginMm, kMarginMm);
    const Eigen::Vector2d high(sheet_.width_mm - kMarginMm, sheet_.height_mm - kMarginMm);
    rectangle(frame, low, high, line_style(0.5, kInk));
    line(frame, {low.x(), low.y() + kTitleMm}, {high.x(), low.y() + kTitleMm},
         line_style(0.25, kInk));
  }

  [[nodiscard]] SheetShape shape_of(const PlanRoom& room, const SheetStyle& style) const {
    SheetShape shape{{mm(room.outline.polygon)}, true, style};
    for (const PlanOutline& hole : room.holes) shape.rings.push_back(mm(hole.polygon));
    return shape;
  }

  void add_sides(const PlanOutline& outline, PlanSide kind, const SheetStyle& style,
                 SheetGroup& group) const {
    const std::vector<Eigen::Vector2d> ring = mm(outline.polygon);
    for (std::size_t i = 0; i < ring.size(); ++i)
      if (outline.sides[i] == kind) line(group, ring[i], ring[(i + 1) % ring.size()], style);
  }
  void add_sides(PlanSide kind, const SheetStyle& style, SheetGroup& group) const {
    for (const PlanRoom& room : plan_.rooms) {
      add_sides(room.outline, kind, style, group);
      for (const PlanOutline& hole : room.holes) add_sides(hole, kind, style, group);
    }
  }

  /// The tone of walls reaches a little way behind their faces; floors lie on it.
  void add_rooms() {
    SheetGroup& walls = group("walls");
    const double band_mm = 2.0 * kBandM * mm_per_m();
    add_sides(PlanSide::kHidden, line_style(band_mm, kHiddenTone), walls);
    add_sides(PlanSide::kWall, line_style(band_mm, kWallTone), walls);
    SheetGroup& rooms = group("rooms");
    for (const PlanRoom& room : plan_.rooms)
      rooms.shapes.push_back(shape_of(room, fill_style(room.is_closed() ? kRoomTone : kOpenTone)));
    add_sides(PlanSide::kOpen, line_style(0.18, kSizeTone, {0.4, 1.0}), rooms);
  }

  void add_layer(PlanLayer layer, const SheetStyle& style) {
    SheetGroup& lines = group(std::string(to_string(layer)).c_str());
    for (const PlanSegment& segment : plan_.segments)
      if (segment.layer == layer) line(lines, mm(segment.from), mm(segment.to), style);
  }

  void add_doors() {
    SheetGroup& doors = group("doors");
    for (const PlanDoor& door : plan_.doors) {
      const Eigen::Vector2d u = (door.to - door.from).normalized();
      const Eigen::Vector2d normal(-u.y(), u.x());
      const double half_m = 0.5 * door.depth_m + (door.depth_m > 0.0 ? 0.0 : kBandM);
      const Eigen::Vector2d out = (half_m + 0.2 / mm_per_m()) * normal;
      doors.shapes.push_back(
          {{{mm(door.from - out), mm(door.to - out), mm(door.to + out), mm(door.from + out)}},
           true,
           fill_style(kRoomTone)});
      const Eigen::Vector2d face = half_m * normal;
      for (const double side : {-1.0, 1.0})
        line(doors, mm(door.from + side * face), mm(door.to + side * face),
             line_style(0.13, kInk, {0.6, 0.6}));
      const Eigen::Vector2d cap = mm(door.from + face) - mm(door.from - face);
      for (const Eigen::Vector2d& jamb : {door.from, door.to})
        line(doors, mm(jamb) - 0.5 * cap, mm(jamb) + 0.5 * cap, line_style(0.35, kInk));
      add_door_text(door, u, normal, doors);
    }
  }

  /// Its width, in the room that it leads to.
  void add_door_text(const PlanDoor& door, const Eigen::Vector2d& u, const Eigen::Vector2d& normal,
                     SheetGroup& doors) const {
    constexpr double kSizeMm = 1.5;
    double turn = degrees(std::atan2(u.y(), u.x()));
    const double side = turn > 90.0 || turn <= -90.0 ? -1.0 : 1.0;
    if (side < 0.0) turn += turn > 0.0 ? -180.0 : 180.0;
    const double away_mm = mm_per_m() * (0.5 * door.depth_m) + 0.8;
    doors.texts.push_back({.at = mm(0.5 * (door.from + door.to)) + side * away_mm * normal,
                           .size_mm = kSizeMm,
                           .anchor = 0.5,
                           .turn_deg = turn,
                           .colour = kSizeTone,
                           .words = fmt::format("{:.2f}", door.width_m)});
  }

  /// A line with ticks at its ends and its length in metres on it.
  void dimension(SheetGroup& sizes, const Eigen::Vector2d& from_mm, const Eigen::Vector2d& to_mm,
                 double length_m, double text_mm) const {
    const Eigen::Vector2d u = (to_mm - from_mm).normalized();
    const Eigen::Vector2d up(-u.y(), u.x());
    line(sizes, from_mm, to_mm, line_style(0.1, kSizeTone));
    for (const Eigen::Vector2d& end : {from_mm, to_mm})
      line(sizes, end - 0.6 * (u + up), end + 0.6 * (u + up), line_style(0.25, kSizeTone));
    sizes.texts.push_back({.at = 0.5 * (from_mm + to_mm) + 0.6 * up,
                           .size_mm = text_mm,
                           .anchor = 0.5,
                           .turn_deg = degrees(std::atan2(u.y(), u.x())),
                           .colour = kSizeTone,
                           .words = fmt::format("{:.2f}", length_m)});
  }

  void add_dimensions() {
    SheetGroup& sizes = group("dimensions");
    for (const PlanRoom& room : plan_.rooms) {
      for (const RoomSpan& span : room_spans(room, plan_))
        if (mm_per_m() * span.length_m() >= 9.0)
          dimension(sizes, mm(span.from), mm(span.to), span.length_m(), 1.8);
    }
    const Eigen::Vector2d low = mm(box_.low);
    const Eigen::Vector2d high = mm(box_.high);
    constexpr double kOutMm = 8.0;
    const auto helper = [&](const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
      line(sizes, from, to, line_style(0.1, kSizeTone));
    };
    helper({low.x(), low.y() - 1.5}, {low.x(), low.y() - kOutMm - 1.5});
    helper({high.x(), low.y() - 1.5}, {high.x(), low.y() - kOutMm - 1.5});
    helper({low.x() - 1.5, low.y()}, {low.x() - kOutMm - 1.5, low.y()});
    helper({low.x() - 1.5, high.y()}, {low.x() - kOutMm - 1.5, high.y()});
    dimension(sizes, {low.x(), low.y() - kOutMm}, {high.x(), low.y() - kOutMm}, box_.size().x(),
              2.5);
    dimension(sizes, {low.x() - kOutMm, low.y()}, {low.x() - kOutMm, high.y()}, box_.size().y(),
              2.5);
  }

  void add_labels() {
    SheetGroup& labels = group("labels");
    for (std::size_t i = 0; i < plan_.rooms.size(); ++i) {
      const PlanRoom& room = plan_.rooms[i];
      const Eigen::Vector2d at = mm(label_place(room));
      const auto text = [&](double down_mm, double size_mm, bool bold, std::string words) {
        labels.texts.push_back({.at = at - Eigen::Vector2d(0.0, down_mm),
                                .size_mm = size_mm,
                                .anchor = 0.5,
                                .bold = bold,
                                .colour = kInk,
                                .words = std::move(words)});
      };
      text(-1.2, 2.6, true, fmt::format("R{}", i + 1));
      text(1.8, 2.3, false, fmt::format("{:.2f} m²", room.area_m2));
      text(4.3, 1.5, false,
           room.is_closed() ? fmt::format("± {:.2f}", room.area_sigma_m2)
                            : std::string("not all seen"));
    }
  }

  void add_title() {
    SheetGroup& title = group("title");
    const double top = kMarginMm + kTitleMm;
    const double left = kMarginMm + 6.0;
    double area_m2 = 0.0;
    for (const PlanRoom& room : plan_.rooms) area_m2 += room.area_m2;
    title.texts.push_back({.at = {left, top - 8.0},
                           .size_mm = 4.2,
                           .bold = true,
                           .colour = kInk,
                           .words = title_.name});
    title.texts.push_back({.at = {left, top - 13.5},
                           .size_mm = 2.5,
                           .colour = kInk,
                           .words = fmt::format("Floor plan 1 : {}   {}   dimensions in metres",
                                                layout_.scale, layout_.paper.name)});
    title.texts.push_back({.at = {left, top - 17.5},
                           .size_mm = 2.5,
                           .colour = kInk,
                           .words = fmt::format("rooms: {}, {:.1f} m²   doors: {}",
                                                plan_.rooms.size(), area_m2, plan_.doors.size())});
    title.texts.push_back(
        {.at = {left, top - 21.5},
         .size_mm = 2.0,
         .colour = kThingTone,
         .words =
             fmt::format("measured by laser at one height; lines through {}; drawn by Loopstone",
                         plan_.from_scans ? "scans" : "cells of the map")});
    add_scale_bar(title, {0.40 * sheet_.width_mm, top - 13.0});
    add_legend(title, {sheet_.width_mm - kMarginMm - 78.0, top - 6.0});
    add_arrow(title, {sheet_.width_mm - kMarginMm - 12.0, top - 0.5 * kTitleMm});
  }

  void add_scale_bar(SheetGroup& title, const Eigen::Vector2d& at) const {
    const double part_m = round_down(50.0 / mm_per_m()) / 5.0;
    for (int i = 0; i < 5; ++i) {
      const Eigen::Vector2d low = at + Eigen::Vector2d(i * part_m * mm_per_m(), 0.0);
      SheetStyle style = line_style(0.18, kInk);
      style.filled = true;
      style.fill = i % 2 == 0 ? kInk : 0xffffff;
      rectangle(title, low, low + Eigen::Vector2d(part_m * mm_per_m(), 1.6), style);
    }
    for (const int i : {0, 1, 5})
      title.texts.push_back({.at = at + Eigen::Vector2d(i * part_m * mm_per_m(), -3.2),
                             .size_mm = 2.2,
                             .anchor = 0.5,
                             .colour = kInk,
                             .words = fmt::format("{:g}{}", i * part_m, i == 5 ? " m" : "")});
  }

  static void add_legend(SheetGroup& title, const Eigen::Vector2d& at) {
    const std::array<std::pair<SheetStyle, const char*>, 4> entries{
        {{line_style(0.35, kInk), "wall, seen"},
         {line_style(0.25, kInk, {1.2, 0.8}), "wall behind furniture"},
         {line_style(0.18, kThingTone), "furniture and other things"},
         {line_style(0.18, kSizeTone, {0.4, 1.0}), "end of what was seen"}}};
    for (std::size_t i = 0; i < entries.size(); ++i) {
      const Eigen::Vector2d row = at - Eigen::Vector2d(0.0, 4.2 * static_cast<double>(i));
      line(title, row, row + Eigen::Vector2d(9.0, 0.0), entries[i].first);
      title.texts.push_back({.at = row + Eigen::Vector2d(12.0, -0.8),
                             .size_mm = 2.2,
                             .colour = kInk,
                             .words = entries[i].second});
    }
  }

  /// True north where it is known, else the map's x and y.
  void add_arrow(SheetGroup& title, const Eigen::Vector2d& at) const {
    const auto arrow = [&](const Eigen::Vector2d& from, double yaw, double length_mm,
                           const char* words) {
      const Eigen::Vector2d u(std::cos(yaw), std::sin(yaw));
      const Eigen::Vector2d v(-u.y(), u.x());
      const Eigen::Vector2d tip = from + length_mm * u;
      line(title, from, tip - 2.0 * u, line_style(0.3, kInk));
      title.shapes.push_back(
          {{{tip, tip - 3.0 * u + 1.0 * v, tip - 3.0 * u - 1.0 * v}}, true, fill_style(kInk)});
      title.texts.push_back({.at = tip + 2.0 * u - Eigen::Vector2d(0.0, 0.8),
                             .size_mm = 2.5,
                             .anchor = 0.5,
                             .bold = true,
                             .colour = kInk,
                             .words = words});
    };
    if (title_.north_rad) {
      const Eigen::Vector2d u(std::cos(*title_.north_rad), std::sin(*title_.north_rad));
      arrow(at - 6.0 * u, *title_.north_rad, 12.0, "N");
      return;
    }
    const double yaw = title_.map_yaw_rad;
    const Eigen::Vector2d from = at - Eigen::Vector2d(5.0, 6.0);
    arrow(from, yaw, 10.0, "x");
    arrow(from, yaw + 0.5 * kPi, 10.0, "y");
  }

  const VectorPlan& plan_;
  const PlanTitle& title_;
  PlanBox box_;
  Layout layout_;
  Eigen::Vector2d corner_mm_{0.0, 0.0};
  PlanSheet sheet_{};
};

}  // namespace

PlanSheet draw_plan_sheet(const VectorPlan& plan, const PlanTitle& title) {
  return SheetDrawer(plan, title).draw();
}

PlanTitle plan_title(std::string name, const Pose2& plan_T_map,
                     const std::optional<GeoAnchor>& anchor) {
  PlanTitle title{.name = std::move(name), .map_yaw_rad = plan_T_map.yaw};
  if (anchor) title.north_rad = wrap_angle(plan_T_map.yaw + radians(anchor->bearing_deg));
  return title;
}

}  // namespace loopstone
