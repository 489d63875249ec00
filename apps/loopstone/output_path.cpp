#include "output_path.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <system_error>

#include "interrupt.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/formats/log_files.hpp"
#include "loopstone/formats/output_place.hpp"
#include "loopstone/formats/ros_map.hpp"

namespace loopstone::app {

namespace {

namespace fs = std::filesystem;

bool is_there(const fs::path& path) {
  std::error_code ignored;
  return fs::exists(path, ignored);
}

bool is_folder(const fs::path& path) {
  std::error_code ignored;
  return fs::is_directory(path, ignored);
}

/// The same device and inode, through links as well.
bool is_same(const fs::path& a, const fs::path& b) {
  std::error_code ignored;
  return fs::equivalent(a, b, ignored);
}

bool is_file_or_folder(const fs::path& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored) || fs::is_directory(path, ignored);
}

fs::path folder_of(const fs::path& file) {
  return file.has_parent_path() ? file.parent_path() : fs::path(".");
}

/// Of a path whose folders are missing the first one that is.
fs::path first_to_make(fs::path path) {
  while (path.has_parent_path() && !is_there(path.parent_path())) path = path.parent_path();
  return path;
}

/// "out/" and "out" are the same folder.
fs::path plain(const std::string& path) {
  std::error_code error;
  fs::path full = fs::weakly_canonical(path, error);
  if (error) full = fs::path(path).lexically_normal();
  return full.has_filename() ? full : full.parent_path();
}

/// "LOG#120", "DIR#20@+12.5", "FILE.mat#variable": what is there without the rest.
std::string without_part(std::string path) {
  for (std::size_t mark = path.npos; !is_there(path);) {
    mark = path.find_last_of("#@", mark == path.npos ? mark : mark - 1);
    if (mark == path.npos || mark == 0) break;
    path.erase(mark);
  }
  return path;
}

}  // namespace

bool is_stream(const std::string& path) {
  std::error_code ignored;
  const fs::file_status status = fs::status(path, ignored);
  const std::string name = fs::path(path).lexically_normal().string();
  return name == "/dev/stdout" || name == "/dev/stderr" || name.starts_with("/dev/fd/") ||
         name.starts_with("/proc/self/fd/") ||
         (fs::exists(status) && !fs::is_regular_file(status) && !fs::is_directory(status));
}

void add_force_flag(CLI::App& command, bool& force) {
  command.add_flag("--force", force, "replace what is there already under an output's name");
}

void add_trajectory_output(const std::string& path, Outputs& outputs) {
  const fs::path file(path);
  if (file.extension() == ".csv") {
    throw UsageError("-o " + path +
                     ": the table beside the trajectory takes that name; name this one .tum");
  }
  outputs.add_file("-o", path);
  if (!is_stream(path)) outputs.add_file("", fs::path(file).replace_extension(".csv"));
}

std::int64_t least_bytes_of_results(std::int64_t log_bytes) {
  // A log spends 100 bytes or more on what becomes one; packed ones spend a tenth of that.
  return Outputs::kLeastBytes + log_bytes / 100;
}

Outputs::Outputs(const AppContext& context, bool force) : force_(force) {
  for (const std::string& path : context.option_paths()) reads(path);
}

void Outputs::reads_log(const std::string& log) {
  reads(log);
  for (const std::string& path : LogFiles(log).paths()) inputs_.push_back(path);
}

void Outputs::reads(const std::string& path) {
  if (path.empty()) return;
  inputs_.push_back(without_part(path));
  if (!path.ends_with(".yaml") && !path.ends_with(".yml")) return;
  try {
    inputs_.push_back(ros_map_picture(path));
  } catch (const std::exception&) {
    // Whoever reads it says what is wrong with it.
  }
}

void Outputs::add_file(const std::string& flag, const std::string& path, bool in_new_folder) {
  outputs_.push_back({flag, path, false, force_, in_new_folder});
}

void Outputs::add_folder(const std::string& flag, const std::string& path,
                         bool may_hold_something) {
  outputs_.push_back({flag, path, true, force_ || may_hold_something, true});
}

std::string Outputs::named(const Output& output) {
  return output.flag.empty() ? output.path : output.flag + " " + output.path;
}

void Outputs::check(std::int64_t least_bytes) const {
  check_names();
  for (const Output& output : outputs_) {
    check_inputs(output);
    if (output.is_folder) {
      check_folder(output, least_bytes);
    } else {
      check_file(output, least_bytes);
    }
  }
}

void Outputs::check_names() const {
  for (auto a = outputs_.begin(); a != outputs_.end(); ++a) {
    if (a->path.empty()) {
      throw UsageError(a->flag + ": the name of an output is empty");
    }
    if (!a->is_folder && is_stream(a->path)) continue;
    const fs::path path = plain(a->path);
    for (auto b = outputs_.begin(); b != outputs_.end(); ++b) {
      if (a < b && path == plain(b->path)) {
        throw UsageError(named(*b) + ": is named for two outputs, here and by " + a->flag +
                         "; each needs its own");
      }
      if (!a->is_folder && b->is_folder && path.parent_path() == plain(b->path)) {
        throw UsageError(named(*a) + ": lies in the folder of " + b->flag +
                         ", which is a set of results of its own; write it elsewhere");
      }
    }
  }
}

void Outputs::check_inputs(const Output& output) const {
  for (const std::string& input : inputs_) {
    if (is_same(output.path, input) && is_file_or_folder(input)) {
      throw UsageError(named(output) + ": is what this command reads (" + input +
                       "); write to another place");
    }
    if (output.is_folder && !is_folder(input) && is_same(output.path, folder_of(input))) {
      throw UsageError(named(output) + ": holds what this command reads (" + input +
                       "); write to another folder");
    }
  }
}

void Outputs::check_file(const Output& output, std::int64_t least_bytes) const {
  const fs::path path(output.path);
  if (is_folder(path)) {
    throw UsageError(named(output) + ": is a folder; name a file in it");
  }
  if (is_stream(path)) return;
  if (is_there(path) && !output.may_exist) {
    throw UsageError(named(output) + ": exists; choose another name, or --force overwrites it");
  }
  if (!output.in_new_folder && !is_folder(folder_of(path))) {
    throw DataError({output.path}, "there is no folder " + folder_of(path).string());
  }
  require_room(first_to_make(path).string(), least_bytes);
}

void Outputs::check_folder(const Output& output, std::int64_t least_bytes) const {
  const fs::path path = plain(output.path);
  if (is_there(path) && !is_folder(path)) {
    throw UsageError(named(output) + ": is a file; the output needs a folder");
  }
  if (is_folder(path)) {
    if (!output.may_exist && !holds_nothing(path.string())) {
      throw UsageError(named(output) +
                       ": is not empty; choose another folder or add --force to overwrite");
    }
    return require_room((path / "summary.json").string(), least_bytes);
  }
  require_room(first_to_make(path).string(), least_bytes);
}

void Outputs::prepare() const {
  for (const Output& output : outputs_) {
    if (!output.is_folder) {
      if (is_stream(output.path)) continue;
      const UnfinishedOutput file{folder_of(output.path).string(),
                                  fs::path(output.path).filename().string()};
      remove_partial_files(file.folder, file.name);
      clean_up_when_interrupted(file);
      continue;
    }
    std::error_code error;
    const bool was_made = fs::create_directories(output.path, error);
    if (error) throw DataError({output.path}, "cannot make the folder: " + error.message());
    remove_partial_files(output.path);
    clean_up_when_interrupted({output.path, {}, was_made});
  }
}

}  // namespace loopstone::app
