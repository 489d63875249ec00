#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "formats/byte_source.hpp"
#include "formats/npy.hpp"

namespace loopstone {

/// A .npz file: a zip archive of .npy files, stored or deflated, zip64 included.
class NpzFile {
 public:
  /// \param stop  asked while arrays are read; they throw ReadingStopped once it returns true. May
  ///              be empty.
  /// Throws DataError when it is missing or no zip archive.
  explicit NpzFile(const std::string& path, const MemoryBudget& budget = {},
                   std::function<bool()> stop = {});
  /// Over bytes in memory, which must outlive the object.
  NpzFile(std::string_view bytes, const std::string& name, const MemoryBudget& budget = {});

  [[nodiscard]] bool has(const std::string& key) const;
  [[nodiscard]] std::vector<std::string> keys() const;
  /// Opens an array for reading front to back. Several may be open at once; they keep the file
  /// open. Throws DataError naming the file, the key and the keys that are there.
  [[nodiscard]] NpyReader open(const std::string& key) const;
  [[nodiscard]] NpyArray read(const std::string& key) const;
  /// Throws DataError when so many bytes are more than what this array's bytes in the archive may
  /// take.
  void require_memory(const std::string& key, std::uint64_t bytes) const;

 private:
  struct Archive;

  [[nodiscard]] std::unique_ptr<ByteSource> open_bytes(const std::string& key) const;
  [[nodiscard]] std::uint64_t stored_bytes(const std::string& key) const;
  [[nodiscard]] std::string name_of(const std::string& key) const { return path_ + ":" + key; }

  std::string path_;
  MemoryBudget budget_;
  std::function<bool()> stop_{};
  std::shared_ptr<Archive> archive_;
};

}  // namespace loopstone
