#pragma once

#include <span>
#include <string>
#include <vector>

#include "formats/atomic_file.hpp"

namespace loopstone {

/// Writes a .npz file. Small arrays are handed over as bytes; large ones as a file that already
/// holds the .npy. The same arrays give the same bytes: members carry no time.
class NpzWriter {
 public:
  explicit NpzWriter(const std::string& path) : path_(path) {}

  void add(const std::string& key, const std::string& descr, bool fortran_order,
           std::span<const std::int64_t> shape, std::span<const char> data);
  void add_file(const std::string& key, const std::string& npy_path);
  void add_number(const std::string& key, double value);
  void add_row(const std::string& key, std::span<const double> values);

  /// Compresses everything into a temporary file beside the target; to be committed by the caller.
  [[nodiscard]] AtomicFile write() const;

 private:
  struct Member {
    std::string key;
    std::string bytes;       ///< the whole .npy, or
    std::string npy_path{};  ///< where it is
  };
  std::string path_;
  std::vector<Member> members_;
};

}  // namespace loopstone
