#pragma once

#include <string_view>

namespace loopstone {

/// The page that shows it all: viewer/built/index.html as it was when the program was built, or a
/// page that says that there was none.
[[nodiscard]] std::string_view view_page();

}  // namespace loopstone
