#include <variant>

#include "formats/carmen_reader.hpp"
#include "loopstone/formats/log_summary.hpp"
#include "loopstone/slam/mapper.hpp"
#include "refusal.hpp"

namespace {

/// Of a log, so that a map takes milliseconds.
constexpr int kMostMessages = 60;
constexpr std::size_t kMostBeams = 400;

loopstone::MapOptions options() {
  loopstone::MapOptions options;
  options.front_end.submap_length_m = 0.5;
  options.map.resolution_m = 0.25;
  return options;
}

void map(std::string_view bytes) {
  const auto log = loopstone::read_carmen_log(bytes, {});
  loopstone::Mapper mapper(log->robot({}), options(), loopstone::Threads{1});
  for (int i = 0; i < kMostMessages; ++i) {
    auto message = log->next();
    if (!message) break;
    if (auto* scan = std::get_if<loopstone::LaserScan>(&*message)) {
      if (scan->ranges_m.size() > kMostBeams) scan->ranges_m.resize(kMostBeams);
    }
    mapper.add(*message);
  }
  (void)mapper.finish();
}

}  // namespace

// Plain, gzip and bzip2 alike: the reader looks at the first bytes.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace loopstone;
  return fuzz::expect_work_or_refusal(fuzz::text_of(data, size), [&] {
    const std::string_view bytes = fuzz::text_of(data, size);
    const auto log = read_carmen_log(bytes, {});
    (void)analyse_log(*log);
    (void)log->notes();
    if (fuzz::goes_on()) map(bytes);
  });
}
