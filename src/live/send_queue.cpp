#include "live/send_queue.hpp"

#include <algorithm>
#include <utility>

namespace loopstone {

SendQueue::Place SendQueue::find(std::uint64_t source, Kind kind) {
  return std::find_if(items_.begin(), items_.end(),
                      [&](const Item& item) { return item.source == source && item.kind == kind; });
}

SendQueue::Amount* SendQueue::amount_of(Kind kind) {
  if (kind == Kind::kEvery) return &every_;
  if (kind == Kind::kDroppable) return &droppable_;
  return nullptr;  // one a source, or counted where they are added
}

SendQueue::Place SendQueue::erase(Place place) {
  if (Amount* amount = amount_of(place->kind)) {
    --amount->frames;
    amount->bytes -= place->frame.size();
  }
  return items_.erase(place);
}

void SendQueue::append(std::uint64_t source, Kind kind, OutFrame frame) {
  if (Amount* amount = amount_of(kind)) {
    ++amount->frames;
    amount->bytes += frame.size();
  }
  items_.push_back({source, kind, std::move(frame)});
}

void SendQueue::push(std::uint64_t source, SendPolicy policy, OutFrame frame) {
  if (is_overrun_) return;
  switch (policy) {
    case SendPolicy::kEvery:
      append(source, Kind::kEvery, std::move(frame));
      if (every_.frames > limits_.every_frames || every_.bytes > limits_.every_bytes) {
        is_overrun_ = true;
        items_.clear();
      }
      return;
    case SendPolicy::kLatest: {
      // In the place of the one before, so that a channel that often changes gets its turn.
      const Place waiting = find(source, Kind::kLatest);
      if (waiting == items_.end()) return append(source, Kind::kLatest, std::move(frame));
      waiting->frame = std::move(frame);
      return;
    }
    case SendPolicy::kDroppable:
      append(source, Kind::kDroppable, std::move(frame));
      while (droppable_.frames > limits_.droppable_frames ||
             (droppable_.bytes > limits_.droppable_bytes && droppable_.frames > 1)) {
        drop_oldest();
      }
      return;
    case SendPolicy::kChanges:
      return add_change(source, std::move(frame));
  }
}

void SendQueue::drop_oldest() {
  const auto oldest = std::ranges::find(items_, Kind::kDroppable, &Item::kind);
  if (oldest == items_.end()) return;
  erase(oldest);
  ++dropped_;
}

void SendQueue::add_change(std::uint64_t source, OutFrame frame) {
  // All of the state, as it will be told, has this change in it.
  if (find(source, Kind::kWhole) != items_.end()) return;
  Amount waiting;
  for (const Item& item : items_) {
    if (item.source != source || item.kind != Kind::kChange) continue;
    ++waiting.frames;
    waiting.bytes += item.frame.size();
  }
  // The first is sent, however large.
  if (waiting.frames == 0 ||
      (waiting.frames < limits_.changes && waiting.bytes + frame.size() <= limits_.change_bytes))
    return append(source, Kind::kChange, std::move(frame));
  push_whole(source);
}

void SendQueue::push_whole(std::uint64_t source) {
  if (is_overrun_) return;
  std::erase_if(items_, [&](const Item& item) {
    return item.source == source && (item.kind == Kind::kChange || item.kind == Kind::kWhole);
  });
  append(source, Kind::kWhole, {});
}

void SendQueue::forget(std::uint64_t source) {
  for (auto at = items_.begin(); at != items_.end();)
    at = at->source == source ? erase(at) : std::next(at);
}

std::optional<SendQueue::Next> SendQueue::pop() {
  if (items_.empty()) return {};
  Next next{.source = items_.front().source};
  if (items_.front().kind != Kind::kWhole) next.frame = std::move(items_.front().frame);
  // Its size is taken off with the frame that it had.
  Item& front = items_.front();
  if (Amount* amount = amount_of(front.kind)) {
    --amount->frames;
    amount->bytes -= next.frame->size();
  }
  items_.pop_front();
  return next;
}

}  // namespace loopstone
