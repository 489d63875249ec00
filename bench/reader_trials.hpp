#pragma once

#include <malloc.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <bit>
#include <cmath>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <exception>
#include <functional>
#include <iostream>
#include <new>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

// What readers make of files, the same for ours and others':
//   PROGRAM                            the endings of the files that it reads, one a line
//   PROGRAM time RUNS FILE             CPU time of each reading [ms], one a line
//   PROGRAM try MEGABYTES SECONDS      a process of its own for each path on the standard input,
//                                      with so much memory and CPU time; a line for each, split by
//                                      tabs: verdict, CPU [ms], peak memory [MB], what it said
// Verdicts: read (sizes and a digest of the values), refused (the message), memory (it asked for
// more than it may have, whatever it said afterwards), late, died (the signal). One header of one
// file: it takes the place of malloc to see what is asked for.

namespace loopstone::bench {

inline bool memory_was_denied = false;

template <typename Pointer>
Pointer noted(Pointer memory) {
  if (memory == nullptr) memory_was_denied = true;
  return memory;
}

}  // namespace loopstone::bench

// NOLINTBEGIN(bugprone-reserved-identifier,cert-*,readability-*): names of the C library
extern "C" {
void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t count, std::size_t size);
void* __libc_realloc(void* memory, std::size_t size);
void* malloc(std::size_t size) { return loopstone::bench::noted(__libc_malloc(size)); }
void* calloc(std::size_t count, std::size_t size) {
  return loopstone::bench::noted(__libc_calloc(count, size));
}
void* realloc(void* memory, std::size_t size) {
  void* const moved = __libc_realloc(memory, size);
  return size == 0 ? moved : loopstone::bench::noted(moved);
}
}
// NOLINTEND(bugprone-reserved-identifier,cert-*,readability-*)

namespace loopstone::bench {

/// FNV-1a over the values, all NaN alike, and their sizes in words.
class ValueDigest {
 public:
  void add_sizes(const std::string& name, std::size_t rows, std::size_t columns) {
    told_ += (told_.empty() ? "" : ", ") + name + (name.empty() ? "" : " ") + std::to_string(rows) +
             "x" + std::to_string(columns);
  }
  void add(double value) {
    std::uint64_t bits = std::isnan(value) ? 1 : std::bit_cast<std::uint64_t>(value);
    for (int byte = 0; byte < 8; ++byte, bits >>= 8U) {
      hash_ = (hash_ ^ (bits & 0xffU)) * 1099511628211U;
    }
  }
  template <typename Values>
  void add_all(const Values& values) {
    for (const auto value : values) add(static_cast<double>(value));
  }
  [[nodiscard]] std::string text() const {
    std::array<char, 20> digits{};
    std::snprintf(digits.data(), digits.size(), " %016llx", static_cast<unsigned long long>(hash_));
    return told_ + digits.data();
  }

 private:
  std::uint64_t hash_ = 14695981039346656037U;
  std::string told_{};
};

/// Reads a file whole, as ours hands it on; throws when it is refused. The digest, when there is
/// one, takes the values.
struct FileReader {
  std::string ending;  ///< ".tif"
  std::function<void(const std::string& path, ValueDigest* digest)> read;
};

/// Most bytes of values that a library may be asked for: what ours grants any file, however small.
inline constexpr std::uint64_t kMostValueBytes = std::uint64_t{1} << 27;

inline void require_value_bytes(std::uint64_t count, std::uint64_t bytes) {
  if (count > kMostValueBytes / bytes) throw std::runtime_error("more values than are allowed");
}

/// What ours asks of every cloud: finite points somewhere, none farther away than 10^9 m.
/// \param Points  of anything with x(), y(), z()
template <typename Points>
void require_cloud(const Points& points) {
  bool is_somewhere = false;
  for (const auto& point : points) {
    bool is_finite = true;
    for (const double value : {point.x(), point.y(), point.z()}) {
      if (std::isfinite(value) && std::abs(value) > 1e9) throw std::runtime_error("too far away");
      is_finite = is_finite && std::isfinite(value);
    }
    is_somewhere = is_somewhere || is_finite;
  }
  if (!is_somewhere) throw std::runtime_error("no finite point");
}

/// As floats: some readers have no more for the numbers of a text.
template <typename Points>
void digest_cloud(const Points& points, ValueDigest* digest) {
  if (digest == nullptr) return;
  digest->add_sizes("", points.size(), 3);
  for (const auto& point : points) {
    for (const double value : {point.x(), point.y(), point.z()}) {
      digest->add(static_cast<float>(value));
    }
  }
}

inline const FileReader& reader_of(const std::vector<FileReader>& readers,
                                   const std::string& path) {
  for (const FileReader& reader : readers) {
    if (path.ends_with(reader.ending)) return reader;
  }
  throw std::runtime_error(path + ": no reader for it");
}

inline double process_ms() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return 1e3 * static_cast<double>(now.tv_sec) + 1e-6 * static_cast<double>(now.tv_nsec);
}

/// Memory once had is kept, as by a program that reads many files: else most of the time is the
/// system's, for pages that are new each time.
inline void time_reader(const FileReader& reader, const std::string& path, int runs) {
  mallopt(M_MMAP_MAX, 0);
  mallopt(M_TRIM_THRESHOLD, 1 << 30);
  for (int run = 0; run < runs; ++run) {
    const double begin_ms = process_ms();
    reader.read(path, nullptr);
    std::printf("%.4f\n", process_ms() - begin_ms);
  }
}

struct TrialLimits {
  rlim_t memory_bytes = 0;
  rlim_t cpu_s = 0;
};

/// Within the process that may die: verdict and words to the pipe.
inline void try_here(const FileReader& reader, const std::string& path, const TrialLimits& limits,
                     int pipe) {
  const rlimit memory{limits.memory_bytes, limits.memory_bytes};
  const rlimit cpu{limits.cpu_s, limits.cpu_s + 1};
  const rlimit core{0, 0};
  if (setrlimit(RLIMIT_DATA, &memory) != 0 || setrlimit(RLIMIT_CPU, &cpu) != 0 ||
      setrlimit(RLIMIT_CORE, &core) != 0 || std::freopen("/dev/null", "w", stdout) == nullptr ||
      std::freopen("/dev/null", "w", stderr) == nullptr) {
    _exit(3);
  }
  std::string said;
  try {
    ValueDigest digest;
    reader.read(path, &digest);
    said = "read\t" + digest.text();
  } catch (const std::bad_alloc&) {
    memory_was_denied = true;
  } catch (const std::exception& error) {
    said = "refused\t" + std::string(error.what());
  }
  if (memory_was_denied) said = "memory\t";
  for (char& c : said) {
    if (c != '\t' && (c < ' ' || c > '~')) c = ' ';
  }
  said.resize(std::min<std::size_t>(said.size(), 400));
  if (write(pipe, said.data(), said.size()) < 0) _exit(3);
  _exit(0);
}

inline void try_reader(const FileReader& reader, const std::string& path,
                       const TrialLimits& limits) {
  std::array<int, 2> ends{};
  if (pipe(ends.data()) != 0) throw std::runtime_error("no pipe");
  const pid_t child = fork();
  if (child < 0) throw std::runtime_error("no process");
  if (child == 0) {
    // What never ends without any work ends, too.
    alarm(static_cast<unsigned>(4 * limits.cpu_s));
    try_here(reader, path, limits, ends[1]);
  }
  close(ends[1]);
  std::array<char, 512> buffer{};
  std::string said;
  while (true) {
    const ssize_t count = ::read(ends[0], buffer.data(), buffer.size());
    if (count <= 0) break;
    said.append(buffer.data(), static_cast<std::size_t>(count));
  }
  close(ends[0]);
  int status = 0;
  rusage usage{};
  wait4(child, &status, 0, &usage);
  if (WIFSIGNALED(status)) {
    const int number = WTERMSIG(status);
    const bool is_late = number == SIGXCPU || number == SIGKILL || number == SIGALRM;
    said = (is_late ? "late\t" : "died\t") + std::string(strsignal(number));
  } else if (WEXITSTATUS(status) != 0 || said.empty()) {
    said = "died\tended with " + std::to_string(WEXITSTATUS(status));
  }
  const auto ms = [](const timeval& time) {
    return 1e3 * static_cast<double>(time.tv_sec) + 1e-3 * static_cast<double>(time.tv_usec);
  };
  const std::size_t tab = said.find('\t');
  std::printf("%s\t%.1f\t%.1f\t%s\n", said.substr(0, tab).c_str(),
              ms(usage.ru_utime) + ms(usage.ru_stime), static_cast<double>(usage.ru_maxrss) / 1024,
              said.substr(tab + 1).c_str());
  // What is still in the buffer would be printed by the next child as well.
  std::fflush(stdout);
}

/// main() of a program that has nothing but readers.
inline int reader_main(int argc, char** argv, const std::vector<FileReader>& readers) {
  const std::string_view task = argc > 1 ? argv[1] : "";
  try {
    if (argc == 1) {
      for (const FileReader& reader : readers) std::printf("%s\n", reader.ending.c_str());
      return 0;
    }
    if (task == "time" && argc == 4) {
      time_reader(reader_of(readers, argv[3]), argv[3], std::stoi(argv[2]));
      return 0;
    }
    if (task == "try" && argc == 4) {
      const TrialLimits limits{std::stoul(argv[2]) << 20U, std::stoul(argv[3])};
      std::string path;
      while (std::getline(std::cin, path)) try_reader(reader_of(readers, path), path, limits);
      return 0;
    }
    throw std::runtime_error("see bench/reader_trials.hpp for what to ask");
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}

}  // namespace loopstone::bench
