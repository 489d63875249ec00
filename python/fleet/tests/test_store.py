"""Logs in a store that fails now and then: S3 by moto on loopback."""

from __future__ import annotations

import threading
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

import fsspec
import pytest

from conftest import Fleet
from loopstone_fleet import store
from loopstone_fleet.main import main

BUCKET = "fleet"
Answer = Callable[..., Any]


class FailingStore:
    """Lets a store fail for objects by their names: `flaky` twice, `cut` once, `dead` always."""

    def __init__(self, app: Any) -> None:
        self._app = app
        self.asked: Counter[str] = Counter()
        self.failing = True

    def __call__(self, environment: dict[str, Any], answer: Answer) -> Iterable[bytes]:
        path, method = environment["PATH_INFO"], environment["REQUEST_METHOD"]
        name = path.rpartition("/")[2]
        if not self.failing or method != "GET" or not path.startswith(f"/{BUCKET}/{name}"):
            return list(self._app(environment, answer))
        self.asked[name] += 1
        asked = self.asked[name]
        if name.startswith("dead") or (name.startswith("flaky") and asked <= 2):
            answer("503 Service Unavailable", [("Content-Type", "text/plain")])
            return [b"later"]
        if name.startswith("cut") and asked == 1:
            return self._half(environment, answer)
        return list(self._app(environment, answer))

    def _half(self, environment: dict[str, Any], answer: Answer) -> Iterable[bytes]:
        body = b"".join(self._app(environment, answer))
        return [body[: len(body) // 2]]


@pytest.fixture(scope="module")
def failing_store() -> Iterator[FailingStore]:
    pytest.importorskip("s3fs", reason="s3fs is not installed")
    pytest.importorskip("moto.server", reason="moto[server] is not installed")
    import s3fs
    from moto.moto_server.werkzeug_app import DomainDispatcherApplication, create_backend_app
    from werkzeug.serving import make_server

    failing = FailingStore(DomainDispatcherApplication(create_backend_app))
    server = make_server("127.0.0.1", 0, failing, threaded=True)
    thread = threading.Thread(target=server.serve_forever, daemon=True)
    thread.start()
    before = dict(fsspec.config.conf)
    fsspec.config.conf["s3"] = {
        "key": "test",
        "secret": "test",
        "endpoint_url": f"http://127.0.0.1:{server.server_port}",
        # Each failure is to be seen, so that it is not the client alone that is tested.
        "config_kwargs": {"retries": {"max_attempts": 0}},
    }
    s3fs.S3FileSystem.clear_instance_cache()
    filesystem = fsspec.filesystem("s3")
    filesystem.retries = 1
    filesystem.mkdir(BUCKET)
    yield failing
    fsspec.config.conf.clear()
    fsspec.config.conf.update(before)
    s3fs.S3FileSystem.clear_instance_cache()
    server.shutdown()
    thread.join()


def put(name: str, text: str) -> str:
    with fsspec.open(f"s3://{BUCKET}/{name}", "w") as file:
        file.write(text)
    return f"s3://{BUCKET}/{name}"


def test_a_store_that_fails_now_and_then(fleet: Fleet, failing_store: FailingStore) -> None:
    body = "ok\n" + "x" * 100_000
    names = ["fine", "flaky1", "flaky2", "cut", "dead", "poison"]
    for name in names:
        put(name, "crash\n" if name == "poison" else body + name)
    lines = [f"s3://{BUCKET}/{name}" for name in [*names, "missing"]]
    scratch = fleet.folder / "scratch"
    flags = ["--retries", "3", "--scratch", str(scratch), "--workers", "2"]
    manifest = fleet.manifest(lines)
    assert fleet.run(manifest, *flags) == 1
    assert fleet.statuses() == {
        "fine": "done",
        "flaky1": "done",
        "flaky2": "done",
        "cut": "done",
        "dead": "store_failed",
        "poison": "crashed",
        "missing": "bad_data",
    }
    rows = fleet.rows()
    assert rows["flaky1"]["attempts"] == rows["flaky2"]["attempts"] == 3
    assert rows["dead"]["attempts"] == 4
    assert rows["fine"]["log_bytes"] == len(body) + len("fine")
    assert fleet.times_mapped("cut") == fleet.times_mapped("fine") == 1
    assert fleet.times_mapped("dead") == 0
    assert list(scratch.iterdir()) == []
    # The store is well again: what failed is done, nothing else is fetched.
    failing_store.failing = False
    failing_store.asked.clear()
    assert fleet.run(manifest, *flags) == 0
    failing_store.failing = True
    assert fleet.statuses()["dead"] == "done"
    assert fleet.times_mapped("fine") == fleet.times_mapped("poison") == 1


def test_a_folder_of_a_store_is_one_log(fleet: Fleet, failing_store: FailingStore) -> None:
    put("drive/b.txt", "b")
    put("drive/sub/a.txt", "a")
    limits = store.FetchLimits(1 << 20, 30)
    with store.at_hand(f"s3://{BUCKET}/drive#7", fleet.folder, limits) as log:
        folder = Path(log.path.removesuffix("#7"))
        assert folder.name == "drive"
        assert (folder / "b.txt").read_text() == "b"
        assert (folder / "sub" / "a.txt").read_text() == "a"
        assert log.size_bytes == 2
        with store.at_hand(str(folder), fleet.folder, limits) as local:
            assert local.digest == log.digest
    assert not folder.exists()


def test_what_is_too_large_is_not_fetched(fleet: Fleet, failing_store: FailingStore) -> None:
    manifest = fleet.manifest([put("large", "ok\n" + "x" * 5000)])
    assert fleet.run(manifest, "--max-log", "4K") == 0
    assert fleet.statuses() == {"large": "bad_data"}
    assert "--max-log allows" in fleet.rows()["large"]["reason"]
    assert failing_store.asked["large"] == 0


def test_a_manifest_is_made_of_a_prefix(
    fleet: Fleet, failing_store: FailingStore, capsys: pytest.CaptureFixture[str]
) -> None:
    for name in ("day/r1/a.bag", "day/r1/notes.txt", "day/r2/b.mcap"):
        put(name, "ok\n")
    path = fleet.folder / "made.csv"
    assert main(["manifest", f"s3://{BUCKET}/day/", "--levels", "robot", "-o", str(path)]) == 0
    assert path.read_text().splitlines() == [
        "log,robot,site,options",
        f"s3://{BUCKET}/day/r1/a.bag,r1,,",
        f"s3://{BUCKET}/day/r2/b.mcap,r2,,",
    ]
    assert fleet.run(path) == 0
    assert fleet.statuses() == {"a.bag": "done", "b.mcap": "done"}


def test_a_stamp_changes_with_its_log(fleet: Fleet, failing_store: FailingStore) -> None:
    remote = put("stamped", "one")
    local = fleet.log("stamped")
    before = (store.stamp_of(remote), store.stamp_of(str(local)))
    assert None not in before
    assert before == (store.stamp_of(remote), store.stamp_of(str(local)))
    put("stamped", "two")
    local.write_text("two")
    after = (store.stamp_of(remote), store.stamp_of(str(local)))
    assert all(one != two for one, two in zip(before, after))
    assert store.stamp_of(f"s3://{BUCKET}/none") is None
    assert store.stamp_of("/none") is None


def test_digests_are_of_content_and_names(tmp_path: Path) -> None:
    limits = store.FetchLimits(1, 1)

    def digest(files: dict[str, str]) -> str:
        folder = tmp_path / str(len(list(tmp_path.iterdir())))
        for name, text in files.items():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            (folder / name).write_text(text)
        with store.at_hand(str(folder), tmp_path, limits) as log:
            return log.digest

    first = digest({"a": "1", "s/b": "2"})
    assert first == digest({"s/b": "2", "a": "1"})
    others = [{"a": "1", "b": "2"}, {"a": "2", "s/b": "1"}, {"a": "12", "s/b": ""}, {"a": "1"}]
    assert len({first, *map(digest, others)}) == 5
