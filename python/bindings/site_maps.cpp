#include <fmt/format.h>
#include <nanobind/nanobind.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "arrays.hpp"
#include "bindings.hpp"
#include "cost.hpp"
#include "loopstone/formats/robot_file.hpp"
#include "loopstone/formats/ros_map.hpp"
#include "loopstone/report/map_outputs.hpp"
#include "loopstone/report/site_grids.hpp"
#include "loopstone/report/site_outputs.hpp"
#include "loopstone/report/site_recording.hpp"
#include "maps.hpp"
#include "path_like.hpp"
#include "sites.hpp"
#include "work.hpp"

namespace loopstone::python {

namespace {

using Shared = std::shared_ptr<SiteMapped>;

/// Where a building differs from what it was.
struct SiteChanges {
  Shared now{};
  OccupancyMap before{};
  std::vector<MapChange> changes{};
};
using SharedChanges = std::shared_ptr<SiteChanges>;

std::optional<Stamp> stamp_of(const std::optional<std::int64_t>& nanoseconds) {
  if (!nanoseconds) return {};
  return Stamp{*nanoseconds};
}

Shared mapped_of(SiteMap map, const Site& site, Threads threads, const Cost& cost) {
  auto mapped = std::make_shared<SiteMapped>();
  mapped->info = run_info(site.options(), threads);
  mapped->info.options_toml = site.file().options_toml();
  mapped->info.log_path = site.file().path();
  mapped->robot = parse_robot(map.sessions.back().robot, site.file().path());
  mapped->result = std::move(map.result);
  mapped->movable = std::move(map.movable);
  mapped->grids = std::move(map.grids);
  if (mapped->grids) mapped->site = figures_of(*mapped->grids, mapped->result.map, map.edits);
  mapped->edits = std::move(map.edits);
  mapped->sessions = std::move(map.sessions);
  mapped->scans = std::move(map.scans);
  cost.note(mapped->info);
  return mapped;
}

SharedChanges changes_of(const std::string& path, Stamp from, std::optional<Stamp> to,
                         Threads threads, Work& work) {
  const Cost cost;
  const Site site(path, SiteAccess::kRead, threads);
  Site::Difference difference = site.difference(from, to, work.callback());
  auto changes = std::make_shared<SiteChanges>();
  changes->before = std::move(difference.before);
  changes->changes = std::move(difference.changes);
  changes->now = mapped_of(std::move(difference.now), site, threads, cost);
  return changes;
}

void save_map(const Shared& self, const PathLike& folder, bool force) {
  const nb::gil_scoped_release unlocked;
  const std::lock_guard lock(self->mutex);
  RunInfo info = self->info;
  info.force = force;
  write_map_outputs(self->result, info, folder.value,
                    {.site = self->site ? &*self->site : nullptr});
  if (self->grids) {
    write_site_grids(*self->grids, *self->site, self->movable, self->result.map, folder.value,
                     Threads{info.threads});
  } else {
    write_movable(self->movable, self->result.map, folder.value);
  }
  write_site_sessions(self->result, self->sessions, folder.value);
}

void record_map(const Shared& self, const PathLike& path) {
  const nb::gil_scoped_release unlocked;
  write_site_recording(self->result, self->sessions, self->movable, path.value);
}

void save_changes(const SiteChanges& self, const PathLike& folder, bool force) {
  const nb::gil_scoped_release unlocked;
  write_changes(self.changes, self.before, self.now->result.map, folder.value, force);
}

void bind_map(nb::module_& m) {
  nb::class_<SiteMapped, Mapped> map(
      m, "SiteMap",
      "The map of a site: what the last visits agree on, with all that a MapResult of one drive "
      "has.\nScans of the trajectory follow one another, session by session.");
  map.def_prop_ro(
      "sessions", [](const Shared& self) { return self->sessions; },
      "That are joined, in the order in which they were driven; later ones than the map's date\n"
      "hold it together, too, and are not drawn on it.");
  map.def_prop_ro(
      "trajectories", [](const Shared& self) { return self->result.trajectories(); },
      "map_T_robot of each session, by the stamps of its own log.");
  map.def_prop_ro(
      "movable",
      [](nb::handle_t<SiteMapped> handle) {
        const Grid<float>& grid = nb::cast<const SiteMapped&>(handle).movable;
        const GridFrame& frame = grid.frame();
        return View<float, nb::ndim<2>>(
            grid.cells().data(),
            {static_cast<std::size_t>(frame.rows), static_cast<std::size_t>(frame.columns)},
            handle);
      },
      nb::rv_policy::automatic,
      "(rows, columns) float32 in [0, 1], a read-only view, of the cells of ``map``: on what "
      "share\n"
      "of visits something stands there, where they are not of one mind: doors, chairs, what is\n"
      "moved; 0 elsewhere.");
  map.def_prop_ro(
      "has_scans", [](const Shared& self) { return !self->scans.empty(); },
      "A floor plan is drawn through what the lasers measured: made with ``keep_scans=True``.");
  map.def("save", save_map, nb::arg("folder"), nb::kw_only(), nb::arg("force") = false,
          "Writes the files that ``loopstone site map`` writes. Raises UsageError when the folder\n"
          "holds something, unless forced.");
  map.def_prop_ro(
      "edits", [](const Shared& self) { return self->edits; },
      "What it was corrected by: all edits of the site.");
  map.def("record", record_map, nb::arg("path"),
          "Writes map, paths, closures and poses as MCAP for Foxglove, Lichtblick and RViz, as\n"
          "``loopstone site map --mcap`` does. A file that is there is replaced.");
  map.def("__repr__", [](const SiteMapped& self) {
    return fmt::format("<SiteMap of {} sessions: {}>", self.sessions.size(),
                       loopstone::to_string(self.result.verdict.overall));
  });
}

void def_changes_as_arrays(nb::class_<SiteChanges>& changes) {
  def_array(
      changes, "boxes",
      [](const SiteChanges& self) {
        std::vector<double> values;
        for (const MapChange& c : self.changes)
          values.insert(values.end(), {c.low.x(), c.low.y(), c.high.x(), c.high.y()});
        return array_of<double, nb::ndim<2>>(std::move(values), {self.changes.size(), 4});
      },
      "(C, 4) lowest x, lowest y, highest x, highest y of each [m], map frame.");
  def_array(
      changes, "areas_m2",
      [](const SiteChanges& self) {
        std::vector<double> values;
        for (const MapChange& c : self.changes) values.push_back(c.area_m2);
        return array_of<double, nb::ndim<1>>(std::move(values), {self.changes.size()});
      },
      "(C,) of the cells of each.");
  changes.def("__len__", [](const SiteChanges& self) { return self.changes.size(); });
  changes.def(
      "__getitem__",
      [](const SiteChanges& self, std::ptrdiff_t index) {
        const std::ptrdiff_t size = std::ssize(self.changes);
        const std::ptrdiff_t place = index < 0 ? index + size : index;
        if (place < 0 || place >= size) throw nb::index_error("there are fewer changes");
        return self.changes[static_cast<std::size_t>(place)];
      },
      nb::arg("index"));
  changes.def(
      "__iter__", [](const SiteChanges& self) { return nb::iter(nb::cast(self.changes)); },
      nb::sig("def __iter__(self) -> collections.abc.Iterator[MapChange]"));
}

void bind_changes(nb::module_& m) {
  nb::class_<SiteChanges> changes(
      m, "SiteChanges",
      "What appeared in a building and what is gone, as a sequence of MapChange, largest first.");
  def_changes_as_arrays(changes);
  changes.def_prop_ro(
      "now", [](const SharedChanges& self) { return self->now; },
      "The map of the later date, in whose frame the changes are.");
  changes.def_prop_ro(
      "before",
      [](const SharedChanges& self) { return std::shared_ptr<OccupancyMap>(self, &self->before); },
      "What the building was before.");
  changes.def("save", save_changes, nb::arg("folder"), nb::kw_only(), nb::arg("force") = false,
              "Writes changes.png and changes.csv, as ``loopstone site changes`` does. Raises\n"
              "UsageError when the folder holds something, unless forced.");
  changes.def("__repr__", [](const SiteChanges& self) {
    const auto appeared = std::ranges::count_if(self.changes, &MapChange::appeared);
    return fmt::format("<SiteChanges: {} appeared, {} gone>", appeared,
                       std::ssize(self.changes) - appeared);
  });
}

}  // namespace

void bind_site_maps(nb::module_& m) {
  bind_map(m);
  bind_changes(m);
  m.def(
      "site_map",
      [](const PathLike& path, const std::optional<std::int64_t>& until_ns, bool keep_scans,
         int threads, const nb::object& progress) {
        return work(progress, [&](Work& own) {
          const Cost cost;
          const Site site(path.value, SiteAccess::kRead, Threads{threads});
          return mapped_of(
              site.map(stamp_of(until_ns), {.scans = keep_scans, .grids = true}, own.callback()),
              site, Threads{threads}, cost);
        });
      },
      nb::arg("path"), nb::arg("until_ns").none(), nb::arg("keep_scans"), nb::arg("threads"),
      nb::arg("progress").none());
  m.def(
      "site_changes",
      [](const PathLike& path, std::int64_t from_ns, const std::optional<std::int64_t>& to_ns,
         int threads, const nb::object& progress) {
        return work(progress, [&](Work& own) {
          return changes_of(path.value, Stamp{from_ns}, stamp_of(to_ns), Threads{threads}, own);
        });
      },
      nb::arg("path"), nb::arg("from_ns"), nb::arg("to_ns").none(), nb::arg("threads"),
      nb::arg("progress").none());
  m.def(
      "site_cells",
      [](const PathLike& path, int threads) {
        return work(nb::none(), [&](Work& own) {
          const Site site(path.value, SiteAccess::kRead, Threads{threads});
          return GridMap{std::make_shared<const CellStates>(
              cell_states(site.map({}, {}, own.callback()).result.map))};
        });
      },
      nb::arg("path"), nb::arg("threads"));
}

}  // namespace loopstone::python
