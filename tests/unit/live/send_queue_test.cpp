#include "live/send_queue.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace loopstone {
namespace {

using Words = std::vector<std::string>;

OutFrame frame(const std::string& text) { return {.head = text}; }

/// What comes out; "whole N" where the state of source N is to be told.
Words all_of(SendQueue& queue) {
  Words words;
  while (auto next = queue.pop())
    words.push_back(next->frame ? next->frame->head : "whole " + std::to_string(next->source));
  return words;
}

constexpr SendQueue::Limits kLimits{.every_bytes = 10,
                                    .droppable_bytes = 10,
                                    .every_frames = 5,
                                    .droppable_frames = 3,
                                    .changes = 2};

TEST(SendQueue, KeepsTheOrder) {
  SendQueue queue(kLimits);
  queue.push(1, SendPolicy::kEvery, frame("a"));
  queue.push(2, SendPolicy::kDroppable, frame("b"));
  queue.push(3, SendPolicy::kLatest, frame("c"));
  queue.push(4, SendPolicy::kChanges, frame("d"));
  EXPECT_FALSE(queue.empty());
  EXPECT_EQ(all_of(queue), (Words{"a", "b", "c", "d"}));
  EXPECT_TRUE(queue.empty());
}

TEST(SendQueue, OfTheLatestOneStaysInItsPlace) {
  SendQueue queue(kLimits);
  queue.push(1, SendPolicy::kLatest, frame("old"));
  queue.push(2, SendPolicy::kLatest, frame("other"));
  queue.push(1, SendPolicy::kLatest, frame("new"));
  EXPECT_EQ(all_of(queue), (Words{"new", "other"}));
}

TEST(SendQueue, DropsTheOldestOfWhatMayBeDropped) {
  SendQueue queue(kLimits);
  queue.push(9, SendPolicy::kEvery, frame("keep"));
  for (const char* text : {"1", "2", "3", "4"}) queue.push(1, SendPolicy::kDroppable, frame(text));
  EXPECT_EQ(queue.dropped(), 1U);
  queue.push(1, SendPolicy::kDroppable, frame("nine bytes"));
  EXPECT_EQ(all_of(queue), (Words{"keep", "nine bytes"}));
  // One alone is sent however large it is.
  queue.push(1, SendPolicy::kDroppable, frame(std::string(100, 'x')));
  EXPECT_EQ(all_of(queue).size(), 1U);
  // What was sent makes room.
  for (const char* text : {"1", "2", "3"}) queue.push(1, SendPolicy::kDroppable, frame(text));
  EXPECT_EQ(all_of(queue), (Words{"1", "2", "3"}));
}

TEST(SendQueue, IsOverrunByWhatMustNotBeLost) {
  SendQueue queue(kLimits);
  queue.push(1, SendPolicy::kEvery, frame("0123456789"));
  EXPECT_FALSE(queue.is_overrun());
  queue.push(1, SendPolicy::kEvery, frame("x"));
  EXPECT_TRUE(queue.is_overrun());
  EXPECT_TRUE(queue.empty());
  queue.push(1, SendPolicy::kLatest, frame("y"));
  queue.push_whole(1);
  EXPECT_TRUE(queue.empty());

  SendQueue frames(kLimits);
  for (int i = 0; i < 6; ++i) frames.push(1, SendPolicy::kEvery, frame(""));
  EXPECT_TRUE(frames.is_overrun());
}

TEST(SendQueue, TellsAllOfTheStateInsteadOfManyChanges) {
  SendQueue queue(kLimits);
  queue.push(1, SendPolicy::kChanges, frame("1"));
  queue.push(1, SendPolicy::kChanges, frame("2"));
  queue.push(2, SendPolicy::kChanges, frame("of another"));
  queue.push(1, SendPolicy::kChanges, frame("3"));
  queue.push(1, SendPolicy::kChanges, frame("4"));
  EXPECT_EQ(all_of(queue), (Words{"of another", "whole 1"}));
  // Afterwards changes are told again.
  queue.push(1, SendPolicy::kChanges, frame("5"));
  EXPECT_EQ(all_of(queue), Words{"5"});
}

TEST(SendQueue, LargeChangesDoNotPileUp) {
  SendQueue::Limits limits = kLimits;
  limits.changes = 100;
  limits.change_bytes = 2000;
  SendQueue queue(limits);
  const std::string large(1500, 'x');
  queue.push(1, SendPolicy::kChanges, frame(large));
  queue.push(2, SendPolicy::kChanges, frame(large));
  EXPECT_EQ(all_of(queue), (Words{large, large}));
  queue.push(1, SendPolicy::kChanges, frame(large));
  queue.push(1, SendPolicy::kChanges, frame(large));
  EXPECT_EQ(all_of(queue), Words{"whole 1"});
  queue.push(1, SendPolicy::kChanges, frame(std::string(5000, 'y')));
  EXPECT_EQ(all_of(queue), Words{std::string(5000, 'y')});
}
TEST(SendQueue, WhoSubscribesGetsAllBeforeChanges) {
  SendQueue queue(kLimits);
  queue.push_whole(1);
  queue.push(1, SendPolicy::kChanges, frame("is in it"));
  EXPECT_EQ(all_of(queue), Words{"whole 1"});
}

TEST(SendQueue, ForgetsASource) {
  SendQueue queue(kLimits);
  queue.push(1, SendPolicy::kDroppable, frame("a"));
  queue.push(1, SendPolicy::kEvery, frame("12345678"));
  queue.push_whole(1);
  queue.push(2, SendPolicy::kLatest, frame("b"));
  queue.forget(1);
  queue.push(2, SendPolicy::kEvery, frame("12345678"));
  EXPECT_FALSE(queue.is_overrun());
  EXPECT_EQ(all_of(queue), (Words{"b", "12345678"}));
}

}  // namespace
}  // namespace loopstone
