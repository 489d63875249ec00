#include "loopstone/formats/site_edit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "formats/quoted_word.hpp"
#include "formats/text_numbers.hpp"
#include "loopstone/base/error.hpp"

namespace loopstone {

namespace {

constexpr std::size_t kMostCorners = 1000;
constexpr double kFarthestM = 1e6;

std::optional<double> number_in(std::string_view text) {
  const auto number = parse_number(text);
  return number && std::abs(*number) <= kFarthestM ? number : std::nullopt;
}

Eigen::Vector2d corner_in(std::string_view word) {
  const std::size_t comma = word.find(',');
  if (comma != std::string_view::npos) {
    const auto x = number_in(word.substr(0, comma));
    const auto y = number_in(word.substr(comma + 1));
    if (x && y) return {*x, *y};
  }
  throw UsageError(quoted(word) + " is no corner; write X,Y in metres of the map, such as 1.5,-2");
}

}  // namespace

Polygon2 parse_polygon(std::string_view text) {
  constexpr std::string_view kSpace = " \t\r\n";
  Polygon2 polygon;
  for (std::size_t at = text.find_first_not_of(kSpace); at != std::string_view::npos;) {
    const std::size_t end = std::min(text.find_first_of(kSpace, at), text.size());
    polygon.corners.push_back(corner_in(text.substr(at, end - at)));
    if (polygon.corners.size() > kMostCorners)
      throw UsageError(fmt::format("a polygon may have {} corners", kMostCorners));
    at = text.find_first_not_of(kSpace, end);
  }
  if (const auto fault = fault_of(polygon)) throw UsageError("a polygon must " + *fault);
  return polygon;
}

std::string polygon_text(const Polygon2& polygon) {
  std::string text;
  for (const Eigen::Vector2d& corner : polygon.corners)
    text += fmt::format("{}{},{}", text.empty() ? "" : " ", corner.x(), corner.y());
  return text;
}

}  // namespace loopstone
