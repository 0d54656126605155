"""The runtime folder: the user's own, closed to others, never reached through a link."""

import os
import socket
import tempfile
from pathlib import Path

import pytest

from bench.errors import DeviceError
from bench.safety.runtime import RUNTIME, SOCKET_BYTES, open_here, runtime_folder, socket_path


def test_it_is_made_for_its_owner_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(RUNTIME, str(tmp_path / "locks"))
    assert runtime_folder() == tmp_path / "locks"
    assert (tmp_path / "locks").stat().st_mode & 0o777 == 0o700
    assert runtime_folder() == tmp_path / "locks"


def test_nothing_is_made_where_it_is_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # a frozen disk keeps whoever makes a folder waiting, also one that is there
    monkeypatch.setenv(RUNTIME, str(tmp_path / "mine"))
    folder = runtime_folder()

    def wait(*_: object, **__: object) -> None:
        raise AssertionError("this waits for a disk")

    monkeypatch.setattr(os, "mkdir", wait)
    assert runtime_folder() == folder


def test_a_link_that_somebody_prepared_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(RUNTIME)
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    (tmp_path / "victim").mkdir(mode=0o700)
    (tmp_path / f"gearbench-{os.geteuid()}").symlink_to(tmp_path / "victim")
    with pytest.raises(DeviceError, match="is a link"):
        runtime_folder()


def test_one_of_another_user_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(RUNTIME, str(tmp_path / "locks"))
    (tmp_path / "locks").mkdir(mode=0o700)
    monkeypatch.setattr(os, "geteuid", lambda: os.getuid() + 1)
    with pytest.raises(DeviceError, match=f"belongs to user {os.getuid()}"):
        runtime_folder()


def test_one_that_others_may_enter_is_refused_or_closed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "open").mkdir()
    (tmp_path / "open").chmod(0o755)
    monkeypatch.setenv(RUNTIME, str(tmp_path / "open"))
    with pytest.raises(DeviceError, match="needs mode 0700"):
        runtime_folder()
    assert (tmp_path / "open").stat().st_mode & 0o777 == 0o755
    # the default one is nobody else's business
    monkeypatch.delenv(RUNTIME)
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    folder = tmp_path / f"gearbench-{os.geteuid()}"
    folder.mkdir()
    folder.chmod(0o755)
    assert runtime_folder() == folder
    assert folder.stat().st_mode & 0o777 == 0o700


def test_a_link_among_its_files_is_not_followed(tmp_path: Path) -> None:
    (tmp_path / "victim").write_text("precious")
    (tmp_path / "bus-eth0").symlink_to(tmp_path / "victim")
    with pytest.raises(OSError, match="symbolic links"):
        open_here(tmp_path / "bus-eth0")
    assert (tmp_path / "victim").read_text() == "precious"


def test_a_path_too_long_for_a_socket_is_refused_and_the_longest_one_is_bound(monkeypatch: pytest.MonkeyPatch) -> None:
    name = "20261123T230448-0a1b2c.sock"
    # pytest's own folders have long paths
    with tempfile.TemporaryDirectory(prefix="b") as short:
        most = SOCKET_BYTES - 1 - len(name) - len(short) - 1
        monkeypatch.setenv(RUNTIME, f"{short}/{'a' * most}")
        with socket.socket(socket.AF_UNIX) as longest:
            longest.bind(str(socket_path(name)))
        monkeypatch.setenv(RUNTIME, f"{short}/{'a' * (most + 1)}")
        with pytest.raises(DeviceError, match=rf"has 80 bytes, .* at most 79 would be right; .* with {RUNTIME}"):
            socket_path(name)
