#include "formats/rawlog_reader.hpp"
#include "loopstone/formats/log_summary.hpp"
#include "refusal.hpp"

// Plain and gzip alike: the reader looks at the first bytes.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace loopstone;
  return fuzz::expect_work_or_refusal(fuzz::text_of(data, size), [&] {
    const auto log = read_rawlog(fuzz::text_of(data, size), {});
    (void)analyse_log(*log);
    (void)log->notes();
    (void)log->warnings();
    (void)log->robot({});
    LogOptions by_order;
    by_order.stamps = StampUse::kOrder;
    (void)analyse_log(*read_rawlog(fuzz::text_of(data, size), by_order));
  });
}
