#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace loopstone {

/// What the name of a temporary file tells: ".map.png.1234-0.partial" is of map.png, by process
/// 1234; so is the folder ".RGB20.1234.partial" of RGB20.
struct PartialName {
  std::string name;
  std::int64_t process = 0;
};
[[nodiscard]] std::optional<PartialName> parse_partial_name(const std::string& file_name);

/// A file that appears under its name whole or not at all: bytes go to a hidden temporary file in
/// the target's folder, commit() puts it in place, and without commit() the destructor removes it.
/// Every failure throws DataError that names the target. An existing target that is no regular file
/// (a pipe, /dev/stdout) is written straight through.
class AtomicFile {
 public:
  explicit AtomicFile(std::string path);
  AtomicFile(AtomicFile&& other) noexcept;
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;
  AtomicFile& operator=(AtomicFile&&) = delete;
  ~AtomicFile();

  void write(std::string_view bytes);
  /// Puts other bytes in place of some that were written. Not for pipes.
  void overwrite(std::int64_t offset, std::string_view bytes);
  /// Everything written so far reaches the disk or this throws; nothing may be written afterwards.
  /// Lets a writer of several files find out that the disk is full before the first of them
  /// appears.
  void finish_writing();
  /// finish_writing(), then the target is replaced.
  void commit();

  [[nodiscard]] const std::string& path() const { return path_; }
  /// Where the bytes are until commit(), for libraries that insist on opening a name themselves.
  [[nodiscard]] const std::string& temporary_path() const { return temporary_path_; }

 private:
  void flush_buffer();
  void discard() noexcept;

  std::string path_;
  std::string final_path_;      // path_ with symbolic links followed
  std::string temporary_path_;  // equal to final_path_ when written straight through
  std::string buffer_;
  int descriptor_ = -1;
  bool straight_through_ = false;
  bool finished_ = false;
};

/// The usual case: all bytes at hand.
void write_file_atomically(const std::string& path, std::string_view bytes);

/// The whole content of a file. Throws DataError naming the path, also for folders and for files
/// larger than `most_bytes`; of a pipe or a device, whose size nobody knows, no more than 128 MiB
/// are read.
/// \param buffer  its memory is used for the content; what it held is lost
[[nodiscard]] std::string read_whole_file(const std::string& path,
                                          std::size_t most_bytes = std::size_t{4} << 30,
                                          std::string buffer = {});

}  // namespace loopstone
