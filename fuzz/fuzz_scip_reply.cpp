#include <algorithm>
#include <cmath>

#include "devices/scip_text.hpp"
#include "refusal.hpp"

namespace loopstone {
namespace {

/// Beams of the scans that are looked for: those of the seeds.
constexpr int kLastStep = 24;

std::vector<ScipReply> replies_of(std::string_view bytes, std::size_t piece,
                                  const std::string& echo) {
  ScipReplies replies;
  replies.expect_echo(echo);
  std::vector<ScipReply> all;
  while (!bytes.empty()) {
    replies.add(bytes.substr(0, piece));
    bytes.remove_prefix(std::min(piece, bytes.size()));
    while (auto reply = replies.next()) all.push_back(*std::move(reply));
  }
  return all;
}

void expect(bool law) {
  if (!law) __builtin_trap();
}

void read(const ScipReply& reply, const ScipRequest& request) {
  (void)words_of_status(reply.echo, reply.status());
  (void)scip_facts(reply);
  const auto scan = decode_scip_scan(reply, request);
  if (!scan) return;
  expect(scan->ranges.size() == static_cast<std::size_t>(request.beams()));
  const ScipRanges ranges{20, 30000};
  for (const std::uint32_t number : scan->ranges) {
    const float range_m = ranges.range_m(number);
    expect(!(range_m < 0.02F) && (std::isinf(range_m) || !(range_m > 30.0F)));
  }
}

void try_replies(std::string_view bytes) {
  for (const bool intensities : {false, true}) {
    const ScipRequest request{.last_step = kLastStep, .intensities = intensities};
    const auto whole = replies_of(bytes, std::max<std::size_t>(1, bytes.size()), request.command());
    const auto pieces = replies_of(bytes, 7, request.command());
    expect(whole.size() == pieces.size());
    for (std::size_t i = 0; i < whole.size(); ++i) {
      expect(whole[i].echo == pieces[i].echo && whole[i].lines == pieces[i].lines);
      read(whole[i], request);
    }
  }
}

}  // namespace
}  // namespace loopstone

// What a scanner sends, in pieces of any size: replies are the same, and scans have all their
// beams.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view bytes = loopstone::fuzz::text_of(data, size);
  return loopstone::fuzz::expect_work_or_refusal(bytes, [&] { loopstone::try_replies(bytes); });
}
