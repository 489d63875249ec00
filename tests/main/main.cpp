#include <fcntl.h>
#include <gmock/gmock.h>
#include <unistd.h>

#include <cstdlib>
#include <string>
#include <utility>

namespace {

/// Writes a line for every skipped test, `program<TAB>Suite.Test<TAB>reason`, at the end of a file;
/// scripts/test.sh counts them.
class SkippedTests : public testing::EmptyTestEventListener {
 public:
  SkippedTests(std::string program, std::string path)
      : program_(std::move(program)), path_(std::move(path)) {}

  void OnTestEnd(const testing::TestInfo& test) override {
    if (!test.result()->Skipped()) return;
    std::string reason;
    for (int i = 0; i < test.result()->total_part_count(); ++i) {
      const testing::TestPartResult& part = test.result()->GetTestPartResult(i);
      if (part.skipped()) reason = part.message();
    }
    for (char& c : reason) {
      if (c == '\n' || c == '\t') c = ' ';
    }
    const std::string line =
        program_ + '\t' + test.test_suite_name() + '.' + test.name() + '\t' + reason + '\n';
    // One write: programs run beside each other, and appending is atomic.
    const int file = ::open(path_.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
    if (file < 0 || ::write(file, line.data(), line.size()) < 0) {
      ADD_FAILURE() << path_ << ": can't be written, so skipped tests would go uncounted";
    }
    if (file >= 0) ::close(file);
  }

 private:
  std::string program_;
  std::string path_;
};

}  // namespace

int main(int argc, char** argv) {
  // Laws draw the same cases in every run; RC_PARAMS="seed=..." in the environment draws others.
  setenv("RC_PARAMS", "seed=1", 0);  // NOLINT(concurrency-mt-unsafe): no thread has been started
  testing::InitGoogleMock(&argc, argv);
  // NOLINTNEXTLINE(concurrency-mt-unsafe): no thread has been started
  if (const char* path = std::getenv("LOOPSTONE_SKIPPED_TESTS")) {
    const std::string program(argv[0]);
    // gtest owns its listeners.
    testing::UnitTest::GetInstance()->listeners().Append(
        new SkippedTests(program.substr(program.rfind('/') + 1), path));
  }
  return RUN_ALL_TESTS();
}
