"""From what somebody gives as options to what the C++ library takes."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from . import _core

if TYPE_CHECKING:
    from ._option_group import CallOptions


def _text(value: object) -> str:
    """A value as the right side of ``key=value``."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return value
    item = getattr(value, "item", None)  # of NumPy
    if item is not None and getattr(value, "ndim", None) == 0:
        return _text(item())
    return repr(value)


def option_values(
    kind: str | tuple[str, ...],
    given: CallOptions | Mapping[str, Any] | str | os.PathLike[str] | None,
    overrides: Mapping[str, Any],
) -> _core.OptionValues:
    """A file, or values by their keys; ``overrides`` beats both, ``a__b`` in it is ``a.b``.

    :param kind: the class of loopstone.options that belongs to the call; or several, the first of
        which errors name
    """
    kinds = (kind,) if isinstance(kind, str) else kind
    file = ""
    values: dict[str, Any] = {}
    changed = getattr(given, "changed", None)
    if changed is not None and type(given).__name__ in kinds:
        values = changed()
    elif changed is not None:
        raise TypeError(f"options: expected {kinds[0]}, not {type(given).__name__}")
    elif isinstance(given, Mapping):
        values = dict(given)
    elif isinstance(given, (str, os.PathLike)):
        file = os.fspath(given)
    elif given is not None:
        raise TypeError(
            f"options: expected {kinds[0]}, a mapping of keys to values, or the path of a "
            f"TOML file, not {type(given).__name__}"
        )
    for key, value in overrides.items():
        values[key.replace("__", ".")] = value
    return _core.OptionValues(file, [(key, _text(value)) for key, value in values.items()])


def replaced_robot(
    robot: _core.Robot,
    changes: Mapping[str, Any] | None = None,
    /,
    *,
    lidars: Sequence[_core.LidarMount] | None = None,
    **values: Any,
) -> _core.Robot:
    given = {**(changes or {}), **{key.replace("__", "."): v for key, v in values.items()}}
    texts = [(key, _text(value)) for key, value in given.items()]
    return _core.replaced_robot(robot, texts, None if lidars is None else list(lidars))


def replaced_lidar(lidar: _core.LidarMount, /, **changes: Any) -> _core.LidarMount:
    names = ("x_m", "y_m", "yaw_rad", "height_m", "upside_down", "sweep_s", "name")
    return _core.LidarMount(**{**{name: getattr(lidar, name) for name in names}, **changes})


def map_values(given: Any, **overrides: Any) -> _core.OptionValues:
    return option_values("MapOptions", given, overrides)


def localization_values(given: Any, **overrides: Any) -> _core.OptionValues:
    return option_values("LocalizationOptions", given, overrides)


def grid_map(given: Any) -> _core.GridMap:
    """A map in any of its forms, as cells in percent."""
    if isinstance(given, _core.GridMap):
        return given
    if isinstance(given, _core.OccupancyMap):
        return given.to_grid()
    if isinstance(given, _core.MapResult):
        if given.map is None:
            raise ValueError("map: this result has no map; its warnings say why")
        return given.map.to_grid()
    if isinstance(given, (str, os.PathLike)):
        path = os.fspath(given)
        if _core.is_site(path):
            return _core.site_cells(path, 0)
        inside = os.path.join(path, "map.yaml")
        return _core.read_map(inside if os.path.isdir(path) else path)
    raise TypeError(
        "map: expected a GridMap, an OccupancyMap, a MapResult, a LocalizationMap, a Site or a "
        f"path, not {type(given).__name__}"
    )


def localization_map(given: Any) -> _core.LocalizationMap:
    if isinstance(given, _core.LocalizationMap):
        return given
    return _core.LocalizationMap(grid_map(given))


def known_landmarks(given: Any) -> list[_core.Landmark]:
    """Landmarks in any of their forms."""
    if isinstance(given, (str, os.PathLike)):
        return _core.read_landmarks(given)
    if isinstance(given, _core.MapResult):
        if not given.landmarks:
            raise ValueError(
                "landmarks: this map has none; one with landmarks=True has those that were found"
            )
        return _core.mapped_landmarks(given.landmarks)
    known: list[_core.Landmark] = []
    for one in given if isinstance(given, Iterable) else [None]:
        if isinstance(one, _core.FoundLandmark):
            known += _core.mapped_landmarks([one])
        elif isinstance(one, _core.Landmark):
            known.append(one)
        else:
            raise TypeError(
                "landmarks: expected a path, a MapResult, or Landmark and FoundLandmark objects"
            )
    return known
