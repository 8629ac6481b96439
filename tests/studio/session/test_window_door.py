"""A running window takes the names of a later command line, and of nobody else."""

import json
import os
import socket
import stat
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack, suppress
from multiprocessing import AuthenticationError
from multiprocessing.connection import Client, Listener
from pathlib import Path

import pytest
from platformdirs import PlatformDirs

from heatlens.core.base.paths import runtime_dir
from heatlens.fronts.commands.main import main
from heatlens.studio.session.files import window_door
from heatlens.studio.session.files.window_door import WindowDoor, door_path, hand_over
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


def port_of_door() -> int:
    return int(json.loads(door_path().read_text())["port"])


def secret_of_door() -> bytes:
    return str(json.loads(door_path().read_text())["secret"]).encode()


@pytest.mark.parametrize("secret, names", [(b"0" * 64, b"/a.exr"), (b"", b"/a.exr"), (None, b"")])
def test_whoever_does_not_know_the_secret_or_names_nothing_is_not_answered(door, secret, names):
    with (
        pytest.raises((OSError, EOFError, AuthenticationError)),
        Client(
            ("127.0.0.1", port_of_door()), authkey=secret_of_door() if secret is None else secret
        ) as line,
    ):
        line.send_bytes(names)
        line.recv_bytes()
    assert door.take() == []
    assert hand_over(["/a.exr"])  # it goes on


HUGE = b"\x7f\xff\xff\xff"


@pytest.mark.parametrize("said", [b"[" * 200_000, b"[" * 200_000 + b"\n", b"\0" * 9, HUGE, b""])
def test_nothing_that_strangers_say_closes_it(door, said):
    """The first of these was once parsed before the secret was looked at, and ended its thread."""
    with socket.create_connection(("127.0.0.1", port_of_door()), 10) as line, suppress(OSError):
        line.sendall(said)
        line.shutdown(socket.SHUT_WR)
        while line.recv(1 << 16):
            pass
    assert hand_over(["/a.exr"]) and door.take() == ["/a.exr"]


def test_clients_that_say_nothing_do_not_hold_up_others(door, monkeypatch):
    monkeypatch.setattr(window_door, "_PATIENCE_S", 60.0)
    with ExitStack() as stack:
        for _ in range(8):
            stack.enter_context(socket.create_connection(("127.0.0.1", port_of_door()), 10))
        assert hand_over(["/a.exr"]) and door.take() == ["/a.exr"]


def test_who_speaks_slowly_is_cut_off(door, monkeypatch):
    """Each byte comes in time, so only a limit of the whole ends it."""
    monkeypatch.setattr(window_door, "_PATIENCE_S", 0.2)
    with (
        socket.create_connection(("127.0.0.1", port_of_door()), 10) as line,
        pytest.raises(OSError),
    ):
        for byte in b"\0\0\1\0" + bytes(250):  # the length of a message, and a part of it
            line.sendall(bytes([byte]))
            time.sleep(0.05)


def test_a_program_that_took_the_port_learns_no_secret_and_gets_no_names(monkeypatch, tmp_path):
    """A window that was killed leaves its file, and its port may be anybody's later."""
    monkeypatch.setenv("HEATLENS_RUNTIME_DIR", str(tmp_path))
    heard = []
    with Listener(("127.0.0.1", 0)) as stranger:

        def listen() -> None:
            with stranger.accept() as line, suppress(EOFError, OSError):
                line.send_bytes(b"#CHALLENGE#" + bytes(20))
                heard.append(line.recv_bytes())
                line.send_bytes(b"#WELCOME#")
                line.recv_bytes()  # the challenge of the other side, which it cannot answer
                line.send_bytes(bytes(16))
                heard.append(line.recv_bytes())

        thread = threading.Thread(target=listen)
        thread.start()
        door_path().write_text(json.dumps({"port": stranger.address[1], "secret": "f" * 64}))
        door_path().chmod(0o600)
        assert not hand_over(["/secret/plate.exr"])
        thread.join(10)
    assert b"ffff" not in b"".join(heard) and b"plate" not in b"".join(heard)


@pytest.mark.parametrize("make", [os.mkfifo, lambda path: path.symlink_to("/dev/zero")])
def test_a_pipe_or_device_in_the_place_of_its_file_is_not_read(monkeypatch, tmp_path, make):
    monkeypatch.setenv("HEATLENS_RUNTIME_DIR", str(tmp_path))
    make(door_path())
    assert not hand_over(["/a.exr"])
    opened = WindowDoor(lambda: None)
    opened.close()


def test_a_link_in_the_place_of_its_file_is_replaced_and_not_followed(monkeypatch, tmp_path):
    monkeypatch.setenv("HEATLENS_RUNTIME_DIR", str(tmp_path))
    victim = tmp_path / "victim"
    victim.write_text("mine")
    door_path().symlink_to(victim)
    opened = WindowDoor(lambda: None)
    assert victim.read_text() == "mine"
    assert hand_over(["/a.exr"])
    opened.close()


def test_another_user_who_took_the_runtime_folder_keeps_no_window_from_opening(
    monkeypatch, tmp_path
):
    def usual(self) -> str:
        raise PermissionError("/tmp/runtime-0 is a symlink")

    monkeypatch.setattr(PlatformDirs, "user_runtime_dir", property(usual))
    monkeypatch.delenv("HEATLENS_RUNTIME_DIR", raising=False)
    monkeypatch.setenv("HOME", str(tmp_path))
    opened = WindowDoor(lambda: None)
    assert hand_over(["/a.exr"]) and opened.take() == ["/a.exr"]
    opened.close()


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
    monkeypatch.setattr(
        "heatlens.fronts.commands.view._open", lambda args: seen.append(args.plate) or 0
    )
    assert main([str(plate_file(tmp_path)), *words]) == 0
    assert door.take() == [] and len(seen) == 1


def test_a_folder_that_cannot_be_made_is_done_without(monkeypatch, tmp_path):
    (tmp_path / "file").write_text("")
    opened = WindowDoor(lambda: None, tmp_path / "file" / "window.json")
    assert opened.take() == []
    opened.close()
    with pytest.raises(OSError):
        window_door._read_door(tmp_path / "file" / "window.json")


def test_a_login_without_a_runtime_folder_has_one_all_the_same(monkeypatch):
    monkeypatch.delenv("HEATLENS_RUNTIME_DIR", raising=False)
    monkeypatch.delenv("XDG_RUNTIME_DIR", raising=False)
    assert runtime_dir().is_absolute()
