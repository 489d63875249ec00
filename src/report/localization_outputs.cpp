#include "loopstone/report/localization_outputs.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <system_error>

#include "loopstone/base/error.hpp"
#include "loopstone/formats/image.hpp"
#include "loopstone/formats/localization_csv.hpp"
#include "loopstone/formats/tum.hpp"
#include "loopstone/report/localization_picture.hpp"
#include "report/localization_html.hpp"
#include "report/output_files.hpp"
#include "report/with_peak_memory.hpp"

namespace loopstone {

namespace fs = std::filesystem;

namespace {

std::string frame_name(std::int64_t number) { return fmt::format("{:06}.png", number); }

}  // namespace

void write_localization_outputs(const LocalizationResult& result,
                                const Grid<std::int8_t>& occupancy, const LocalizationRunInfo& info,
                                const std::string& out_dir) {
  OutputFolder folder(out_dir, info.run.force);
  FileSet files(folder);
  const std::string picture =
      encode_png(draw_localization_picture(result, occupancy), kPngCompression);
  files.add("map.png", "the map, the path by state, particles, to look at", picture);
  files.add("trajectory.tum", "pose of every scan: t x y z qx qy qz qw",
            format_tum(result.trajectory()));
  files.add("localization.csv", "the same with covariance, state, probability and evidence",
            format_localization_csv(result.estimates));
  files.add("options.toml", "the effective options", info.run.options_toml);
  LocalizationRunInfo until_now = info;
  until_now.run = with_peak_memory(info.run);
  files.add("summary.json", "every figure of the run, for programs",
            format_summary(result, occupancy, until_now));
  files.add("report.html", "this page",
            format_localization_report(result, occupancy, until_now, picture, files.listed()));
  files.commit();
  folder.keep();
}

std::string write_localization_trajectory(const LocalizationResult& result,
                                          const std::string& tum_path) {
  const fs::path path(tum_path);
  std::error_code ignored;
  if (const fs::file_status status = fs::status(path, ignored);
      fs::exists(status) && !fs::is_regular_file(status) && !fs::is_directory(status)) {
    write_tum(tum_path, result.trajectory());
    return {};
  }
  std::string csv_path = fs::path(path).replace_extension(".csv").string();
  if (csv_path == tum_path) {
    throw UsageError(tum_path + ": is the name of the table beside the trajectory; name it .tum");
  }
  AtomicFile tum(tum_path);
  AtomicFile csv(csv_path);
  tum.write(format_tum(result.trajectory()));
  tum.finish_writing();
  csv.write(format_localization_csv(result.estimates));
  csv.finish_writing();
  tum.commit();
  csv.commit();
  return csv_path;
}

std::int64_t write_localization_animation(const LocalizationResult& result,
                                          const Grid<std::int8_t>& occupancy,
                                          const std::string& out_dir, bool force) {
  OutputFolder folder(out_dir, force);
  if (result.snapshots.empty()) {
    folder.keep();
    return 0;
  }
  const BeliefPainter painter(occupancy, result.start);
  std::int64_t number = 0;
  for (const BeliefSnapshot& snapshot : result.snapshots) {
    write_png(folder.file(frame_name(++number)), painter.draw(snapshot), kPngCompression);
    folder.keep();
  }
  // What a longer run left here would be taken for the end of this one.
  std::error_code ignored;
  for (std::int64_t old = number + 1; fs::remove(folder.file(frame_name(old)), ignored);) ++old;
  return number;
}

}  // namespace loopstone
