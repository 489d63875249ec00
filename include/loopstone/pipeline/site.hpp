#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "loopstone/base/parallel_for.hpp"
#include "loopstone/base/progress.hpp"
#include "loopstone/formats/site_file.hpp"
#include "loopstone/mapping/travel.hpp"
#include "loopstone/mapping/visit_coverage.hpp"
#include "loopstone/mapping/visit_ledger.hpp"
#include "loopstone/pipeline/cut_log.hpp"
#include "loopstone/pipeline/log_source.hpp"
#include "loopstone/slam/decision_numbers.hpp"
#include "loopstone/slam/drive_record.hpp"
#include "loopstone/slam/joined_drives.hpp"
#include "loopstone/slam/map_options.hpp"
#include "loopstone/slam/map_result.hpp"

// One map of a building from many drives of many robots, kept true as the building changes.

namespace loopstone {

/// What a site keeps, and for how long.
struct SiteNumbers {
  int keep_visits = 10;
  int keep_shown_alone = 50;
  int keep_pending = 30;
  double visit_cell_m = 2.0;
};
inline constexpr SiteNumbers kSite{};

template <typename Visitor>
void visit_numbers(const SiteNumbers& n, Visitor&& visit) {
  visit("keep_visits", n.keep_visits,
        "chosen: a session is kept until so many newer ones came by wherever it drove");
  visit("keep_shown_alone", n.keep_shown_alone,
        "chosen: a session that newer ones were compared with stays until there are so many, since "
        "to do without it they are compared with one another");
  visit("keep_pending", n.keep_pending,
        "chosen: a session that nothing ties to any other waits for so many newer ones, each of "
        "which is compared with it");
  visit("visit_cell_m", n.visit_cell_m,
        "chosen: who drove through one square of this side came by");
}

/// What sites decide by, as decision_numbers() has it for maps.
[[nodiscard]] std::vector<NumberGroup> site_numbers();

/// A log that was mapped by itself, on its way into a site.
struct MappedSession {
  SiteSession session{};
  std::shared_ptr<const DriveRecord> record{};  ///< none: its map is bad, or was broken off
  bool complete = true;                         ///< false: it was called off
};

/// Maps a log for a site. Cost: of map_log(). Throws as that does.
/// \param begins  when it was driven; nothing: as its stamps say
[[nodiscard]] MappedSession map_session(const LogSource& source, LogReader& reader,
                                        const LogCut& cut, const MapOptions& options,
                                        Threads threads, std::optional<Stamp> begins = {},
                                        const ReadingWatch& watch = {});

/// What is known of the cells of a site's map beside what stands there.
struct SiteGrids {
  VisitCoverage coverage{};
  Grid<CellTravel> travel{};
  Grid<float> glass{};  ///< GlassSurvey::probability()
};

/// What a map of a site is asked for beside the map.
struct SiteExtras {
  bool scans = false;
  bool grids = false;
};

/// What somebody corrected by hand, as a map tells it.
struct SiteCorrection {
  SiteEdit edit{};
  /// Of a polygon: where it lies on the map. Nothing: what it lay on is no part of the map.
  std::optional<Polygon2> on_map{};
  std::int64_t cells = 0;  ///< of a map that was drawn: how many of its cells were set
};

/// Walls that were drawn by hand, on the map.
[[nodiscard]] std::vector<Polygon2> walls_of(std::span<const SiteCorrection> edits);

/// The map of a site at a time.
struct SiteMap {
  MapResult result{};                   ///< its map is what the visits agree on
  Grid<float> movable{};                ///< VisitLedger::movable(), of the same cells
  std::optional<SiteGrids> grids{};     ///< likewise, where asked for
  std::vector<SiteSession> sessions{};  ///< that are joined, in order: the result's drives
  MappedScans scans{};                  ///< where asked for; stamped as the result's trajectory
  std::vector<SiteCorrection> edits{};  ///< that it was drawn with, all of the site's
};

/// Who waits while a site is changed.
struct SiteWatch {
  ProgressCallback progress{};    ///< false: leaves the site as it was, and throws UsageError
  std::function<bool()> waits{};  ///< somebody else writes; false: gives up
};

/// A site: its file, and what is done to it. Each change is one transaction of the file.
class Site {
 public:
  /// Throws DataError as SiteFile does, or where its options are of another version.
  Site(const std::string& path, SiteAccess access, Threads threads);

  [[nodiscard]] const SiteFile& file() const { return file_; }
  [[nodiscard]] const MapOptions& options() const { return options_; }
  [[nodiscard]] std::vector<SiteSession> sessions() const { return file_.sessions(); }

  /// Looks for a session among the others, without a guess. One that is older than some that are in
  /// already makes all of them be joined anew: the order in which sessions are added changes
  /// nothing.
  /// Returns it as it is then. Throws UsageError when it is there already.
  SiteSession add(const MappedSession& mapped, const SiteWatch& watch = {});
  /// Removes sessions and all that rests on them.
  void remove(const std::vector<std::int64_t>& sessions, const SiteWatch& watch = {});
  /// Finds all that ties sessions anew.
  void rebuild(const SiteWatch& watch = {});

  /// What was corrected by hand, oldest first.
  [[nodiscard]] std::vector<SiteCorrection> edits() const;
  /// Leaves a session out of the map, which is then as if it had never been there, until the edit
  /// is undone. Returns the edit. Throws UsageError when there is no such session, or nothing of it
  /// to leave out.
  SiteEdit exclude(std::int64_t session, const SiteWatch& watch = {});
  /// Undoes that. Throws UsageError when it is not left out.
  SiteEdit include(std::int64_t session, const SiteWatch& watch = {});
  /// Says what the cells of a polygon are, in every map that is made of the site; later edits beat
  /// earlier ones. The polygon goes with what was seen around it when the map moves.
  /// \param kind     no exclusion
  /// \param polygon  in the frame of the map
  /// Throws UsageError when it is unsound or lies far from all that was seen, DataError when there
  /// is no map yet.
  SiteEdit set_cells(SiteEditKind kind, const Polygon2& polygon, const SiteWatch& watch = {});
  /// Throws UsageError when there is no such edit.
  void undo(std::int64_t edit, const SiteWatch& watch = {});

  /// \param until     of sessions that began until then; all of them hold the map together
  /// \param progress  false: throws UsageError
  [[nodiscard]] SiteMap map(std::optional<Stamp> until = {}, const SiteExtras& extras = {},
                            const ProgressCallback& progress = {}) const;
  /// Where the building at one time differs from what it was at another one, on the map of the
  /// later.
  struct Difference {
    SiteMap now{};
    OccupancyMap before{};  ///< corrected by hand as `now` is
    std::vector<MapChange> changes{};
  };
  /// \param to        nothing: today
  /// \param progress  false: throws UsageError
  [[nodiscard]] Difference difference(Stamp from, std::optional<Stamp> to = {},
                                      const ProgressCallback& progress = {}) const;

 private:
  struct Kept {
    std::vector<SiteSession> sessions{};
    JoinedDrives drives;
  };
  [[nodiscard]] Kept load(std::optional<std::int64_t> without = {},
                          const ProgressCallback& progress = {}) const;
  [[nodiscard]] Kept join_all(const std::vector<SiteSession>& sessions,
                              const SiteWatch& watch) const;
  using TakeSession = std::function<void(const SiteSession& session, const DriveVisit& visit)>;
  [[nodiscard]] SiteMap draw(const Kept& kept, const ProgressCallback& progress,
                             const TakeSession& take) const;
  /// Where sessions and edits lay before a change.
  struct Places {
    std::vector<SitePlacement> placements{};
    std::vector<SiteCorrection> edits{};
  };
  [[nodiscard]] Places begin_change(const SiteWatch& watch);
  void rejoin(const Places& before, const SiteWatch& watch);
  void store(Kept& kept, const Places& before);
  void keep_edits_in_place(const Places& before);
  [[nodiscard]] std::vector<SiteCorrection> corrections_on(const Kept& kept) const;
  void retire(SiteSession session, int closures, std::string reason);
  void give_up_waiting(Kept& kept);
  void retire_worn_out(Kept& kept);
  void note(const std::string& what, const std::string& session, const std::string& text);

  SiteFile file_;
  MapOptions options_{};
  Threads threads_;
};

/// What prune_site() removed, and the size of the file before and after.
struct SitePruning {
  std::size_t removed = 0;  ///< sessions
  std::int64_t bytes_before = 0;
  std::int64_t bytes = 0;
};

/// Removes sessions as if they had never been there, and gives back their room.
/// \param pending  those that are pending, too
/// Throws UsageError when there is no such session.
[[nodiscard]] SitePruning prune_site(const std::string& path, std::vector<std::int64_t> sessions,
                                     bool pending, Threads threads, const SiteWatch& watch = {});

/// "2026-11-26T14:03:00Z".
[[nodiscard]] std::string utc_text(Stamp stamp);
/// Reads "2026-11-26", with "T14:03" or "T14:03:00" behind it, with or without Z; UTC. Nothing for
/// what is none.
[[nodiscard]] std::optional<Stamp> parse_utc(const std::string& text);
/// The same of what lasts until then: of a day without a time its end.
[[nodiscard]] std::optional<Stamp> parse_utc_end(const std::string& text);

}  // namespace loopstone
