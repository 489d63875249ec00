#include "loopstone/report/map_outputs.hpp"

#include <deque>
#include <filesystem>
#include <system_error>

#include "formats/atomic_file.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/formats/g2o.hpp"
#include "loopstone/formats/image.hpp"
#include "loopstone/formats/ros_map.hpp"
#include "loopstone/formats/tum.hpp"
#include "loopstone/report/map_picture.hpp"
#include "report/report_html.hpp"

namespace loopstone {
namespace {

namespace fs = std::filesystem;

/// Low: these pictures are flat areas, and a second of packing would save some ten kilobytes.
constexpr int kPngCompression = 2;

/// The output folder; one that was made here goes away again unless it is kept.
class OutputFolder {
 public:
  OutputFolder(const std::string& path, bool force) : path_(path) {
    std::error_code error;
    const fs::file_status status = fs::status(path_, error);
    if (fs::exists(status) && !fs::is_directory(status))
      throw UsageError(path + ": is a file; the output must be a folder");
    if (!fs::exists(status)) {
      fs::create_directories(path_, error);
      if (error) throw DataError({path}, "cannot make this folder: " + error.message());
      made_ = true;
      return;
    }
    const fs::directory_iterator first(path_, error);
    if (error) throw DataError({path}, "cannot open this folder: " + error.message());
    if (!force && first != fs::directory_iterator()) {
      throw UsageError(path + ": holds files already; choose another folder or add --force");
    }
  }
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;
  ~OutputFolder() {
    std::error_code ignored;
    if (made_ && !kept_) fs::remove(path_, ignored);  // only when empty
  }

  [[nodiscard]] std::string file(const std::string& name) const { return (path_ / name).string(); }
  void keep() { kept_ = true; }

 private:
  fs::path path_;
  bool made_ = false;
  bool kept_ = false;
};

/// Files that are all complete on disk before the first appears.
class FileSet {
 public:
  explicit FileSet(const OutputFolder& folder) : folder_(folder) {}

  void add(const std::string& name, const std::string& content, std::string_view bytes) {
    AtomicFile& file = files_.emplace_back(folder_.file(name));
    file.write(bytes);
    file.finish_writing();
    listed_.push_back({name, content, static_cast<std::int64_t>(bytes.size())});
  }
  [[nodiscard]] const std::vector<ListedFile>& listed() const { return listed_; }
  void commit() {
    for (AtomicFile& file : files_) file.commit();
  }

 private:
  const OutputFolder& folder_;
  std::deque<AtomicFile> files_{};
  std::vector<ListedFile> listed_{};
};

/// A run that ended before its first scan still leaves a map that every tool can open: one unknown cell.
CellStates states_to_write(const OccupancyMap& map) {
  if (!map.log_odds.empty()) return cell_states(map);
  const GridFrame frame{.resolution = OccupancyOptions{}.resolution_m, .columns = 1, .rows = 1};
  return CellStates(frame, kUnknownCell);
}

}  // namespace

void write_map_outputs(const MapResult& result, const RunInfo& info, const std::string& out_dir) {
  OutputFolder folder(out_dir, info.force);
  FileSet files(folder);
  const CellStates cells = states_to_write(result.map);
  const std::string picture = encode_png(draw_map_picture(result), kPngCompression);
  files.add("map.png", "the map, the path and the loop closures, to look at", picture);
  files.add("map.pgm", "occupancy as map_server reads it", encode_pgm(map_image(cells)));
  files.add("map.yaml", "frame and thresholds of map.pgm",
            format_map_yaml(cells.frame(), "map.pgm"));
  files.add("trajectory.tum", "optimised pose of every scan: t x y z qx qy qz qw",
            format_tum(result.trajectory));
  files.add("odometry.tum", "the same from odometry alone", format_tum(result.odometry));
  files.add("graph.g2o", "the final pose graph", format_g2o(result.graph));
  files.add("options.toml", "the effective options", info.options_toml);
  files.add("summary.json", "every figure of the run, for programs", format_summary(result, info));
  files.add("report.html", "this page", format_report(result, info, picture, files.listed()));
  files.commit();
  folder.keep();
}

}  // namespace loopstone
