#include "pipeline/site_books.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>

#include "loopstone/base/error.hpp"
#include "loopstone/pipeline/site.hpp"

namespace loopstone {

std::string now_text() {
  using std::chrono::duration_cast, std::chrono::nanoseconds, std::chrono::system_clock;
  return utc_text({duration_cast<nanoseconds>(system_clock::now().time_since_epoch()).count()});
}

const SiteSession& find_session(const std::vector<SiteSession>& sessions, std::int64_t id,
                                const std::string& path) {
  const auto session = std::ranges::find(sessions, id, &SiteSession::id);
  if (session == sessions.end()) {
    throw UsageError(
        fmt::format("{}: there is no session {}; `loopstone site show` lists them", path, id));
  }
  return *session;
}

}  // namespace loopstone
