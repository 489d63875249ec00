#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <set>
#include <vector>

#include "formats/stamp_order.hpp"
#include "loopstone/base/stamp.hpp"

namespace loopstone {

/// Makes up stamps for records that have none to be trusted: in the order of the file, as if scans
/// came at one rate. Counts from 0.
///
/// Time goes by in periods. A scan begins the next one when its lidar had a scan in this one
/// already; what stands behind it, up to the next such scan, is spread evenly over the period. So
/// lasers may come and go, and odometry may come at any rate. Bounded memory.
class OrderStamps {
 public:
  /// A period with more records ends without a scan.
  static constexpr std::size_t kMostInAPeriod = 4096;

  /// \param period      between two scans of a lidar, positive
  /// \param scans_lead  else, in a log without scans, every record begins a period
  OrderStamps(Duration period, bool scans_lead) : period_(period), scans_lead_(scans_lead) {}

  /// A scan's own odometry is pushed right after the scan, and comes out before it with its stamp.
  void push(OrderedRecord record);
  /// No more records come: everything may go out.
  void close() { end_period(); }
  /// The next record, when its stamp is known.
  [[nodiscard]] std::optional<OrderedRecord> pop();

 private:
  struct Held {
    OrderedRecord record;
    std::int64_t place = 0;
  };
  [[nodiscard]] bool begins_a_period(const OrderedRecord& record) const;
  void end_period();

  Duration period_;
  bool scans_lead_;
  std::vector<Held> held_{};  ///< of this period
  std::int64_t places_ = 0;
  std::set<int> lidars_{};  ///< that had a scan in it
  Stamp start_{};
  std::vector<OrderedRecord> ready_{};
  std::size_t next_ready_ = 0;
};

}  // namespace loopstone
