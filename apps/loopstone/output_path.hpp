#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "app.hpp"

namespace loopstone::app {

/// --force.
void add_force_flag(CLI::App& command, bool& force);

/// A pipe, a terminal, /dev/null, or what /dev/stdout stands for: nothing of it is replaced.
[[nodiscard]] bool is_stream(const std::string& path);

/// What a command reads and what it would write. One rule for all commands, held before the work
/// begins:
///
/// - An output that is an input, by whatever name or link, is refused, also with --force. So is a
///   folder that is read, or holds a file that is read.
/// - A file that exists, and a folder that holds something, are refused without --force. Pipes and
///   devices are written to.
/// - Two outputs have two names, and no file lies in a folder that becomes a set of results.
/// - Where something will be written, files can be made and there is room.
///
///   Outputs outputs(context, arguments.force);
///   outputs.reads_log(arguments.log);
///   outputs.add_file("-o", arguments.output);
///   outputs.check();
///   ... open what is read ...
///   outputs.prepare();
class Outputs {
 public:
  /// The files of -c and --robot are inputs of every command.
  Outputs(const AppContext& context, bool force);

  void reads_log(const std::string& log);
  /// A file, whatever stands behind '#' or '@' in its name; of a map.yaml its picture, too; or a
  /// folder.
  void reads(const std::string& path);

  /// \param flag  for messages; empty for an output without one
  /// \param in_new_folder  its folder need not be there, whoever writes it makes it
  void add_file(const std::string& flag, const std::string& path, bool in_new_folder = false);
  /// \param may_hold_something  though --force is not given
  void add_folder(const std::string& flag, const std::string& path,
                  bool may_hold_something = false);

  /// \param least_bytes  that the run will write for certain
  /// Throws UsageError or DataError, with the name of the output and what to do.
  void check(std::int64_t least_bytes = kLeastBytes) const;
  /// Makes the folders and removes what killed runs left of these outputs. After check().
  void prepare() const;

  static constexpr std::int64_t kLeastBytes = 4096;

 private:
  struct Output {
    std::string flag;
    std::string path;
    bool is_folder = false;
    bool may_exist = false;
    bool in_new_folder = false;
  };
  [[nodiscard]] static std::string named(const Output& output);
  void check_names() const;
  void check_inputs(const Output& output) const;
  void check_file(const Output& output, std::int64_t least_bytes) const;
  void check_folder(const Output& output, std::int64_t least_bytes) const;

  bool force_;
  std::vector<std::string> inputs_{};
  std::vector<Output> outputs_{};
};

/// "-o FILE.tum" of localisation, which has a table beside it. Throws UsageError for a name that
/// the table takes.
void add_trajectory_output(const std::string& path, Outputs& outputs);

/// What any run leaves that reads so much of a log: far less than the truth, and known before.
[[nodiscard]] std::int64_t least_bytes_of_results(std::int64_t log_bytes);

}  // namespace loopstone::app
