#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "formats/atomic_file.hpp"

namespace loopstone {

/// Level of the pictures' packing. Low: they are flat areas, and a second more would save some ten
/// kilobytes.
inline constexpr int kPngCompression = 2;

/// A file that stands beside the report.
struct ListedFile {
  std::string name;
  std::string content;  ///< in words
  std::int64_t bytes = 0;
};

/// The output folder; one that was made here goes away again unless it is kept.
/// Throws UsageError when it holds something and that was not forced, or is a file; DataError when
/// it can't be made.
class OutputFolder {
 public:
  OutputFolder(const std::string& path, bool force);
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;
  ~OutputFolder();

  [[nodiscard]] std::string file(const std::string& name) const { return (path_ / name).string(); }
  [[nodiscard]] bool holds(const std::string& name) const;
  void keep() { kept_ = true; }

 private:
  std::filesystem::path path_;
  bool made_ = false;
  bool kept_ = false;
};

/// The results of a run. All files are complete on disk before the first appears: commit() makes
/// them safe, all at once, then renames them, summary.json last. Where an older set is replaced,
/// its summary.json says first that the set is incomplete, and what the new one lacks goes, so that
/// whoever ends the process leaves no mixture that looks whole.
class FileSet {
 public:
  explicit FileSet(const OutputFolder& folder) : folder_(folder) {}

  void add(const std::string& name, const std::string& content, std::string_view bytes);
  /// A file that `write` fills piece by piece, for what does not fit into memory.
  void add(const std::string& name, const std::string& content,
           const std::function<void(AtomicFile&)>& write);
  [[nodiscard]] const std::vector<ListedFile>& listed() const { return listed_; }
  /// What was added so far is on disk, though not under its names; a failure from now on leaves it
  /// complete.
  void make_safe();
  /// Drops what was added since make_safe().
  void forget_the_rest();
  void commit();

 private:
  void clear_old_set() const;

  const OutputFolder& folder_;
  std::deque<AtomicFile> files_{};
  std::vector<ListedFile> listed_{};  ///< of the same order
  std::size_t safe_ = 0;
};

}  // namespace loopstone
