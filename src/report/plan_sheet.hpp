#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>
#include <vector>

#include "loopstone/report/plan_outputs.hpp"

namespace loopstone {

/// How a shape on a sheet looks.
struct SheetStyle {
  double width_mm = 0.0;  ///< of its line; 0: none
  unsigned line = 0x000000;
  std::vector<double> dashes_mm{};
  bool filled = false;
  unsigned fill = 0xffffff;
};

/// A line or a polygon with holes (even-odd).
struct SheetShape {
  std::vector<std::vector<Eigen::Vector2d>> rings{};  ///< [mm]
  bool closed = false;
  SheetStyle style{};
};

struct SheetText {
  Eigen::Vector2d at{0.0, 0.0};  ///< on the base line [mm]
  double size_mm = 3.0;
  double anchor = 0.0;    ///< 0: `at` is its left end, 0.5: its middle, 1: its right end
  double turn_deg = 0.0;  ///< counter-clockwise
  bool bold = false;
  unsigned colour = 0x000000;
  std::string words{};  ///< UTF-8 of Latin-1
};

/// What lies on each other in one group: shapes, then texts.
struct SheetGroup {
  std::string id{};
  std::vector<SheetShape> shapes{};
  std::vector<SheetText> texts{};
};

/// A sheet of paper: millimetres from its lower left corner, y up.
struct PlanSheet {
  double width_mm = 297.0;
  double height_mm = 210.0;
  std::vector<SheetGroup> groups{};  ///< the first lies lowest
};

[[nodiscard]] PlanSheet draw_plan_sheet(const VectorPlan& plan, const PlanTitle& title);

/// Of a text in Helvetica, of size 1.
/// Source: Adobe, "Font Metrics for Base 14 Fonts", Helvetica and Helvetica-Bold.
[[nodiscard]] double helvetica_width(std::string_view utf8, bool bold);
/// As Latin-1; what it has not becomes '?'.
[[nodiscard]] std::string latin1_of(std::string_view utf8);

}  // namespace loopstone
