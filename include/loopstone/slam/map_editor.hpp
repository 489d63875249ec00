#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "loopstone/base/parallel_for.hpp"
#include "loopstone/base/progress.hpp"
#include "loopstone/mapping/filter_mask.hpp"
#include "loopstone/slam/decision_numbers.hpp"
#include "loopstone/slam/loop_closure.hpp"
#include "loopstone/slam/map_edit.hpp"
#include "loopstone/slam/map_result.hpp"
#include "loopstone/slam/map_verdict.hpp"
#include "loopstone/slam/settled_map.hpp"

namespace loopstone {

/// What edits of a map are judged by, beside what closures are judged by.
struct MapEditorNumbers {
  double same_closure_s = 2.0;
  double guess_half_m = 1.0;
  double guess_half_rad = 0.2;
  double again_half_m = 0.35;
  double again_half_rad = 0.06;
  double told_m = 0.1;
  double told_rad = 0.02;
};
inline constexpr MapEditorNumbers kMapEditor{};

template <typename Visitor>
void visit_numbers(const MapEditorNumbers& n, Visitor&& visit) {
  visit("same_closure_s", n.same_closure_s,
        "chosen: a closure is meant by moments this near to its own; a robot goes a metre or two");
  visit("guess_half_m", n.guess_half_m,
        "chosen: half of the window about a pose that somebody guessed");
  visit("guess_half_rad", n.guess_half_rad, "chosen: the same of the heading, 11 degrees");
  visit("again_half_m", n.again_half_m,
        "chosen: half of the window about a closure that is measured again without some scans; as "
        "where two places are connected directly");
  visit("again_half_rad", n.again_half_rad, "chosen: the same of the heading");
  visit("told_m", n.told_m,
        "chosen: standard deviation of a pose that somebody told where no scan bears it out");
  visit("told_rad", n.told_rad, "chosen: the same of the heading, about a degree");
}

/// The numbers that edits are judged by, for the record.
[[nodiscard]] std::vector<NumberGroup> edit_numbers();

/// How far key scans moved.
struct MapShift {
  double mean_m = 0.0;
  double largest_m = 0.0;
  double largest_rad = 0.0;
};

/// What became of an edit.
struct EditReport {
  bool applied = false;  ///< false: it was refused, and nothing has changed
  std::string told{};    ///< what it did, or why it was refused; plain words, one line
  std::optional<LoopClosure> closure{};  ///< added, taken out or refused, with its figures
  MapShift shift{};                      ///< of the graph's solution
  int closures_revoked = 0;              ///< others that contradict the graph since
  double reduced_chi2_before = 0.0;      ///< of the graph's loops
  double reduced_chi2 = 0.0;
  Verdict verdict_before = Verdict::kUnknown;  ///< of the graph alone
  Verdict verdict = Verdict::kUnknown;
  double seconds = 0.0;  ///< that it took
};

/// A map with its edits as far as it is known before it is drawn.
struct EditPreview {
  std::vector<Pose2> map_T_keys{};  ///< of the graph's nodes, in the frame that edits ask for
  std::vector<LoopClosure> closures{};
  GraphQuality graph_quality{};         ///< without what the adjustment will say
  Verdict verdict = Verdict::kUnknown;  ///< by it and by the breaks of the path
  MapShift shift{};                     ///< from the map without edits
  /// Of each edit, where its polygon lies now; empty for others.
  std::vector<Polygon2> polygons{};
};

/// A map with its edits, drawn.
struct EditedMap {
  MapResult result{};
  /// Where the map's first frame lies in the one that edits ask for.
  Pose2 new_T_map{};
  /// Zones on the result's map.
  std::vector<KeepOutZone> keep_out{};
  std::vector<SpeedZone> speed{};
  std::int64_t cells_erased = 0;
  MapShift shift{};  ///< of the graph's solution, from the map without edits
};

/// A finished map in somebody's hand. It holds what the map was made of, and a list of edits; what
/// the list says is done at once to the graph, which takes milliseconds, and to the map when it is
/// drawn. Nothing is ever patched: a map is that of its list, so taking the last edit away is to
/// undo it, to the last byte.
///
///   MapEditor editor(mapper.settle(), threads);
///   const EditReport& report = editor.add({.what = DeleteClosure{...}});
///   show(editor.preview(), report.told);
///   editor.undo();
///   EditedMap map = editor.draw();
///
/// The same bytes for any number of threads, and however the list was arrived at. Not thread-safe.
class MapEditor {
 public:
  /// Cost: the adjustment to surfaces and the calibration, some tenths of a second.
  explicit MapEditor(SettledMap map, Threads threads = {});
  ~MapEditor();
  MapEditor(MapEditor&&) noexcept;
  MapEditor& operator=(MapEditor&&) noexcept;

  /// One more, behind those that are there. It is on the list even when it is refused, and then
  /// changes nothing. Cost: of closures and stretches a solution of the graph, of a closure that is
  /// added a search as well: some tens of milliseconds. Others cost nothing.
  const EditReport& add(const MapEdit& edit);
  /// Takes the last one away; false when there is none.
  bool undo();
  /// The whole list anew. What begins as the list before is not done again.
  void set_edits(std::span<const MapEdit> edits);

  [[nodiscard]] std::size_t size() const;
  [[nodiscard]] const MapEdit& edit(std::size_t place) const;
  [[nodiscard]] const EditReport& report(std::size_t place) const;
  [[nodiscard]] bool any_refused() const;

  [[nodiscard]] EditPreview preview() const;

  /// Adjusts, draws and judges. Cost: that of Mapper::finish() without its search for loops.
  /// \param progress, cancel  as for Mapper::finish()
  [[nodiscard]] EditedMap draw(const ProgressCallback& progress = {},
                               const std::stop_token& cancel = {}) const;

  /// Where each key scan of the graph was on the map without edits, in its frame.
  [[nodiscard]] const std::vector<Pose2>& map_T_keys() const;
  [[nodiscard]] const SettledMap& map() const;

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace loopstone
