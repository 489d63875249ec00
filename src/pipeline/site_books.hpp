#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "loopstone/formats/site_file.hpp"

// What changes of a site have in common.

namespace loopstone {

/// By the machine's clock: ISO 8601, UTC.
[[nodiscard]] std::string now_text();

/// Throws UsageError, naming the site, when there is no such session.
[[nodiscard]] const SiteSession& find_session(const std::vector<SiteSession>& sessions,
                                              std::int64_t id, const std::string& path);

}  // namespace loopstone
