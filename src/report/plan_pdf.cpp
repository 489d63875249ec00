#include <fmt/format.h>

#include <array>
#include <cmath>
#include <iterator>
#include <vector>

#include "loopstone/geometry/angle.hpp"
#include "report/plan_sheet.hpp"

namespace loopstone {

namespace {

constexpr double kPointsPerMm = 72.0 / 25.4;

// Widths of the printable characters of ASCII in thousandths.
constexpr std::array<int, 95> kNormal{
    278,  278, 355, 556, 556, 889, 667, 191, 333, 333, 389, 584, 278, 333, 278, 278,  // space to /
    556,  556, 556, 556, 556, 556, 556, 556, 556, 556, 278, 278, 584, 584, 584, 556,  // 0 to ?
    1015, 667, 667, 722, 722, 667, 611, 778, 722, 278, 500, 667, 556, 833, 722, 778,  // @ to O
    667,  778, 722, 667, 611, 722, 667, 944, 667, 667, 611, 278, 278, 278, 469, 556,  // P to _
    333,  556, 556, 500, 556, 556, 278, 556, 556, 222, 222, 500, 222, 833, 556, 556,  // ` to o
    556,  556, 333, 500, 278, 556, 500, 722, 500, 500, 500, 334, 260, 334, 584};      // p to ~
constexpr std::array<int, 95> kBold{
    278, 333, 474, 556, 556, 889, 722, 238, 333, 333, 389, 584, 278, 333, 278, 278, 556, 556, 556,
    556, 556, 556, 556, 556, 556, 556, 333, 333, 584, 584, 584, 611, 975, 722, 722, 722, 722, 667,
    611, 778, 722, 278, 556, 722, 611, 833, 722, 778, 667, 778, 722, 667, 611, 722, 667, 944, 667,
    667, 611, 333, 278, 333, 584, 556, 333, 556, 611, 556, 611, 556, 333, 611, 611, 278, 278, 556,
    278, 889, 611, 611, 611, 611, 389, 556, 333, 611, 556, 778, 556, 556, 500, 389, 280, 389, 584};

/// A string between parentheses.
std::string pdf_string(std::string_view utf8) {
  std::string text = "(";
  for (const char c : latin1_of(utf8)) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 32 || byte > 126 || c == '(' || c == ')' || c == '\\')
      text += fmt::format("\\{:03o}", byte);
    else
      text += c;
  }
  return text + ")";
}

std::string colour_text(unsigned rgb) {
  return fmt::format("{:.3f} {:.3f} {:.3f}", ((rgb >> 16) & 255) / 255.0,
                     ((rgb >> 8) & 255) / 255.0, (rgb & 255) / 255.0);
}

/// The operators of a page, millimetres (PDF Reference 1.4, chapters 4 and 5).
class PageContent {
 public:
  explicit PageContent(const PlanSheet& sheet) {
    put("{0:.6f} 0 0 {0:.6f} 0 0 cm 2 J\n", kPointsPerMm);
    for (const SheetGroup& group : sheet.groups) {
      for (const SheetShape& shape : group.shapes) add(shape);
      for (const SheetText& text : group.texts) add(text);
    }
  }
  [[nodiscard]] std::string take() { return std::move(text_); }

 private:
  template <typename... Values>
  void put(fmt::format_string<Values...> format, Values&&... values) {
    fmt::format_to(std::back_inserter(text_), format, std::forward<Values>(values)...);
  }

  void add(const SheetShape& shape) {
    const SheetStyle& style = shape.style;
    const bool stroked = style.width_mm > 0.0;
    if (!stroked && !style.filled) return;
    if (style.filled) put("{} rg\n", colour_text(style.fill));
    if (stroked) {
      put("{} RG {:g} w [", colour_text(style.line), style.width_mm);
      for (const double dash : style.dashes_mm) put("{:g} ", dash);
      put("] 0 d {} J\n", style.dashes_mm.empty() ? 2 : 0);
    }
    for (const auto& ring : shape.rings) {
      for (std::size_t i = 0; i < ring.size(); ++i)
        put("{:.3f} {:.3f} {}\n", ring[i].x(), ring[i].y(), i == 0 ? 'm' : 'l');
      if (shape.closed) put("h\n");
    }
    put("{}\n", style.filled ? (stroked ? "B*" : "f*") : "S");
  }

  void add(const SheetText& text) {
    const double turn = radians(text.turn_deg);
    const double c = std::cos(turn);
    const double s = std::sin(turn);
    const double back = text.anchor * text.size_mm * helvetica_width(text.words, text.bold);
    put("BT {} rg /{} {:g} Tf {:.5f} {:.5f} {:.5f} {:.5f} {:.3f} {:.3f} Tm {} Tj ET\n",
        colour_text(text.colour), text.bold ? "B" : "N", text.size_mm, c, s, -s, c,
        text.at.x() - back * c, text.at.y() - back * s, pdf_string(text.words));
  }

  std::string text_{};
};

/// Objects one after another, then where each begins (PDF Reference 1.4, section 3.4).
std::string file_of(const std::vector<std::string>& objects) {
  std::string file = "%PDF-1.4\n%\xe2\xe3\xcf\xd3\n";
  std::vector<std::size_t> offsets;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    offsets.push_back(file.size());
    file += fmt::format("{} 0 obj\n{}\nendobj\n", i + 1, objects[i]);
  }
  const std::size_t table = file.size();
  file += fmt::format("xref\n0 {}\n0000000000 65535 f \n", objects.size() + 1);
  for (const std::size_t offset : offsets) file += fmt::format("{:010} 00000 n \n", offset);
  return file +
         fmt::format("trailer\n<< /Size {} /Root 1 0 R /Info 7 0 R >>\nstartxref\n{}\n%%EOF\n",
                     objects.size() + 1, table);
}

}  // namespace

std::string latin1_of(std::string_view utf8) {
  std::string text;
  for (std::size_t i = 0; i < utf8.size(); ++i) {
    const auto byte = static_cast<unsigned char>(utf8[i]);
    if (byte < 0x80) {
      text += utf8[i];
    } else if ((byte == 0xc2 || byte == 0xc3) && i + 1 < utf8.size()) {
      text += static_cast<char>((byte == 0xc3 ? 0x40 : 0) + static_cast<unsigned char>(utf8[++i]));
    } else if (byte >= 0xc0) {
      text += '?';  // and its following bytes are none of ours
    }
  }
  return text;
}

double helvetica_width(std::string_view utf8, bool bold) {
  double sum = 0.0;
  for (const char c : latin1_of(utf8)) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte >= 32 && byte < 127)
      sum += (bold ? kBold : kNormal)[byte - 32U];
    else if (byte == 0xb2 || byte == 0xb3)  // raised 2, 3
      sum += 333;
    else
      sum += 584;  // plus-minus, times; others are not far from it
  }
  return 1e-3 * sum;
}

std::string format_plan_pdf(const VectorPlan& plan, const PlanTitle& title) {
  const PlanSheet sheet = draw_plan_sheet(plan, title);
  const std::string content = PageContent(sheet).take();
  const auto font = [](const char* name) {
    return fmt::format("<< /Type /Font /Subtype /Type1 /BaseFont /{} /Encoding /WinAnsiEncoding >>",
                       name);
  };
  return file_of(
      {"<< /Type /Catalog /Pages 2 0 R >>", "<< /Type /Pages /Kids [3 0 R] /Count 1 >>",
       fmt::format("<< /Type /Page /Parent 2 0 R /MediaBox [0 0 {:.3f} {:.3f}] /Contents 4 0 R "
                   "/Resources << /Font << /N 5 0 R /B 6 0 R >> >> >>",
                   sheet.width_mm * kPointsPerMm, sheet.height_mm * kPointsPerMm),
       fmt::format("<< /Length {} >>\nstream\n{}\nendstream", content.size() + 1, content),
       font("Helvetica"), font("Helvetica-Bold"),
       fmt::format("<< /Title {} /Producer (Loopstone) >>", pdf_string(title.name))});
}

}  // namespace loopstone
