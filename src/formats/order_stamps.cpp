#include "formats/order_stamps.hpp"

#include <utility>

namespace loopstone {

bool OrderStamps::begins_a_period(const OrderedRecord& record) const {
  if (held_.empty()) return false;
  if (!scans_lead_ || held_.size() >= kMostInAPeriod) return true;
  const auto* scan = std::get_if<LaserScan>(&record.message);
  return scan != nullptr && (lidars_.empty() || lidars_.count(scan->lidar) > 0);
}

void OrderStamps::push(OrderedRecord record) {
  if (record.is_part_of_a_scan && !held_.empty()) {
    const auto of_scan = held_.end() - 1;
    held_.insert(of_scan, {std::move(record), of_scan->place});
    return;
  }
  if (begins_a_period(record)) end_period();
  if (const auto* scan = std::get_if<LaserScan>(&record.message)) lidars_.insert(scan->lidar);
  held_.push_back({std::move(record), places_++});
}

void OrderStamps::end_period() {
  if (held_.empty()) return;
  ready_.erase(ready_.begin(), ready_.begin() + static_cast<std::ptrdiff_t>(next_ready_));
  next_ready_ = 0;
  for (Held& held : held_) {
    const Stamp stamp = start_ + Duration{period_.nanoseconds * held.place / places_};
    std::visit([stamp](auto& message) { message.stamp = stamp; }, held.record.message);
    ready_.push_back(std::move(held.record));
  }
  held_.clear();
  lidars_.clear();
  places_ = 0;
  start_ = start_ + period_;
}

std::optional<OrderedRecord> OrderStamps::pop() {
  if (next_ready_ == ready_.size()) return std::nullopt;
  return std::move(ready_[next_ready_++]);
}

}  // namespace loopstone
