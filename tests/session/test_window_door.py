"""A running window takes the names of a later command line, and of nobody else."""

import json
import socket
import stat
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

from heatlens.commands.main import main
from heatlens.folders import runtime_dir
from heatlens.session import window_door
from heatlens.session.window_door import WindowDoor, door_path, hand_over
from support.exr_files import distances, rgb, write_file


def plate_file(folder: Path) -> Path:
    return write_file(folder / "room.exr", rgb() | {"Z": distances()})


@pytest.fixture
def woken() -> threading.Event:
    return threading.Event()


@pytest.fixture
def door(monkeypatch, tmp_path, woken) -> Iterator[WindowDoor]:
    monkeypatch.setenv("HEATLENS_RUNTIME_DIR", str(tmp_path / "run"))
    monkeypatch.setenv("HEATLENS_CONFIG_DIR", str(tmp_path / "config"))
    opened = WindowDoor(woken.set)
    yield opened
    opened.close()


def test_names_arrive_once_and_in_order(door, woken):
    assert door.take() == []
    assert hand_over(["/a.exr", "/b.exr"]) and hand_over(["demo"])
    assert woken.wait(10)
    assert [door.take(), door.take(), door.take()] == [["/a.exr", "/b.exr"], ["demo"], []]


def test_only_the_user_may_read_where_it_listens(door):
    assert stat.S_IMODE(door_path().stat().st_mode) == 0o600
    assert stat.S_IMODE(door_path().parent.stat().st_mode) == 0o700


def test_a_file_that_others_may_read_is_not_trusted(door):
    door_path().chmod(0o644)
    assert not hand_over(["/a.exr"])


@pytest.mark.parametrize(
    "request_of",
    [
        lambda told: {"secret": "0" * 64, "open": ["/a.exr"]},
        lambda told: {"open": ["/a.exr"]},
        lambda told: {"secret": told["secret"], "open": "/a.exr"},
        lambda told: {"secret": told["secret"], "open": []},
        lambda told: {"secret": told["secret"], "open": [1]},
        lambda told: [told["secret"], "/a.exr"],
    ],
)
def test_whoever_does_not_know_the_secret_or_names_nothing_is_not_answered(door, request_of):
    told = json.loads(door_path().read_text())
    with socket.create_connection(("127.0.0.1", told["port"]), 10) as line:
        line.sendall(json.dumps(request_of(told)).encode() + b"\n")
        assert line.recv(100) == b""
    assert door.take() == []
    assert hand_over(["/a.exr"])  # it goes on


def test_without_a_window_nothing_is_handed_over(door):
    door.close()
    assert not door_path().exists() and not hand_over(["/a.exr"])
    door_path().write_text('{"port": 1, "secret": "x"}')  # left behind by one that was killed
    door_path().chmod(0o600)
    assert not hand_over(["/a.exr"])


def test_the_later_of_two_windows_is_asked_and_keeps_its_file(door, woken):
    later = WindowDoor(woken.set)
    door.close()
    assert hand_over(["/a.exr"]) and later.take() == ["/a.exr"] and door.take() == []
    later.close()


def test_windows_with_other_preferences_do_not_know_of_each_other(door, monkeypatch, tmp_path):
    monkeypatch.setenv("HEATLENS_CONFIG_DIR", str(tmp_path / "other"))
    assert not hand_over(["/a.exr"])


def test_the_command_hands_over_what_is_named_without_options(door, monkeypatch, tmp_path, capsys):
    plate_file(tmp_path)
    monkeypatch.chdir(tmp_path)
    assert main(["room.exr"]) == 0
    assert door.take() == [str(tmp_path / "room.exr")]
    assert "--new-window" in capsys.readouterr().err
    assert main(["view", "gone.exr"]) == 2 and door.take() == []
    assert main(["demo"]) == 0 and door.take() == ["demo"]


@pytest.mark.parametrize("words", [("--new-window",), ("--f-stop", "2")])
def test_with_options_a_window_of_its_own_opens(door, monkeypatch, tmp_path, words):
    seen: list[Path] = []
    monkeypatch.setattr("heatlens.commands.view._open", lambda args: seen.append(args.plate) or 0)
    assert main([str(plate_file(tmp_path)), *words]) == 0
    assert door.take() == [] and len(seen) == 1


def test_a_folder_that_cannot_be_made_is_done_without(monkeypatch, tmp_path):
    (tmp_path / "file").write_text("")
    opened = WindowDoor(lambda: None, tmp_path / "file" / "window.json")
    assert opened.take() == []
    opened.close()
    assert window_door._read_door(tmp_path / "file" / "window.json") is None


def test_a_login_without_a_runtime_folder_has_one_all_the_same(monkeypatch):
    monkeypatch.delenv("HEATLENS_RUNTIME_DIR", raising=False)
    monkeypatch.delenv("XDG_RUNTIME_DIR", raising=False)
    assert runtime_dir().is_absolute()
