#include "loopstone/formats/live_log.hpp"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <thread>

#include "loopstone/base/error.hpp"
#include "support/read_log.hpp"
#include "support/temp_dir.hpp"

namespace loopstone {
namespace {

/// So short that what follows is read live.
constexpr LiveReading kGlance{.look_s = 0.05};

std::string scan_line(int i) {
  std::string line = "FLASER 40";
  for (int beam = 0; beam < 40; ++beam) line += " " + std::to_string(1 + (i + beam) % 7);
  return line + " 0 0 0 0 0 0 " + std::to_string(1000 + i) + ".5 host 0\n";
}

std::string scan_lines(int first, int end) {
  std::string text;
  for (int i = first; i < end; ++i) text += scan_line(i);
  return text;
}

/// Scans until so many have come.
int count_scans(LogReader& log, int most) {
  int scans = 0;
  while (scans < most) {
    const auto message = log.next();
    if (!message) break;
    scans += static_cast<int>(std::holds_alternative<LaserScan>(*message));
  }
  return scans;
}

class ThreadedLiveLog : public testing::Test {
 protected:
  [[nodiscard]] LogOptions options() {
    return {.stop = [this] { return stop_.load(); }, .live = kGlance};
  }
  test::TempDir folder_;
  std::atomic<bool> stop_{false};
};

TEST_F(ThreadedLiveLog, OfAFileThatGrowsGivesEachScanAsSoonAsItIsThere) {
  const std::string path = folder_.write("log.clf", scan_lines(0, 50));
  std::ofstream file(path, std::ios::app);
  std::jthread writer([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    file << scan_line(50) << std::flush;
  });
  const auto log = open_live_log(path, options());
  EXPECT_EQ(log->format(), "carmen");
  ASSERT_EQ(count_scans(*log, 51), 51);
  writer.join();
  for (int i = 51; i < 60; ++i) {
    // Nothing follows this one before it was read.
    file << scan_line(i) << std::flush;
    const auto odometry = log->next();
    ASSERT_TRUE(odometry && std::holds_alternative<OdometryPose>(*odometry));
    const auto scan = log->next();
    ASSERT_TRUE(scan && std::holds_alternative<LaserScan>(*scan));
    EXPECT_EQ(stamp_of(*scan), Stamp::from_seconds(1000.5 + i));
  }
  stop_ = true;
  EXPECT_FALSE(log->next());
}

TEST_F(ThreadedLiveLog, OfAFileEndsWhenAnotherOneHasItsName) {
  const std::string path = folder_.write("log.clf", scan_lines(0, 50));
  const auto log = open_live_log(path, options());
  EXPECT_EQ(count_scans(*log, 50), 50);
  std::filesystem::remove(path);
  EXPECT_EQ(count_scans(*log, 1), 0);
}

TEST_F(ThreadedLiveLog, OfAFileThatIsCutSaysSo) {
  const std::string path = folder_.write("log.clf", scan_lines(0, 50));
  const auto log = open_live_log(path, options());
  EXPECT_EQ(count_scans(*log, 50), 50);
  std::filesystem::resize_file(path, 10);
  try {
    (void)log->next();
    FAIL() << "it was cut";
  } catch (const DataError& error) {
    EXPECT_NE(std::string(error.what()).find("was cut while it was read"), std::string::npos);
  }
}

TEST_F(ThreadedLiveLog, HoldsWhatTheReaderOfTheWholeLogGives) {
  RobotModel robot;
  const std::string path = folder_ / "log.mcap";
  {
    const auto writer = create_log(path, "mcap", robot);
    for (int i = 0; i < 300; ++i) {
      const Stamp stamp = Stamp::from_seconds(1.7e9 + 0.1 * i);
      writer->write(OdometryPose{stamp, {0.1 * i, 0.0, 0.0}});
      writer->write(
          LaserScan{.stamp = stamp,
                    .angle_min_rad = -1.0,
                    .angle_increment_rad = 0.1,
                    .range_min_m = 0.1,
                    .range_max_m = 30.0,
                    .ranges_m = std::vector<float>(20, 1.0F + 0.01F * static_cast<float>(i))});
    }
    writer->finish();
  }
  const test::LogContent whole = test::read_log(path);
  const test::LogContent live = test::read_all([&](LogOptions how) {
    how.live = kGlance;
    return open_live_log(path, how);
  });
  ASSERT_EQ(live.scans.size(), whole.scans.size());
  EXPECT_EQ(live.odometry.size(), whole.odometry.size());
  EXPECT_EQ(live.scans.back().ranges_m, whole.scans.back().ranges_m);
  EXPECT_EQ(live.scans.back().stamp, whole.scans.back().stamp);
}

/// Sends a text to whoever connects first, and leaves.
class Sender {
 public:
  explicit Sender(const std::string& text) : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(::bind(socket_, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    EXPECT_EQ(::listen(socket_, 1), 0);
    socklen_t size = sizeof address;
    ::getsockname(socket_, reinterpret_cast<sockaddr*>(&address), &size);
    port_ = ntohs(address.sin_port);
    thread_ = std::jthread([this, text] {
      const int client = ::accept(socket_, nullptr, nullptr);
      std::size_t sent = 0;
      while (sent < text.size()) {
        const ssize_t count = ::send(client, text.data() + sent, text.size() - sent, MSG_NOSIGNAL);
        if (count <= 0) break;
        sent += static_cast<std::size_t>(count);
      }
      ::close(client);
    });
  }
  ~Sender() { ::close(socket_); }
  Sender(const Sender&) = delete;
  Sender& operator=(const Sender&) = delete;
  [[nodiscard]] std::string url() const { return "tcp://127.0.0.1:" + std::to_string(port_); }

 private:
  int socket_;
  int port_ = 0;
  std::jthread thread_{};
};

TEST_F(ThreadedLiveLog, OfAConnectionGoesToItsEnd) {
  const Sender sender(scan_lines(0, 200));
  const auto log = open_live_log(sender.url(), options());
  EXPECT_EQ(count_scans(*log, 1000), 200);
}

TEST_F(ThreadedLiveLog, OfNobodyIsRefused) {
  std::string url;
  {
    const Sender sender("");
    url = sender.url();
    EXPECT_THROW((void)open_live_log(url, options()), DataError) << "it says nothing";
  }
  try {
    (void)open_live_log(url, options());
    FAIL() << "nobody listens";
  } catch (const DataError& error) {
    EXPECT_NE(std::string(error.what()).find(url + ": no connection"), std::string::npos);
  }
}

TEST(LiveLogSource, OfNoKindIsRefused) {
  for (const char* source : {"tcp://", "tcp://host", "tcp://host:", "tcp://:99", "tcp://host:99999",
                             "tcp://host:9a", "tcp://host:-1"}) {
    EXPECT_THROW((void)open_live_log(source), UsageError) << source;
  }
  EXPECT_THROW((void)open_live_log("/no/such/file"), DataError);
  EXPECT_THROW((void)open_live_log("/tmp"), DataError);
}

}  // namespace
}  // namespace loopstone
