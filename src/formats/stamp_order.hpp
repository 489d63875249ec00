#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "loopstone/base/stamp.hpp"
#include "loopstone/sensor/messages.hpp"

namespace loopstone {

/// A message with the place it came from.
struct OrderedRecord {
  SensorMessage message;
  std::int64_t line = 0;
  /// Odometry that came with a scan rather than on a line of its own: it may be dropped in silence.
  bool is_part_of_a_scan = false;
  bool is_truth = false;  ///< a true pose of the robot: no message of the log
  /// Of several messages, which came one after the other: it is late without any disorder.
  bool is_brought_together = false;
};

/// Puts records whose stamps go back a little into the order of their stamps, with bounded memory.
///
/// Some recorders stamp a few records late or early (Intel: by up to 0.9 s), so a record waits
/// until the clock is kWindow past it. The clock is that of the scans when they carry odometry: a
/// scan is what can't be replaced, and no line of odometry with a stamp from elsewhere may push it
/// out. A jump ahead of more than kJump is believed only when several records agree on it; a single
/// one is a broken stamp.
class StampOrder {
 public:
  static constexpr Duration kWindow{2'000'000'000};
  /// The window with which nothing waits, nothing is put in order and nothing refused: what comes
  /// live is what its reader can bear.
  static constexpr Duration kNone{0};
  static constexpr Duration kJump{60'000'000'000};
  static constexpr std::size_t kMostWaiting = 4096;
  static constexpr std::size_t kMostWaitingBytes = std::size_t{1} << 24;
  static constexpr std::size_t kRecordsToBelieveAJump = 16;

  /// \param scans_lead  scans move the clock, odometry waits for them; else every record moves it
  /// \param skip        told about every record that can't come out
  /// \param window      by how much a record may come late
  /// \param early       a stamp that the scans are known to have near the beginning, if any is
  ///                    known
  StampOrder(bool scans_lead, std::optional<Stamp> early,
             std::function<void(const OrderedRecord&, const std::string&)> skip,
             Duration window = kWindow);

  /// A scan's own odometry is pushed right after the scan.
  void push(OrderedRecord record);
  /// No more records come: everything may go out.
  void close();
  /// The next record in order, when there is one that need not wait.
  [[nodiscard]] std::optional<OrderedRecord> pop();

  /// Records that came later than a record with a larger stamp, and by how much at most.
  [[nodiscard]] std::int64_t records_out_of_order() const { return out_of_order_; }
  [[nodiscard]] Duration largest_step_back() const { return largest_step_back_; }

 private:
  struct Waiting {
    OrderedRecord record;
    Stamp stamp;
    int rank;
    std::int64_t number;
  };
  static bool comes_later(const Waiting& a, const Waiting& b);

  [[nodiscard]] bool leads(const OrderedRecord& record) const;
  void note_order(Stamp stamp, bool may_be_late);
  void lead(OrderedRecord record);
  void enqueue(OrderedRecord record);
  void believe_pending();
  void refuse_pending();
  void make_room();
  [[nodiscard]] Waiting take();

  bool scans_lead_;
  std::optional<Stamp> early_;
  std::function<void(const OrderedRecord&, const std::string&)> skip_;
  Duration window_;
  std::deque<OrderedRecord> passing_{};  ///< with no window
  std::vector<Waiting> heap_;
  std::vector<OrderedRecord> pending_;
  std::optional<Stamp> now_;
  std::optional<Stamp> newest_;
  std::optional<Stamp> last_out_;
  std::optional<Stamp> last_odometry_out_;
  std::map<int, std::optional<Stamp>> last_scan_out_;           ///< by lidar
  std::map<std::size_t, std::optional<Stamp>> last_other_out_;  ///< by kind of message
  bool last_odometry_is_of_a_scan_ = false;
  std::size_t waiting_bytes_ = 0;
  std::int64_t number_ = 0;
  std::int64_t out_of_order_ = 0;
  Duration largest_step_back_{};
  bool closed_ = false;
};

}  // namespace loopstone
