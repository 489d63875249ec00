#include "formats/stamp_order.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <tuple>
#include <utility>

namespace loopstone {
namespace {

std::size_t bytes_of(const OrderedRecord& record) {
  const auto* scan = std::get_if<LaserScan>(&record.message);
  return sizeof(OrderedRecord) + (scan ? scan->ranges_m.capacity() * sizeof(float) : 0);
}

/// Among equal stamps odometry comes first, so that it is there when the scan is.
int rank_of(const OrderedRecord& record) {
  if (std::holds_alternative<LaserScan>(record.message)) return 2;
  return record.is_part_of_a_scan ? 0 : 1;
}

/// Difference in seconds for people; stamps from rubbish may be so far apart that integers
/// overflow.
double seconds_between(Stamp later, Stamp earlier) { return later.seconds() - earlier.seconds(); }

std::string seconds_text(double seconds) {
  char text[40];
  std::snprintf(text, sizeof text, std::abs(seconds) < 100.0 ? "%.3f s" : "%.0f s", seconds);
  return text;
}

}  // namespace

StampOrder::StampOrder(bool scans_lead, std::optional<Stamp> early,
                       std::function<void(const OrderedRecord&, const std::string&)> skip,
                       Duration window)
    : scans_lead_(scans_lead), early_(early), skip_(std::move(skip)), window_(window) {}

bool StampOrder::comes_later(const Waiting& a, const Waiting& b) {
  return std::tie(a.stamp, a.rank, a.number) > std::tie(b.stamp, b.rank, b.number);
}

bool StampOrder::leads(const OrderedRecord& record) const {
  return !scans_lead_ || std::holds_alternative<LaserScan>(record.message);
}

void StampOrder::push(OrderedRecord record) {
  const Stamp stamp = stamp_of(record.message);
  note_order(stamp, record.is_part_of_a_scan || record.is_brought_together);
  if (window_ == kNone) {
    // A scan comes before its odometry, and is to be used behind it.
    const bool is_behind = record.is_part_of_a_scan && !passing_.empty();
    passing_.insert(is_behind ? std::prev(passing_.end()) : passing_.end(), std::move(record));
  } else if (leads(record)) {
    lead(std::move(record));
  } else if (record.is_part_of_a_scan && !pending_.empty() &&
             stamp == stamp_of(pending_.back().message)) {
    pending_.push_back(std::move(record));  // shares the fate of its scan
  } else {
    enqueue(std::move(record));
  }
}

/// Counts the records that stand after a later one; a stamp from elsewhere does not count for those
/// around it.
void StampOrder::note_order(Stamp stamp, bool may_be_late) {
  const bool near = newest_ && std::abs(seconds_between(stamp, *newest_)) <= kJump.seconds();
  if (near && stamp < *newest_ && !may_be_late) {
    ++out_of_order_;
    largest_step_back_ = std::max(largest_step_back_, *newest_ - stamp);
  }
  if (!near || stamp > *newest_) newest_ = stamp;
}

void StampOrder::lead(OrderedRecord record) {
  const Stamp stamp = stamp_of(record.message);
  const bool jumps = !now_ || seconds_between(stamp, *now_) > kJump.seconds();
  if (!jumps) {
    refuse_pending();
    now_ = std::max(*now_, stamp);
    enqueue(std::move(record));
    return;
  }
  if (!pending_.empty()) {
    const double step_s = seconds_between(stamp, stamp_of(pending_.back().message));
    if (step_s < -kJump.seconds()) refuse_pending();
    if (step_s > kJump.seconds()) believe_pending();
  }
  pending_.push_back(std::move(record));
  if (pending_.size() >= kRecordsToBelieveAJump) believe_pending();
}

void StampOrder::believe_pending() {
  for (OrderedRecord& record : pending_) {
    const Stamp stamp = stamp_of(record.message);
    now_ = now_ ? std::max(*now_, stamp) : stamp;
    enqueue(std::move(record));
  }
  pending_.clear();
}

void StampOrder::refuse_pending() {
  for (const OrderedRecord& record : pending_) {
    const Stamp stamp = stamp_of(record.message);
    const std::string reason = now_ ? "the stamp lies " +
                                          seconds_text(seconds_between(stamp, *now_)) +
                                          " ahead of the records around it"
                                    : "the stamp does not fit those of the records after it";
    if (!record.is_part_of_a_scan) skip_(record, reason);
  }
  pending_.clear();
}

void StampOrder::enqueue(OrderedRecord record) {
  const Stamp stamp = stamp_of(record.message);
  if (last_out_ && stamp < *last_out_) {
    if (record.is_part_of_a_scan) return;
    skip_(record, "the stamp goes back by " + seconds_text(seconds_between(*last_out_, stamp)) +
                      ", too far to be put in order");
    return;
  }
  waiting_bytes_ += bytes_of(record);
  const int rank = rank_of(record);
  heap_.push_back({std::move(record), stamp, rank, number_++});
  std::push_heap(heap_.begin(), heap_.end(), comes_later);
  make_room();
}

/// Keeps odometry whose clock runs far ahead of the scans' from filling the memory.
void StampOrder::make_room() {
  if (!scans_lead_ || heap_.size() < kMostWaiting) return;
  const auto clock = now_ ? now_ : early_;
  if (!clock || seconds_between(heap_.front().stamp, *clock) <= kJump.seconds()) return;
  // A quarter at once, so that the cost per record stays small. Sorted by stamp it is still a heap.
  std::sort(heap_.begin(), heap_.end(),
            [](const Waiting& a, const Waiting& b) { return comes_later(b, a); });
  while (heap_.size() > kMostWaiting / 4 * 3) {
    const Waiting& last = heap_.back();
    skip_(last.record, "the stamp of this odometry lies " +
                           seconds_text(seconds_between(last.stamp, *clock)) +
                           " ahead of the laser's");
    waiting_bytes_ -= bytes_of(last.record);
    heap_.pop_back();
  }
}

void StampOrder::close() {
  closed_ = true;
  believe_pending();
}

StampOrder::Waiting StampOrder::take() {
  std::pop_heap(heap_.begin(), heap_.end(), comes_later);
  Waiting first = std::move(heap_.back());
  heap_.pop_back();
  waiting_bytes_ -= bytes_of(first.record);
  return first;
}

std::optional<OrderedRecord> StampOrder::pop() {
  if (!passing_.empty()) {
    std::optional<OrderedRecord> first(std::move(passing_.front()));
    passing_.pop_front();
    return first;
  }
  while (!heap_.empty()) {
    const bool full = heap_.size() >= kMostWaiting || waiting_bytes_ >= kMostWaitingBytes;
    const bool ripe = now_ && heap_.front().stamp + window_ <= *now_;
    if (!closed_ && !full && !ripe) return std::nullopt;

    Waiting first = take();
    auto* const scan = std::get_if<LaserScan>(&first.record.message);
    const bool is_pose = std::holds_alternative<OdometryPose>(first.record.message);
    auto& last = scan      ? last_scan_out_[scan->lidar]
                 : is_pose ? last_odometry_out_
                           : last_other_out_[first.record.message.index()];
    if (last == first.stamp) {
      if (scan) skip_(first.record, "a scan with the same stamp came before");
      if (!scan && !is_pose) skip_(first.record, "a reading with the same stamp came before");
      // A scan's own odometry and a line of odometry of the same moment say the same.
      if (is_pose && !last_odometry_is_of_a_scan_) {
        skip_(first.record, "odometry with the same stamp came before");
      }
      continue;
    }
    last = first.stamp;
    if (is_pose) last_odometry_is_of_a_scan_ = first.record.is_part_of_a_scan;
    last_out_ = first.stamp;
    return std::move(first.record);
  }
  return std::nullopt;
}

}  // namespace loopstone
