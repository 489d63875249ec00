#include <fmt/format.h>

#include <iterator>

#include "report/plan_sheet.hpp"
#include "report/text.hpp"

namespace loopstone {

namespace {

std::string colour_text(unsigned rgb) { return fmt::format("#{:06x}", rgb); }

/// The one place where y is turned over: paper has it upwards, SVG downwards.
class SvgWriter {
 public:
  explicit SvgWriter(const PlanSheet& sheet) : sheet_(sheet) {
    put("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<svg xmlns=\"http://www.w3.org/2000/svg\" "
        "width=\"{0:g}mm\" height=\"{1:g}mm\" viewBox=\"0 0 {0:g} {1:g}\" "
        "font-family=\"Helvetica, Arial, 'Liberation Sans', sans-serif\">\n",
        sheet.width_mm, sheet.height_mm);
    put("<rect width=\"{:g}\" height=\"{:g}\" fill=\"#ffffff\"/>\n", sheet.width_mm,
        sheet.height_mm);
    for (const SheetGroup& group : sheet.groups) add(group);
    put("</svg>\n");
  }
  [[nodiscard]] std::string take() { return std::move(text_); }

 private:
  template <typename... Values>
  void put(fmt::format_string<Values...> format, Values&&... values) {
    fmt::format_to(std::back_inserter(text_), format, std::forward<Values>(values)...);
  }

  void add(const SheetGroup& group) {
    put("<g id=\"{}\">\n", escape_html(group.id));
    for (const SheetShape& shape : group.shapes) add(shape);
    for (const SheetText& text : group.texts) add(text);
    put("</g>\n");
  }

  void add(const SheetShape& shape) {
    put("<path d=\"");
    for (const auto& ring : shape.rings) {
      for (std::size_t i = 0; i < ring.size(); ++i)
        put("{}{:.3f} {:.3f}", i == 0 ? 'M' : 'L', ring[i].x(), sheet_.height_mm - ring[i].y());
      if (shape.closed) put("Z");
    }
    const SheetStyle& style = shape.style;
    put("\" fill=\"{}\"", style.filled ? colour_text(style.fill) : "none");
    if (style.filled) put(" fill-rule=\"evenodd\"");
    if (style.width_mm > 0.0) {
      put(" stroke=\"{}\" stroke-width=\"{:g}\" stroke-linejoin=\"miter\"", colour_text(style.line),
          style.width_mm);
      if (!shape.closed) put(" stroke-linecap=\"{}\"", style.dashes_mm.empty() ? "square" : "butt");
    }
    for (std::size_t i = 0; i < style.dashes_mm.size(); ++i)
      put("{}{:g}", i == 0 ? " stroke-dasharray=\"" : " ", style.dashes_mm[i]);
    put("{}/>\n", style.dashes_mm.empty() ? "" : "\"");
  }

  void add(const SheetText& text) {
    const double y = sheet_.height_mm - text.at.y();
    put("<text x=\"{:.3f}\" y=\"{:.3f}\" font-size=\"{:g}\" fill=\"{}\"", text.at.x(), y,
        text.size_mm, colour_text(text.colour));
    if (text.bold) put(" font-weight=\"bold\"");
    if (text.anchor > 0.0) put(" text-anchor=\"{}\"", text.anchor > 0.75 ? "end" : "middle");
    if (text.turn_deg != 0.0)
      put(" transform=\"rotate({:g} {:.3f} {:.3f})\"", -text.turn_deg, text.at.x(), y);
    put(">{}</text>\n", escape_html(text.words));
  }

  const PlanSheet& sheet_;
  std::string text_{};
};

}  // namespace

std::string format_plan_svg(const VectorPlan& plan, const PlanTitle& title) {
  return SvgWriter(draw_plan_sheet(plan, title)).take();
}

}  // namespace loopstone
