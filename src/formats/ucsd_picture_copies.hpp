#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace loopstone {

/// Copies of the pictures of one camera, numbered from 1 in the order in which they come:
/// FOLDER/PREFIX1.png and so on. They are gathered in a hidden folder beside FOLDER and appear
/// there with finish(); without it they vanish. A picture that lies at its place already is left
/// alone.
class UcsdPictureCopies {
 public:
  UcsdPictureCopies(std::filesystem::path folder, std::string prefix);
  ~UcsdPictureCopies();
  UcsdPictureCopies(const UcsdPictureCopies&) = delete;
  UcsdPictureCopies& operator=(const UcsdPictureCopies&) = delete;

  /// Throws DataError when the picture can't be copied.
  void add(const std::string& picture);
  void finish();

 private:
  std::filesystem::path folder_;
  std::filesystem::path waiting_folder_;
  std::string prefix_;
  std::vector<std::string> waiting_;  // names in waiting_folder_
  std::int64_t count_ = 0;
};

}  // namespace loopstone
