/// Jobs in another thread: order, bounds, failures.
#include "parallel/background_queue.h"

#include <atomic>
#include <chrono>
#include <stdexcept>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

namespace deform {
namespace {

TEST(BackgroundQueue, DoesJobsInTheirOrderInOneOtherThread) {
  BackgroundQueue queue;
  std::vector<int> done;  // no lock: jobs are done one after another
  std::vector<std::thread::id> threads;
  for (int i = 0; i < 50; ++i)
    queue.add([&, i] {
      done.push_back(i);
      threads.push_back(std::this_thread::get_id());
    });
  queue.drain();
  ASSERT_EQ(done.size(), 50U);
  for (int i = 0; i < 50; ++i) EXPECT_EQ(done[static_cast<std::size_t>(i)], i);
  for (const std::thread::id& id : threads) {
    EXPECT_EQ(id, threads.front());
    EXPECT_NE(id, std::this_thread::get_id());
  }
}

TEST(BackgroundQueue, LetsFewWait) {
  std::atomic<int> begun{0}, ended{0};
  std::atomic<bool> goes_on{false};
  BackgroundQueue queue;
  std::thread adding([&] {
    for (int i = 0; i < 20; ++i) {
      queue.add([&] {
        while (!goes_on) std::this_thread::yield();
        ++ended;
      });
      ++begun;
    }
  });
  while (begun < 4) std::this_thread::yield();
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  EXPECT_EQ(begun, 4);  // the fifth waits for one of these
  goes_on = true;
  adding.join();
  queue.drain();
  EXPECT_EQ(ended, 20);
}

TEST(BackgroundQueue, ThrowsWhatAJobThrewAndDoesNothingBehindIt) {
  BackgroundQueue queue;
  bool is_done = false;
  std::atomic<bool> goes_on{false};
  queue.add([&] {
    while (!goes_on) std::this_thread::yield();
    throw std::runtime_error("the disk is full");
  });
  queue.add([&] { is_done = true; });
  goes_on = true;
  EXPECT_THROW(queue.drain(), std::runtime_error);
  EXPECT_FALSE(is_done);
  EXPECT_THROW(queue.require_success(), std::runtime_error);
  EXPECT_THROW(queue.add([&] { is_done = true; }), std::runtime_error);
  EXPECT_NO_THROW(queue.drain());  // it was told
  EXPECT_FALSE(is_done);
}

TEST(BackgroundQueue, EndsWithWhatItHas) {
  int done = 0;
  {
    BackgroundQueue queue;
    for (int i = 0; i < 3; ++i) queue.add([&] { ++done; });
  }
  EXPECT_EQ(done, 3);
}

}  // namespace
}  // namespace deform
