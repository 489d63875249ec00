// Lets every fuzz target stand an attack: `fuzz_carmen --attack SECONDS MEGABYTES` reads inputs
// from standard input (four bytes of length, little-endian, then the bytes) and tries each in a
// process of its own that may use so much processor time and memory. One line an input tells how it
// went: `ok MS KB`, or `fault MS KB WHAT`. tests/attack/attack.py is the other end.

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <fstream>
#include <string>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kLimitsAddresses = false;  // the shadow of a sanitizer takes terabytes of them
#elif defined(__has_feature)
constexpr bool kLimitsAddresses =
    !__has_feature(address_sanitizer) && !__has_feature(thread_sanitizer);
#else
constexpr bool kLimitsAddresses = true;
#endif

constexpr int kUncaught = 77;
/// Of processor time that an input may wait, for a lock or for a slow machine.
constexpr unsigned kWaitFactor = 6;

struct Limits {
  unsigned seconds = 10;
  std::size_t bytes = std::size_t{1} << 30;
};

/// Of this process, now.
std::size_t address_space_bytes() {
  std::size_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  return pages * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
}

void limit(int resource, rlim_t most) {
  const rlimit both{most, most};
  ::setrlimit(static_cast<decltype(RLIMIT_AS)>(resource), &both);
}

/// In the child. Never returns.
[[noreturn]] void try_input(const std::vector<std::uint8_t>& input, const Limits& limits,
                            int errors) {
  ::dup2(errors, STDERR_FILENO);
  limit(RLIMIT_CORE, 0);
  limit(RLIMIT_CPU, limits.seconds);
  if (kLimitsAddresses) limit(RLIMIT_AS, address_space_bytes() + limits.bytes);
  ::alarm(kWaitFactor * limits.seconds);
  try {
    LLVMFuzzerTestOneInput(input.data(), input.size());
  } catch (const std::exception& error) {
    std::fprintf(stderr, "uncaught: %s\n", error.what());
    ::_exit(kUncaught);
  } catch (...) {
    std::fprintf(stderr, "uncaught: something that is no std::exception\n");
    ::_exit(kUncaught);
  }
  ::_exit(0);
}

/// The first words of what a child said, on one line.
std::string said(int errors) {
  std::array<char, 600> text{};
  const ssize_t count = ::pread(errors, text.data(), text.size(), 0);
  std::string line(text.data(), static_cast<std::size_t>(std::max<ssize_t>(count, 0)));
  for (char& c : line) {
    if (static_cast<unsigned char>(c) < ' ' || c == '\x7f') c = ' ';
  }
  return line;
}

std::string what_ended(int status) {
  if (WIFEXITED(status)) {
    const int code = WEXITSTATUS(status);
    return code == kUncaught ? "exception" : "exit " + std::to_string(code);
  }
  const int signal = WTERMSIG(status);
  if (signal == SIGXCPU || signal == SIGALRM || signal == SIGKILL) return "hang";
  return std::string("signal ") + ::strsignal(signal);
}

void judge(const std::vector<std::uint8_t>& input, const Limits& limits, int errors) {
  if (::ftruncate(errors, 0) != 0 || ::lseek(errors, 0, SEEK_SET) != 0) std::abort();
  const pid_t child = ::fork();
  if (child < 0) {
    std::perror("fork");
    std::exit(1);
  }
  if (child == 0) try_input(input, limits, errors);
  int status = 0;
  rusage usage{};
  ::wait4(child, &status, 0, &usage);
  const auto ms = [](const timeval& time) { return time.tv_sec * 1000L + time.tv_usec / 1000L; };
  const long spent_ms = ms(usage.ru_utime) + ms(usage.ru_stime);
  const long peak_kb = usage.ru_maxrss;
  std::string fault;
  if (status != 0) {
    fault = what_ended(status) + ": " + said(errors);
  } else if (static_cast<std::size_t>(peak_kb) * 1024 > limits.bytes) {
    fault = "bloat: more memory than an input may take";
  }
  std::printf(fault.empty() ? "ok %ld %ld\n" : "fault %ld %ld %s\n", spent_ms, peak_kb,
              fault.c_str());
  std::fflush(stdout);
}

int serve(const Limits& limits) {
  // What a target makes once and keeps is made before the first child, so that not each makes it
  // anew.
  const std::uint8_t nothing = 0;
  LLVMFuzzerTestOneInput(&nothing, 1);
  char name[] = "/tmp/attack-XXXXXX";
  const int errors = ::mkstemp(name);
  if (errors < 0) {
    std::perror(name);
    return 1;
  }
  ::unlink(name);
  std::array<std::uint8_t, 4> head{};
  std::vector<std::uint8_t> input;
  while (std::fread(head.data(), 1, head.size(), stdin) == head.size()) {
    const std::size_t size =
        head[0] | head[1] << 8 | head[2] << 16 | static_cast<std::size_t>(head[3]) << 24;
    input.resize(size);
    if (std::fread(input.data(), 1, size, stdin) != size) return 1;
    judge(input, limits, errors);
  }
  ::close(errors);
  return 0;
}

}  // namespace

/// libFuzzer and standalone_main.cpp call it before anything else.
extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv) {
  if (*argc != 4 || std::strcmp((*argv)[1], "--attack") != 0) return 0;
  Limits limits;
  limits.seconds = static_cast<unsigned>(std::stoul((*argv)[2]));
  limits.bytes = std::stoul((*argv)[3]) << 20;
  std::exit(serve(limits));
}
