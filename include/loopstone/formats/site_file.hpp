#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "loopstone/base/stamp.hpp"
#include "loopstone/base/words.hpp"
#include "loopstone/formats/site_edit.hpp"
#include "loopstone/slam/drive_record.hpp"
#include "loopstone/slam/joined_drives.hpp"

namespace loopstone {

// The file of a site: one SQLite database, which docs/sites.md describes. It keeps what each
// session of one building has led to, and what was found between them. What is one change for its
// user is one transaction: whatever ends a program, and when, the site is as it was before or
// after.

/// What became of a session.
enum class SessionStatus {
  kJoined,    ///< part of the site's map
  kPending,   ///< kept beside it until a later one ties it
  kRefused,   ///< its own map is bad: nothing of it is kept but this row
  kRetired,   ///< it was joined; newer ones show all that it saw, and nothing of it is kept
  kExcluded,  ///< kept beside the map by an edit, as long as that stands
};

constexpr auto words_of(SessionStatus /*any*/) {
  using enum SessionStatus;
  return std::array{Word{kJoined, "joined"}, Word{kPending, "pending"}, Word{kRefused, "refused"},
                    Word{kRetired, "retired"}, Word{kExcluded, "excluded"}};
}

/// One drive of a robot in the building.
struct SiteSession {
  std::int64_t id = 0;   ///< given by the file
  std::string log{};     ///< where its log was
  std::string digest{};  ///< of its messages (LogDigest); no two sessions have the same
  Stamp begins{};        ///< when, of the Unix epoch; what orders the sessions
  std::string added{};   ///< when it came into the site, ISO 8601, UTC
  std::string robot{};   ///< as TOML
  SessionStatus status = SessionStatus::kPending;
  std::string reason{};  ///< why it is not joined
  int closures = 0;      ///< that stand and tie it to others
  std::int64_t scans = 0;
  double path_m = 0.0;
  double duration_s = 0.0;
  std::string verdict{};  ///< on its own map
  std::string sentence{};
};

/// Something that was done to a site.
struct SiteEvent {
  std::string at{};  ///< ISO 8601, UTC
  std::string what{};
  std::string session{};  ///< its log; empty: of the site as a whole
  std::string text{};
};

/// What joins sessions, by their ids.
struct SitePair {
  std::int64_t older = 0;
  std::int64_t newer = 0;
  DrivePair pair{};
};
struct SitePlacement {
  std::int64_t session = 0;
  DrivePlacement placement{};
};

enum class SiteAccess { kRead, kWrite };

/// A connection to a site's file. All throw DataError with what is wrong and what to do.
class SiteFile {
 public:
  /// Of a site that is new: there must be no file. Its options are those of all its maps.
  static void create(const std::string& path, const std::string& options_toml);
  /// The same, unless there is a file. \return whether there was none
  static bool create_where_missing(const std::string& path, const std::string& options_toml);

  SiteFile(const std::string& path, SiteAccess access);
  ~SiteFile();
  SiteFile(const SiteFile&) = delete;
  SiteFile& operator=(const SiteFile&) = delete;

  [[nodiscard]] const std::string& path() const;
  [[nodiscard]] const std::string& options_toml() const;
  /// In the order in which they were driven.
  [[nodiscard]] std::vector<SiteSession> sessions() const;
  [[nodiscard]] std::vector<SiteEvent> events() const;
  /// What was corrected by hand, in the order in which it was done.
  [[nodiscard]] std::vector<SiteEdit> edits() const;
  /// Of a session that is joined, pending or excluded.
  [[nodiscard]] std::shared_ptr<const DriveRecord> record(const SiteSession& session) const;
  [[nodiscard]] std::vector<SitePair> pairs() const;
  [[nodiscard]] std::vector<SitePlacement> placements() const;

  /// From here to commit() others may read what was, and nobody else writes. Waits for who does.
  /// \param waiting  told when it has to wait, then now and then; false: gives up (UsageError)
  void begin_change(const std::function<bool()>& waiting = {});
  /// \return its id
  std::int64_t add(const SiteSession& session, const DriveRecord* record);
  /// Status, reason and closures; of one that is not excluded.
  void update(const SiteSession& session);
  /// The row stays.
  void drop_record(std::int64_t session);
  void remove(std::int64_t session);
  /// All of them, in place of those before.
  void set_joins(const std::vector<SitePair>& pairs, const std::vector<SitePlacement>& placements);
  /// \return its id
  std::int64_t add_edit(const SiteEdit& edit);
  /// Of the edit's polygon.
  void set_place(std::int64_t edit, const std::optional<SiteAnchor>& anchor,
                 const Polygon2& polygon);
  /// \return whether there was such an edit
  bool remove_edit(std::int64_t edit);
  void add_event(const SiteEvent& event);
  void commit();

  /// Everything that is wrong with the file, in words: with what is lost by it.
  [[nodiscard]] std::vector<std::string> check() const;
  /// Of the file and of what is on its way into it.
  [[nodiscard]] std::int64_t bytes() const;
  /// Gives back the room of what was removed.
  void compact();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Whether there is a file that says it is a site.
[[nodiscard]] bool is_site(const std::string& path);

}  // namespace loopstone
