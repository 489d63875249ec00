"""Where logs lie: files and folders of this machine, or a store that fsspec knows, such as S3."""

from __future__ import annotations

import errno
import hashlib
import os
import shutil
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

import fsspec

from loopstone_fleet.errors import LogTooLargeError, MissingLogError, StoreError

CHUNK_BYTES = 1 << 20
# Left free where logs are fetched to.
SPARE_BYTES = 64 << 20


class LocalLog(NamedTuple):
    """A log that the program can read now."""

    path: str
    """As the program takes it, with the number of a set: folder#20."""
    digest: str
    """SHA-256 of all that it holds."""
    size_bytes: int


class FetchLimits(NamedTuple):
    """For what is fetched from a store."""

    max_bytes: int
    timeout_s: float


def is_remote(log: str) -> bool:
    return "://" in log


def split_set(log: str) -> tuple[str, str]:
    """A log and the number of the set in it: `folder#20` is folder and `#20`."""
    path, mark, number = log.rpartition("#")
    return (path, mark + number) if mark and number.isdigit() else (log, "")


def stamp_of(log: str) -> str | None:
    """What changes when a log does, told without reading it; None when it can't be told now."""
    path, _ = split_set(log)
    try:
        if not is_remote(log):
            return _digest_of(f"{name} {s.st_size} {s.st_mtime_ns}" for name, s in _stats(path))
        filesystem, name = fsspec.url_to_fs(path)
        info = filesystem.info(name)
        if info["type"] != "directory":
            return _digest_of([_remote_stamp(info)])
        found = filesystem.find(name, detail=True)
        return _digest_of(f"{key} {_remote_stamp(found[key])}" for key in sorted(found))
    except Exception:  # of a store, of whatever class; whoever maps the log will tell
        return None


@contextmanager
def at_hand(log: str, scratch: Path, limits: FetchLimits) -> Iterator[LocalLog]:
    """A log as files of this machine; what was fetched for it is removed afterwards.

    MissingLogError, LogTooLargeError, StoreError when the store fails, OSError when the disk does.
    """
    path, number = split_set(log)
    if not is_remote(log):
        yield _local(path, number)
        return
    scratch.mkdir(parents=True, exist_ok=True)
    folder = Path(tempfile.mkdtemp(prefix="log-", dir=scratch))
    try:
        fetched = _fetch(path, folder, limits)
        yield LocalLog(str(fetched.path) + number, fetched.digest, fetched.size_bytes)
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _local(path: str, number: str) -> LocalLog:
    files = [name for name, _ in _stats(path)]
    digests = []
    size = 0
    for name in files:
        digest = hashlib.sha256()
        try:
            with open(os.path.join(path, name) if name else path, "rb") as file:
                while chunk := file.read(CHUNK_BYTES):
                    digest.update(chunk)
                    size += len(chunk)
        except PermissionError as error:
            raise StoreError(f"{error.filename}: may not be read by this user") from None
        except OSError as error:
            raise StoreError(f"{path}: {error.strerror}") from None
        digests.append((name, digest.hexdigest()))
    return LocalLog(path + number, _digest_of_files(digests), size)


def _stats(path: str) -> list[tuple[str, os.stat_result]]:
    """Of a file, as ''; of every file in a folder, by names from there."""
    try:
        if not os.path.isdir(path):
            return [("", os.stat(path))]
        found = []
        for folder, folders, names in os.walk(path):
            folders.sort()
            paths = [os.path.join(folder, name) for name in sorted(names)]
            found += [(os.path.relpath(each, path), os.stat(each)) for each in paths]
    except FileNotFoundError:
        raise MissingLogError(f"{path}: there is no such log") from None
    return found


def _fetch(url: str, folder: Path, limits: FetchLimits) -> LocalLog:
    try:
        filesystem, name = fsspec.url_to_fs(url)
        filesystem.invalidate_cache()
        info = filesystem.info(name)
        if info["type"] == "directory":
            sizes = {key: int(filesystem.info(key)["size"]) for key in filesystem.find(name)}
        else:
            sizes = {name: int(info["size"])}
    except FileNotFoundError:
        raise MissingLogError(f"{url}: there is no such log") from None
    except Exception as error:
        raise StoreError(f"{url}: {_told(error)}") from error
    if not sizes:
        raise MissingLogError(f"{url}: is an empty folder")
    _check_room(url, sum(sizes.values()), folder, limits)
    target = folder / os.path.basename(name.rstrip("/"))
    deadline = time.monotonic() + limits.timeout_s
    digests = []
    for key in sorted(sizes):
        relative = key[len(name) :].lstrip("/") if key != name else ""
        path = target / relative if relative else target
        path.parent.mkdir(parents=True, exist_ok=True)
        digests.append((relative, _fetch_file(filesystem, key, path, sizes[key], deadline)))
    return LocalLog(str(target), _digest_of_files(digests), sum(sizes.values()))


def _fetch_file(filesystem: Any, key: str, path: Path, size: int, deadline: float) -> str:
    digest = hashlib.sha256()
    done = 0
    with path.open("wb") as target:
        for chunk in _chunks(filesystem, key):
            digest.update(chunk)
            target.write(chunk)  # OSError is of our disk, not of the store
            done += len(chunk)
            if time.monotonic() > deadline:
                raise StoreError(f"{key}: took too long to fetch: {done} of {size} bytes came")
    if done != size:
        raise StoreError(f"{key}: {done} of {size} bytes came")
    return digest.hexdigest()


def _chunks(filesystem: Any, key: str) -> Iterator[bytes]:
    """What a store hands out, with its errors as StoreError."""
    source: BinaryIO | None = None
    try:
        source = filesystem.open(key, "rb", block_size=8 * CHUNK_BYTES, cache_type="readahead")
        assert source is not None
        while chunk := source.read(CHUNK_BYTES):
            yield chunk
    except Exception as error:
        raise StoreError(f"{key}: {_told(error)}") from error
    finally:
        if source is not None:
            source.close()


def _check_room(url: str, size: int, folder: Path, limits: FetchLimits) -> None:
    if size > limits.max_bytes:
        raise LogTooLargeError(
            f"{url}: has {size / 1e6:.0f} MB where --max-log allows {limits.max_bytes / 1e6:.0f} MB"
        )
    free = shutil.disk_usage(folder).free
    if size + SPARE_BYTES > free:
        text = f"{size / 1e6:.0f} MB of log do not fit into {free / 1e6:.0f} MB of {folder.parent}"
        raise OSError(errno.ENOSPC, text)


def _told(error: BaseException) -> str:
    return " ".join(str(error).split()) or type(error).__name__


def _remote_stamp(info: dict[str, Any]) -> str:
    keys = ("size", "ETag", "etag", "md5Hash", "VersionId", "LastModified", "mtime")
    return " ".join(str(info[key]) for key in keys if info.get(key) is not None)


def _digest_of(words: Any) -> str:
    return hashlib.sha256("\n".join(words).encode()).hexdigest()[:32]


def _digest_of_files(digests: list[tuple[str, str]]) -> str:
    """Of one file its own; of a folder that of names and files."""
    if len(digests) == 1 and not digests[0][0]:
        return digests[0][1]
    text = "\n".join(f"{digest} {name}" for name, digest in digests)
    return hashlib.sha256(text.encode()).hexdigest()
