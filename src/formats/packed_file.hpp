#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "formats/atomic_file.hpp"

namespace loopstone {

/// An AtomicFile that compresses when its name ends in .gz or .bz2. The same text gives the same
/// bytes.
class PackedFile {
 public:
  explicit PackedFile(const std::string& path);
  ~PackedFile();
  PackedFile(const PackedFile&) = delete;
  PackedFile& operator=(const PackedFile&) = delete;

  void write(std::string_view text);
  void commit();

 private:
  struct Packer;
  struct Gzip;
  struct Bzip2;

  AtomicFile file_;
  std::unique_ptr<Packer> packer_;
};

}  // namespace loopstone
