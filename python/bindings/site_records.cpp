#include <fmt/format.h>
#include <nanobind/nanobind.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "arrays.hpp"
#include "bindings.hpp"
#include "loopstone/formats/robot_file.hpp"
#include "loopstone/formats/site_file.hpp"
#include "loopstone/mapping/visit_ledger.hpp"
#include "robot.hpp"
#include "sites.hpp"

namespace loopstone::python {

namespace {

std::string word(SessionStatus status) { return std::string(to_string(status)); }

nb::object noted_date(const std::string& text) {
  const auto date = parse_utc(text);
  if (!date) throw nb::value_error(("the site has '" + text + "', which is no date").c_str());
  return to_datetime(*date);
}

void def_what_became(nb::class_<SiteSession>& session) {
  session.def_prop_ro(
      "status", [](const SiteSession& s) { return word(s.status); },
      "``joined``, ``pending``, ``refused``, ``retired`` or ``excluded``.");
  session.def_ro("reason", &SiteSession::reason, "Why it is not joined; empty when it is.");
  session.def_ro("closures", &SiteSession::closures, "That stand and tie it to others.");
  session.def_ro("verdict", &SiteSession::verdict,
                 "On its own map: ``unknown``, ``good``, ``doubtful`` or ``bad``.");
  session.def_ro("sentence", &SiteSession::sentence, "What that means, in words.");
  session.def("__repr__", [](const SiteSession& s) {
    return fmt::format("<SiteSession {} of {}: {}{}>", s.id, utc_text(s.begins), word(s.status),
                       s.reason.empty() ? "" : ", " + s.reason);
  });
}

void bind_session(nb::module_& m) {
  nb::class_<SiteSession> session(m, "SiteSession",
                                  "One drive of a robot in the building, and what became of it.");
  session.def_ro("id", &SiteSession::id, "By which the site knows it.");
  session.def_ro("log", &SiteSession::log, "Where its log was.");
  session.def_ro("digest", &SiteSession::digest,
                 "Checksum of its messages: no two sessions of a site have the same.");
  session.def_prop_ro(
      "begins", [](const SiteSession& s) { return to_datetime(s.begins); },
      nb::sig("def begins(self) -> datetime.datetime"),
      "When it was driven, UTC, by the log's stamps or as ``add`` was told; sessions are joined\n"
      "in this order.");
  session.def_prop_ro(
      "begins_ns", [](const SiteSession& s) { return s.begins.nanoseconds; },
      "The same in nanoseconds since 1970, exact.");
  session.def_prop_ro(
      "added", [](const SiteSession& s) { return noted_date(s.added); },
      nb::sig("def added(self) -> datetime.datetime"), "When it came into the site, UTC.");
  session.def_prop_ro(
      "robot",
      [](const SiteSession& s) {
        return Robot{parse_robot(s.robot, "session " + std::to_string(s.id)), {}};
      },
      "That drove: mounts and wheels, as its own map was made with.");
  session.def_ro("scans", &SiteSession::scans, "How many it has.");
  session.def_ro("path_m", &SiteSession::path_m, "How far it drove [m].");
  session.def_ro("duration_s", &SiteSession::duration_s, "How long [s].");
  def_what_became(session);
}

void bind_event(nb::module_& m) {
  nb::class_<SiteEvent> event(m, "SiteEvent", "Something that was done to a site.");
  event.def_prop_ro(
      "at", [](const SiteEvent& e) { return noted_date(e.at); },
      nb::sig("def at(self) -> datetime.datetime"), "When, UTC.");
  event.def_ro("what", &SiteEvent::what,
               "``add``, ``remove``, ``rebuild``, ``edit``, ``exclude`` or ``undo``.");
  event.def_ro("log", &SiteEvent::session, "The session's log; empty: of the site as a whole.");
  event.def_ro("text", &SiteEvent::text, "What came of it, in words.");
  event.def("__repr__", [](const SiteEvent& e) {
    return fmt::format("<SiteEvent {} {}: {}>", e.at, e.what, e.text);
  });
}

void bind_edit(nb::module_& m) {
  nb::class_<SiteCorrection> edit(m, "SiteEdit", "Something that was corrected in a site by hand.");
  edit.def_prop_ro(
      "id", [](const SiteCorrection& e) { return e.edit.id; }, "By which it is undone.");
  edit.def_prop_ro(
      "at", [](const SiteCorrection& e) { return noted_date(e.edit.at); },
      nb::sig("def at(self) -> datetime.datetime"), "When it was done, UTC.");
  edit.def_prop_ro(
      "kind", [](const SiteCorrection& e) { return std::string(to_string(e.edit.kind)); },
      "``exclude``, ``free``, ``wall`` or ``unknown``.");
  edit.def_prop_ro(
      "session",
      [](const SiteCorrection& e) {
        return e.edit.excluded == 0 ? std::nullopt : std::optional(e.edit.excluded);
      },
      "The id of the session that is left out; None: it is a polygon.");
  edit.def_prop_ro(
      "polygon",
      [](const SiteCorrection& e) -> nb::object {
        if (!e.on_map) return nb::none();
        return nb::cast(corners_of(*e.on_map));
      },
      nb::sig("def polygon(self) -> numpy.typing.NDArray[numpy.float64] | None"),
      "(N, 2) its corners [m], map frame; None: a session is left out, or what it lay on is no\n"
      "part of the map.");
  edit.def("__repr__", [](const SiteCorrection& e) {
    return e.edit.excluded != 0
               ? fmt::format("<SiteEdit {}: exclude session {}>", e.edit.id, e.edit.excluded)
               : fmt::format("<SiteEdit {}: {}, {} corners>", e.edit.id, to_string(e.edit.kind),
                             e.edit.polygon.corners.size());
  });
}

void bind_tie(nb::module_& m) {
  nb::class_<SitePair> tie(m, "SiteTie", "What was found between two sessions of a site.");
  tie.def_ro("older", &SitePair::older, "The id of a session.");
  tie.def_ro("newer", &SitePair::newer, "The id of a later one.");
  tie.def_prop_ro(
      "closures", [](const SitePair& t) { return t.pair.closures; },
      "Places that were recognised, or looked like it; those that do not stand included. Submaps\n"
      "and nodes are counted within their sessions, ``from`` is of the older one.");
  tie.def("__repr__", [](const SitePair& t) {
    return fmt::format("<SiteTie {} - {}: {} of {} closures stand>", t.older, t.newer,
                       t.pair.standing(), t.pair.closures.size());
  });
}

void bind_change(nb::module_& m) {
  nb::class_<MapChange> change(m, "MapChange",
                               "A place where a building differs from what it was.");
  change.def_ro("appeared", &MapChange::appeared, "Something stands there now; False: it is gone.");
  def_array(
      change, "low", [](const MapChange& c) { return to_array(c.low); },
      "(2,) lowest x, y of the box around it [m], map frame.");
  def_array(
      change, "high", [](const MapChange& c) { return to_array(c.high); },
      "(2,) highest x, y of that box.");
  change.def_ro("area_m2", &MapChange::area_m2, "Of its cells alone.");
  change.def("__repr__", [](const MapChange& c) {
    return fmt::format("<MapChange: {} at x {:.2f} to {:.2f} m, y {:.2f} to {:.2f} m, {:.2f} m2>",
                       c.appeared ? "appeared" : "gone", c.low.x(), c.high.x(), c.low.y(),
                       c.high.y(), c.area_m2);
  });
}

}  // namespace

nb::object to_datetime(Stamp stamp) {
  const nb::module_ datetime = nb::module_::import_("datetime");
  const nb::object utc = datetime.attr("timezone").attr("utc");
  const nb::object epoch = datetime.attr("datetime")(1970, 1, 1, nb::arg("tzinfo") = utc);
  constexpr std::int64_t kNanoseconds = 1000;
  return epoch + datetime.attr("timedelta")(0, 0, stamp.nanoseconds / kNanoseconds);
}

void bind_site_records(nb::module_& m) {
  bind_session(m);
  bind_event(m);
  bind_edit(m);
  bind_tie(m);
  bind_change(m);
}

}  // namespace loopstone::python
