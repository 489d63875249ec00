#include <nanobind/nanobind.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <cstdint>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "bindings.hpp"
#include "loopstone/base/error.hpp"
#include "loopstone/base/option_list.hpp"
#include "loopstone/formats/options_file.hpp"
#include "loopstone/formats/site_file.hpp"
#include "loopstone/pipeline/site.hpp"
#include "loopstone/slam/session.hpp"
#include "mapping.hpp"
#include "options.hpp"
#include "path_like.hpp"
#include "reading.hpp"
#include "work.hpp"

// A site is opened for each call: others may write to it in between.

namespace loopstone::python {

namespace {

/// Makes a site where there is none; else it must have been made with these options.
void open_site(const std::string& path, const OptionValues* values, bool create) {
  auto options = values == nullptr ? MapOptions{} : options_of<MapOptions>(*values);
  const std::string toml = options_to_toml(list_options(options));
  if (create && SiteFile::create_where_missing(path, toml)) return;
  const SiteFile file(path, SiteAccess::kRead);
  if (values == nullptr) return;
  const std::string differs =
      difference({.options_toml = file.options_toml()}, {.options_toml = toml});
  if (!differs.empty()) throw UsageError(path + ": this site was made otherwise: " + differs);
}

SiteWatch site_watch(Work& work) {
  return {.progress = work.callback(),
          .waits = [&work] { return work.tell({.step = "waiting for another program"}); }};
}

/// As `loopstone site add` does it. \param name  absolute, of the log
SiteSession add_log(const std::string& path, const Log& log, const std::string& name,
                    std::optional<Stamp> begins, const LogCut& cut, Threads threads, Work& work) {
  Site site(path, SiteAccess::kWrite, threads);
  const ReadingWatch watch = watch_by(work);
  LogSource source = log.source(watch.stop);
  source.how.topics.pictures = false;
  const auto reader = source.open_ahead(threads);
  MappedSession mapped = map_session(source, *reader, cut, site.options(), threads, begins, watch);
  if (!mapped.complete || !work.goes_on()) throw CalledOff{};
  mapped.session.log = name;
  return site.add(mapped, site_watch(work));
}

std::vector<SitePair> ties_of(const std::string& path) {
  std::vector<SitePair> ties = SiteFile(path, SiteAccess::kRead).pairs();
  std::erase_if(ties, [](const SitePair& pair) { return pair.older == pair.newer; });
  return ties;
}

/// One change of a site; its edits then.
template <typename Change>
std::vector<SiteCorrection> edited(const std::string& path, int threads, const nb::object& progress,
                                   const Change& change) {
  return work(progress, [&](Work& own) {
    Site site(path, SiteAccess::kWrite, Threads{threads});
    change(site, site_watch(own));
    return site.edits();
  });
}

SiteEditKind kind_of(const std::string& word) {
  const auto kind = find_word<SiteEditKind>(word);
  if (!kind || *kind == SiteEditKind::kExclude)
    throw UsageError("kind: '" + word + "' is none; write free, wall or unknown");
  return *kind;
}

void bind_edits(nb::module_& m) {
  const auto def_edit = [&](const char* name,
                            void (*change)(Site&, std::int64_t, const SiteWatch&)) {
    m.def(
        name,
        [change](const PathLike& path, std::int64_t id, int threads, const nb::object& progress) {
          return edited(path.value, threads, progress,
                        [&](Site& site, const SiteWatch& watch) { change(site, id, watch); });
        },
        nb::arg("path"), nb::arg("id"), nb::arg("threads"), nb::arg("progress").none());
  };
  def_edit("exclude_from_site", [](Site& site, std::int64_t id, const SiteWatch& watch) {
    (void)site.exclude(id, watch);
  });
  def_edit("include_in_site", [](Site& site, std::int64_t id, const SiteWatch& watch) {
    (void)site.include(id, watch);
  });
  def_edit("undo_in_site",
           [](Site& site, std::int64_t id, const SiteWatch& watch) { site.undo(id, watch); });
  m.def(
      "set_cells_of_site",
      [](const PathLike& path, const std::string& kind,
         const std::vector<std::pair<double, double>>& corners, int threads,
         const nb::object& progress) {
        Polygon2 polygon;
        for (const auto& [x, y] : corners) polygon.corners.emplace_back(x, y);
        const SiteEditKind what = kind_of(kind);
        return edited(path.value, threads, progress, [&](Site& site, const SiteWatch& watch) {
          (void)site.set_cells(what, polygon, watch);
        });
      },
      nb::arg("path"), nb::arg("kind"), nb::arg("corners"), nb::arg("threads"),
      nb::arg("progress").none());
}

/// A function of a site's file alone.
template <typename Ask>
void def_question(nb::module_& m, const char* name, Ask&& ask) {
  m.def(
      name,
      [ask](const PathLike& path) {
        const nb::gil_scoped_release unlocked;
        return ask(path.value);
      },
      nb::arg("path"));
}

void bind_questions(nb::module_& m) {
  def_question(m, "is_site", [](const std::string& path) { return is_site(path); });
  def_question(m, "site_sessions", [](const std::string& path) {
    return SiteFile(path, SiteAccess::kRead).sessions();
  });
  def_question(m, "site_events",
               [](const std::string& path) { return SiteFile(path, SiteAccess::kRead).events(); });
  def_question(m, "site_edits",
               [](const std::string& path) { return Site(path, SiteAccess::kRead, {}).edits(); });
  def_question(m, "site_ties", ties_of);
  def_question(m, "site_problems",
               [](const std::string& path) { return SiteFile(path, SiteAccess::kRead).check(); });
  def_question(m, "site_options_toml", [](const std::string& path) {
    return SiteFile(path, SiteAccess::kRead).options_toml();
  });
  def_question(m, "site_bytes",
               [](const std::string& path) { return SiteFile(path, SiteAccess::kRead).bytes(); });
  m.def(
      "parse_utc",
      [](const std::string& text, bool until) -> std::optional<std::int64_t> {
        const auto stamp = until ? parse_utc_end(text) : parse_utc(text);
        return stamp ? std::optional(stamp->nanoseconds) : std::nullopt;
      },
      nb::arg("text"), nb::arg("until"));
}

}  // namespace

void bind_site_calls(nb::module_& m) {
  bind_questions(m);
  bind_edits(m);
  m.def(
      "open_site",
      [](const PathLike& path, const OptionValues* values, bool create) {
        const nb::gil_scoped_release unlocked;
        open_site(path.value, values, create);
      },
      nb::arg("path"), nb::arg("options").none(), nb::arg("create"));
  m.def(
      "add_to_site",
      [](const PathLike& path, const Log& log, const PathLike& name,
         const std::optional<std::int64_t>& begins_ns, double start_s, double duration_s,
         std::int64_t max_scans, int threads, const nb::object& progress) {
        std::optional<Stamp> begins;
        if (begins_ns) begins = Stamp{*begins_ns};
        const LogCut cut{start_s, duration_s, max_scans};
        return work(progress, [&](Work& own) {
          return add_log(path.value, log, name.value, begins, cut, Threads{threads}, own);
        });
      },
      nb::arg("path"), nb::arg("log"), nb::arg("name"), nb::arg("begins_ns").none(),
      nb::arg("start_s"), nb::arg("duration_s"), nb::arg("max_scans"), nb::arg("threads"),
      nb::arg("progress").none());
  m.def(
      "prune_site",
      [](const PathLike& path, std::vector<std::int64_t> sessions, bool pending, int threads,
         const nb::object& progress) {
        return work(progress, [&](Work& own) {
          const SitePruning done = prune_site(path.value, std::move(sessions), pending,
                                              Threads{threads}, site_watch(own));
          return std::tuple(done.removed, done.bytes_before, done.bytes);
        });
      },
      nb::arg("path"), nb::arg("sessions"), nb::arg("pending"), nb::arg("threads"),
      nb::arg("progress").none());
  m.def(
      "rebuild_site",
      [](const PathLike& path, int threads, const nb::object& progress) {
        return work(progress, [&](Work& own) {
          Site site(path.value, SiteAccess::kWrite, Threads{threads});
          site.rebuild(site_watch(own));
          return site.sessions();
        });
      },
      nb::arg("path"), nb::arg("threads"), nb::arg("progress").none());
}

}  // namespace loopstone::python
