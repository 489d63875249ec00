#include "loopstone/formats/left_out.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "formats/left_out_json.hpp"

namespace loopstone {
namespace {

constexpr std::size_t kReasonsTold = 3;

double share_of(std::int64_t part, std::int64_t whole) {
  return whole == 0 ? 0.0 : static_cast<double>(part) / static_cast<double>(whole);
}

/// Rounded towards the middle: a few that are left are not "100 %", nor are a few that are missing
/// "0 %".
std::string percent_text(double share) {
  const double percent = 100.0 * share;
  if (percent <= 0.0 || percent >= 100.0) return fmt::format("{:.0f} %", percent);
  if (percent < 0.1) return "below 0.1 %";
  return fmt::format("{:.1f} %", std::min(std::round(10.0 * percent) / 10.0, 99.9));
}

std::string part_text(std::int64_t part, std::int64_t whole, const char* what) {
  return fmt::format("{} of {} {} ({})", part, whole, what, percent_text(share_of(part, whole)));
}

}  // namespace

double LeftOut::scan_share() const { return share_of(skipped.scans, scans()); }
double LeftOut::record_share() const { return share_of(skipped.records, records()); }
double LeftOut::share() const { return std::max(scan_share(), record_share()); }

std::string LeftOut::sentence() const {
  const bool of_scans = skipped.scans > 0;
  std::string text = of_scans ? part_text(skipped.scans, scans(), "scans")
                              : part_text(skipped.records, records(), "records");
  if (of_scans && skipped.records > skipped.scans) {
    text += " and " + part_text(skipped.records, records(), "records in all");
  }
  text += " were left out";
  if (since_s) text += fmt::format(" since {:.1f} s", *since_s);
  std::vector<SkipReason> reasons = skipped.reasons;
  std::stable_sort(reasons.begin(), reasons.end(),
                   [](const SkipReason& a, const SkipReason& b) { return a.records > b.records; });
  for (std::size_t i = 0; i < std::min(reasons.size(), kReasonsTold); ++i) {
    text += fmt::format("{}{} ({} times, first {})", i == 0 ? ": " : "; ", reasons[i].reason,
                        reasons[i].records, to_string(reasons[i].first));
  }
  if (reasons.size() > kReasonsTold) text += "; and for other reasons";
  return text;
}

nlohmann::ordered_json to_json(const LeftOut& left_out) {
  nlohmann::ordered_json json = {{"share", left_out.share()},
                                 {"scan_share", left_out.scan_share()},
                                 {"scans", left_out.skipped.scans},
                                 {"scans_of", left_out.scans()},
                                 {"record_share", left_out.record_share()},
                                 {"records", left_out.skipped.records},
                                 {"records_of", left_out.records()},
                                 {"since_s", nullptr},
                                 {"reasons", nlohmann::ordered_json::array()}};
  if (left_out.since_s) json["since_s"] = *left_out.since_s;
  for (const SkipReason& reason : left_out.skipped.reasons) {
    json["reasons"].push_back({{"records", reason.records},
                               {"reason", reason.reason},
                               {"first", to_string(reason.first)}});
  }
  return json;
}

std::string left_out_json(const LeftOut& left_out) {
  // Words of a damaged log need not be UTF-8; JSON must.
  constexpr auto kReplace = nlohmann::ordered_json::error_handler_t::replace;
  return to_json(left_out).dump(-1, ' ', false, kReplace);
}

}  // namespace loopstone
