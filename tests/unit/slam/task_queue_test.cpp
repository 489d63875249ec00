#include "slam/task_queue.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace loopstone {
namespace {

TEST(TaskQueue, RunsEveryTaskOnceAndInOrder) {
  TaskQueue queue;
  std::vector<int> order;
  for (int i = 0; i < 200; ++i) queue.run([&order, i] { order.push_back(i); });
  queue.wait();
  ASSERT_EQ(order.size(), 200U);
  for (int i = 0; i < 200; ++i) EXPECT_EQ(order[static_cast<std::size_t>(i)], i);
  queue.wait();  // nothing more to wait for
  queue.run([&order] { order.push_back(-1); });
  queue.wait();
  EXPECT_EQ(order.back(), -1);
}

TEST(TaskQueue, AnExceptionComesOutOfWaitAndEndsWhatWasQueued) {
  TaskQueue queue;
  std::atomic<int> after{0};
  EXPECT_NO_THROW(queue.run([] {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));  // the others are queued by then
    throw std::runtime_error("broken");
  }));
  for (int i = 0; i < 5; ++i) queue.run([&after] { ++after; });
  try {
    queue.wait();
    FAIL() << "the exception was lost";
  } catch (const std::runtime_error& error) {
    EXPECT_STREQ(error.what(), "broken");
  }
  EXPECT_EQ(after, 0);
  EXPECT_NO_THROW(queue.wait()) << "thrown once";
}

TEST(TaskQueue, GoesWithoutBeingWaitedFor) {
  std::atomic<bool> done{false};
  {
    TaskQueue queue;
    queue.run([&done] {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
      done = true;
    });
    std::this_thread::sleep_for(std::chrono::milliseconds(2));  // it has begun
  }
  EXPECT_TRUE(done) << "what a task uses must outlive it";
}

TEST(TaskQueue, RunsOnAnotherThread) {
  std::thread::id own;
  TaskQueue queue;
  queue.run([&] { own = std::this_thread::get_id(); });
  queue.wait();
  EXPECT_NE(own, std::this_thread::get_id());
}

}  // namespace
}  // namespace loopstone
