#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "loopstone/base/words.hpp"
#include "loopstone/geometry/polygon.hpp"

// What somebody corrects in a site by hand. Sessions stay as they are, so all of it can be undone.

namespace loopstone {

enum class SiteEditKind {
  kExclude,  ///< a session is no part of the map
  kFree,     ///< the cells of a polygon, whatever was seen there
  kWall,
  kUnknown,
};

constexpr auto words_of(SiteEditKind /*any*/) {
  using enum SiteEditKind;
  return std::array{Word{kExclude, "exclude"}, Word{kFree, "free"}, Word{kWall, "wall"},
                    Word{kUnknown, "unknown"}};
}

/// What a polygon lies on, so that it stays there when the map moves.
struct SiteAnchor {
  std::int64_t session = 0;
  std::int64_t submap = 0;  ///< counted within the session
  friend bool operator==(const SiteAnchor&, const SiteAnchor&) = default;
};

struct SiteEdit {
  std::int64_t id = 0;  ///< given by the file; no two edits of a site ever have the same
  std::string at{};     ///< when it was done, ISO 8601, UTC
  SiteEditKind kind = SiteEditKind::kExclude;
  std::int64_t excluded = 0;           ///< a session; of the other kinds 0
  std::optional<SiteAnchor> anchor{};  ///< of a polygon; nothing: it is told in the map's frame
  Polygon2 polygon{};                  ///< in the frame of its anchor; of an exclusion empty
};

/// Reads "x1,y1 x2,y2 x3,y3 ..." [m]. Throws UsageError that says what is wrong with it: what is no
/// number, fewer than three corners or more than a thousand, sides that cross, a place on another
/// continent.
[[nodiscard]] Polygon2 parse_polygon(std::string_view text);
/// The same corners read back.
[[nodiscard]] std::string polygon_text(const Polygon2& polygon);

}  // namespace loopstone
