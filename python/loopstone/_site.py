"""Sites: one map of a building from many drives."""

from __future__ import annotations

import datetime
import os
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

from . import _core
from ._api import StrPath, _log_of
from ._errors import UsageError
from ._progress import ProgressLike, told
from ._values import map_values

if TYPE_CHECKING:
    import numpy.typing as npt

    from .options import MapOptions

#: A day, or a moment. Text is ``2026-11-26`` or ``2026-11-26T14:03``; all of it is UTC, and so is
#: what has no time zone. A day alone begins with its first moment; until it means to its end.
DateLike = str | datetime.date

_EPOCH = datetime.datetime(1970, 1, 1, tzinfo=datetime.timezone.utc)
_MICROSECOND = datetime.timedelta(microseconds=1)


def _nanoseconds(name: str, date: DateLike, *, until: bool) -> int:
    """Since 1970, UTC."""
    if isinstance(date, datetime.datetime):
        moment = date if date.tzinfo else date.replace(tzinfo=datetime.timezone.utc)
        return (moment - _EPOCH) // _MICROSECOND * 1000
    if not isinstance(date, (str, datetime.date)):
        raise TypeError(f"{name}: expected text, a date or a datetime, not {type(date).__name__}")
    text = date if isinstance(date, str) else date.isoformat()
    found = _core.parse_utc(text, until)
    if found is None:
        raise UsageError(f"{name}: {text} is no date; write 2026-11-26 or 2026-11-26T14:03")
    return found


def _id_of(one: int | _core.SiteSession | _core.SiteEdit) -> int:
    return one.id if isinstance(one, (_core.SiteSession, _core.SiteEdit)) else one


class SitePruning(NamedTuple):
    """What was removed from a site."""

    removed: int
    """How many sessions."""
    bytes_before: int
    """Size of the file, with what was on its way into it."""
    bytes: int
    """The same now."""


class Site:
    """One map of a building from many drives of any robots, kept true as the building changes.

    A site is one file. Others may read and write it at any time: every call sees what is there
    then, and what changes it is done whole or not at all. Its path, or the site itself, is a map
    wherever one is asked for, as in ``loopstone.localize``.

        >>> site = ls.Site("office.site")
        >>> site.add("monday.mcap").status
        'joined'
        >>> result = site.map()
    """

    def __init__(
        self,
        path: StrPath,
        *,
        create: bool = True,
        options: MapOptions | Mapping[str, Any] | StrPath | None = None,
        threads: int = 0,
        **overrides: Any,
    ) -> None:
        """Opens a site, or makes its file where there is none.

        :param create: False: it must be there
        :param options: of all its maps, for ever, as :func:`map` takes them; of a site that is
            there already they must be those that it was made with
        :param threads: of its calls; 0: one for each processor. Results are the same bytes
        :raises DataError: the file is none of a site, or is not there and not to be made
        :raises OptionsError: with everything that is wrong with the options
        """
        self._path = os.fspath(path)
        self._threads = threads
        given = options is not None or bool(overrides)
        values = map_values(options, **overrides) if given else None
        _core.open_site(self._path, values, create)

    @property
    def path(self) -> str:
        """Of its file."""
        return self._path

    @property
    def sessions(self) -> list[_core.SiteSession]:
        """All that were added, in the order in which they were driven."""
        return _core.site_sessions(self._path)

    @property
    def ties(self) -> list[_core.SiteTie]:
        """What was found between each two sessions that were compared."""
        return _core.site_ties(self._path)

    @property
    def history(self) -> list[_core.SiteEvent]:
        """What was done to it, and when: ``loopstone site history``."""
        return _core.site_events(self._path)

    @property
    def edits(self) -> list[_core.SiteEdit]:
        """What was corrected by hand, oldest first: ``loopstone site edits``."""
        return _core.site_edits(self._path)

    @property
    def options_toml(self) -> str:
        """The options of all its maps."""
        return _core.site_options_toml(self._path)

    @property
    def bytes(self) -> int:
        """Size of its file, with what is on its way into it."""
        return _core.site_bytes(self._path)

    def add(
        self,
        log: StrPath | _core.Log,
        *,
        date: DateLike | None = None,
        robot: _core.Robot | None = None,
        start_s: float = 0.0,
        duration_s: float = 0.0,
        max_scans: int = 0,
        progress: ProgressLike = False,
    ) -> _core.SiteSession:
        """Maps a log by itself, and looks for it on the site: ``loopstone site add``.

        In which order sessions are added changes nothing. While somebody else writes the site, it
        waits.

        :param log: a path, or what :func:`open_log` returns
        :param date: when it was recorded; None: as its stamps say
        :param robot: whose wheels and mounts beat what the log says
        :param start_s: skip scans before this time
        :param duration_s: use so much of the log; 0: all
        :param max_scans: use so many scans; 0: all
        :return: the session, with what became of it
        :raises DataError: nothing can be made of the log
        :raises UsageError: its messages are in the site already
        :raises KeyboardInterrupt: within a fraction of a second; the site stays as it was
        """
        begins = None if date is None else _nanoseconds("date", date, until=False)
        opened = _log_of(log, robot)
        name = os.path.join(os.getcwd(), opened.path)
        with told(progress) as tell:
            return _core.add_to_site(
                self._path,
                opened,
                name,
                begins,
                start_s,
                duration_s,
                max_scans,
                self._threads,
                tell,
            )

    def map(
        self,
        date: DateLike | None = None,
        *,
        keep_scans: bool = False,
        progress: ProgressLike = False,
    ) -> _core.SiteMap:
        """The map of today, or of a date: ``loopstone site map``.

        :param date: as the building was then, by the sessions until the end of this day
        :param keep_scans: the result keeps what the lasers measured, through which
            :func:`floor_plan` then draws its lines
        :raises DataError: no session is joined, or none is as old as the date
        """
        until = None if date is None else _nanoseconds("date", date, until=True)
        with told(progress) as tell:
            return _core.site_map(self._path, until, keep_scans, self._threads, tell)

    def changes(
        self, since: DateLike, until: DateLike | None = None, *, progress: ProgressLike = False
    ) -> _core.SiteChanges:
        """What appeared in the building, and what is gone: ``loopstone site changes``.

        Compared is what the last sessions until the end of each day agreed on.

        :param until: None: today
        :raises DataError: of the first date no session is kept any more, or none yet
        """
        begins = _nanoseconds("since", since, until=True)
        ends = None if until is None else _nanoseconds("until", until, until=True)
        if ends is not None and ends < begins:
            raise UsageError("until lies before since")
        with told(progress) as tell:
            return _core.site_changes(self._path, begins, ends, self._threads, tell)

    def check(self) -> list[str]:
        """Reads all of the file: everything that is wrong with it, and what is lost by that.

        Empty when it is sound.
        """
        return _core.site_problems(self._path)

    def prune(
        self,
        sessions: Iterable[int | _core.SiteSession] = (),
        *,
        pending: bool = False,
        progress: ProgressLike = False,
    ) -> SitePruning:
        """Removes sessions as if they had never been there, and gives back their room.

        :param sessions: they, or their ids; none: only gives back room
        :param pending: all that are pending, too
        :raises UsageError: there is no such session
        """
        ids = [_id_of(one) for one in sessions]
        with told(progress) as tell:
            return SitePruning(*_core.prune_site(self._path, ids, pending, self._threads, tell))

    def rebuild(self, *, progress: ProgressLike = False) -> list[_core.SiteSession]:
        """Finds all that ties the sessions anew: ``loopstone site rebuild``.

        :return: all sessions, as they are then
        """
        with told(progress) as tell:
            return _core.rebuild_site(self._path, self._threads, tell)

    def exclude(
        self, session: int | _core.SiteSession, *, progress: ProgressLike = False
    ) -> _core.SiteEdit:
        """Leaves a session out of the map, until that is undone; it stays in the site.

        :param session: it, or its id
        :return: the edit, as all of these do: ``loopstone site edit``
        :raises UsageError: there is none, it is left out already, or nothing of it is in the map
        """
        with told(progress) as tell:
            edits = _core.exclude_from_site(self._path, _id_of(session), self._threads, tell)
        return edits[-1]

    def include(self, session: int | _core.SiteSession, *, progress: ProgressLike = False) -> None:
        """Takes a session that was left out back into the map.

        :raises UsageError: it is not left out
        """
        with told(progress) as tell:
            _core.include_in_site(self._path, _id_of(session), self._threads, tell)

    def set_cells(
        self,
        kind: Literal["free", "wall", "unknown"],
        polygon: npt.ArrayLike,
        *,
        progress: ProgressLike = False,
    ) -> _core.SiteEdit:
        """Says what the cells of a polygon are, in every map that is made of the site.

        It goes with the building when the map moves; later edits beat earlier ones.

        :param polygon: (N, 2) corners [m], map frame
        :raises UsageError: it encloses nothing, or lies far from all that was seen
        :raises DataError: there is no map yet
        """
        import numpy as np

        corners = np.asarray(polygon, dtype=float)
        if corners.ndim != 2 or corners.shape[1] != 2:
            raise UsageError(f"polygon: expected (N, 2) corners, not {corners.shape}")
        with told(progress) as tell:
            edits = _core.set_cells_of_site(
                self._path, kind, [tuple(c) for c in corners.tolist()], self._threads, tell
            )
        return edits[-1]

    def undo(self, edit: int | _core.SiteEdit, *, progress: ProgressLike = False) -> None:
        """Takes an edit back.

        :param edit: it, or its id
        :raises UsageError: there is none
        """
        with told(progress) as tell:
            _core.undo_in_site(self._path, _id_of(edit), self._threads, tell)

    def __fspath__(self) -> str:
        return self._path

    def __repr__(self) -> str:
        return f"<Site {self._path!r}>"
