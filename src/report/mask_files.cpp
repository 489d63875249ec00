#include "report/mask_files.hpp"

#include <filesystem>
#include <system_error>

#include "formats/atomic_file.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/formats/filter_mask_file.hpp"

namespace loopstone {

void write_mask(const CellStates& values, const std::string& folder, const std::string& name) {
  AtomicFile picture(folder + "/" + name + ".pgm");
  picture.write(encode_pgm(mask_image({.values = values})));
  AtomicFile yaml(folder + "/" + name + ".yaml");
  yaml.write(format_mask_yaml(values.frame(), name + ".pgm"));
  picture.finish_writing();
  yaml.finish_writing();
  picture.commit();
  yaml.commit();
}

void make_folder(const std::string& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw DataError({folder}, "can't be made: " + error.message());
}

}  // namespace loopstone
