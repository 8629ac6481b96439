"""A running window opens the files named by a later command line, and takes no other requests."""

import json
import os
import socket
import stat
import subprocess
import sys
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
from heatlens.studio.board import window_handover
from heatlens.studio.board.window_handover import WindowHandover, hand_over, handover_path
from support.exr_files import distances, rgb, write_file
from support.patience import PATIENCE_S


def plate_file(folder: Path) -> Path:
    return write_file(folder / "room.exr", rgb() | {"Z": distances()})


@pytest.fixture
def wake_event() -> threading.Event:
    return threading.Event()


@pytest.fixture
def handover(monkeypatch, tmp_path, wake_event) -> Iterator[WindowHandover]:
    monkeypatch.setenv("HEATLENS_RUNTIME_DIR", str(tmp_path / "run"))
    monkeypatch.setenv("HEATLENS_CONFIG_DIR", str(tmp_path / "config"))
    new_handover = WindowHandover(wake_event.set)
    yield new_handover
    new_handover.close()


def test_handed_over_names_arrive_once_and_in_order(handover, wake_event):
    assert handover.pop_names() == []
    assert hand_over(["/a.exr", "/b.exr"]) and hand_over(["demo"])
    assert wake_event.wait(10)
    assert [handover.pop_names(), handover.pop_names(), handover.pop_names()] == [
        ["/a.exr", "/b.exr"],
        ["demo"],
        [],
    ]


def test_handover_file_and_folder_are_readable_by_the_user_only(handover):
    assert stat.S_IMODE(handover_path().stat().st_mode) == 0o600
    assert stat.S_IMODE(handover_path().parent.stat().st_mode) == 0o700


def test_hand_over_refuses_a_handover_file_that_others_may_read(handover):
    handover_path().chmod(0o644)
    assert not hand_over(["/a.exr"])


def port_of_handover() -> int:
    return int(json.loads(handover_path().read_text())["port"])


def secret_of_handover() -> bytes:
    return str(json.loads(handover_path().read_text())["secret"]).encode()


@pytest.mark.parametrize("secret, names", [(b"0" * 64, b"/a.exr"), (b"", b"/a.exr"), (None, b"")])
def test_handover_answers_no_client_with_a_wrong_secret_or_no_names(handover, secret, names):
    with (
        pytest.raises((OSError, EOFError, AuthenticationError)),
        Client(
            ("127.0.0.1", port_of_handover()),
            authkey=secret_of_handover() if secret is None else secret,
        ) as line,
    ):
        line.send_bytes(names)
        line.recv_bytes()
    assert handover.pop_names() == []
    assert hand_over(["/a.exr"])  # it goes on


HUGE = b"\x7f\xff\xff\xff"


@pytest.mark.parametrize("message", [b"[" * 200_000, b"[" * 200_000 + b"\n", b"\0" * 9, HUGE, b""])
def test_handover_survives_malformed_messages(handover, message):
    """A deeply nested message must not be parsed before the secret is checked."""
    with socket.create_connection(("127.0.0.1", port_of_handover()), 10) as line, suppress(OSError):
        line.sendall(message)
        line.shutdown(socket.SHUT_WR)
        while line.recv(1 << 16):
            pass
    assert hand_over(["/a.exr"]) and handover.pop_names() == ["/a.exr"]


def test_silent_clients_do_not_block_other_clients_of_the_handover(handover, monkeypatch):
    monkeypatch.setattr(window_handover, "_PATIENCE_S", 60.0)
    with ExitStack() as stack:
        for _ in range(8):
            stack.enter_context(socket.create_connection(("127.0.0.1", port_of_handover()), 10))
        assert hand_over(["/a.exr"]) and handover.pop_names() == ["/a.exr"]


def test_handover_closes_a_client_that_sends_too_slowly(handover, monkeypatch):
    """Each byte comes in time, so only a limit for the whole message ends the connection."""
    monkeypatch.setattr(window_handover, "_PATIENCE_S", 0.2)
    with (
        socket.create_connection(("127.0.0.1", port_of_handover()), 10) as line,
        pytest.raises(OSError),
    ):
        for byte in b"\0\0\1\0" + bytes(250):  # the length of a message, and a part of it
            line.sendall(bytes([byte]))
            time.sleep(0.05)


def test_hand_over_tells_a_stranger_on_the_port_no_secret_and_no_names(monkeypatch, tmp_path):
    """A killed window leaves its file, and another program may take its port later."""
    monkeypatch.setenv("HEATLENS_RUNTIME_DIR", str(tmp_path))
    received = []
    with Listener(("127.0.0.1", 0)) as stranger:

        def listen() -> None:
            with stranger.accept() as line, suppress(EOFError, OSError):
                line.send_bytes(b"#CHALLENGE#" + bytes(20))
                received.append(line.recv_bytes())
                line.send_bytes(b"#WELCOME#")
                line.recv_bytes()  # the challenge of the other side, which it cannot answer
                line.send_bytes(bytes(16))
                received.append(line.recv_bytes())

        thread = threading.Thread(target=listen)
        thread.start()
        handover_path().write_text(json.dumps({"port": stranger.address[1], "secret": "f" * 64}))
        handover_path().chmod(0o600)
        assert not hand_over(["/secret/plate.exr"])
        thread.join(10)
    assert b"ffff" not in b"".join(received) and b"plate" not in b"".join(received)


@pytest.mark.parametrize("make", [os.mkfifo, lambda path: path.symlink_to("/dev/zero")])
def test_pipe_or_device_in_place_of_the_handover_file_is_not_read(monkeypatch, tmp_path, make):
    monkeypatch.setenv("HEATLENS_RUNTIME_DIR", str(tmp_path))
    make(handover_path())
    assert not hand_over(["/a.exr"])
    new_handover = WindowHandover(lambda: None)
    new_handover.close()


def test_link_in_place_of_the_handover_file_is_replaced_not_followed(monkeypatch, tmp_path):
    monkeypatch.setenv("HEATLENS_RUNTIME_DIR", str(tmp_path))
    victim = tmp_path / "victim"
    victim.write_text("mine")
    handover_path().symlink_to(victim)
    new_handover = WindowHandover(lambda: None)
    assert victim.read_text() == "mine"
    assert hand_over(["/a.exr"])
    new_handover.close()


def test_window_handover_opens_without_the_usual_runtime_folder(monkeypatch, tmp_path):
    def usual(self) -> str:
        raise PermissionError("/tmp/runtime-0 is a symlink")

    monkeypatch.setattr(PlatformDirs, "user_runtime_dir", property(usual))
    monkeypatch.delenv("HEATLENS_RUNTIME_DIR", raising=False)
    monkeypatch.setenv("HOME", str(tmp_path))
    new_handover = WindowHandover(lambda: None)
    assert hand_over(["/a.exr"]) and new_handover.pop_names() == ["/a.exr"]
    new_handover.close()


def test_hand_over_fails_without_a_window(handover):
    handover.close()
    assert not handover_path().exists() and not hand_over(["/a.exr"])
    handover_path().write_text('{"port": 1, "secret": "x"}')  # left behind by one that was killed
    handover_path().chmod(0o600)
    assert not hand_over(["/a.exr"])


def test_hand_over_waits_for_a_busy_window_but_for_no_dead_one(handover, monkeypatch):
    """A window that builds programs answers late; a killed one leaves a port that others take."""
    monkeypatch.setattr(window_handover, "_QUIET_S", 0.05)
    told, serve = threading.Event(), WindowHandover._serve_client

    def serve_late(self, client):
        assert told.wait(PATIENCE_S)
        serve(self, client)

    monkeypatch.setattr(WindowHandover, "_serve_client", serve_late)
    assert hand_over(["/a.exr"], told.set) and handover.pop_names() == ["/a.exr"]
    told.clear()
    dead = subprocess.Popen([sys.executable, "-c", ""])
    dead.wait()
    record = json.loads(handover_path().read_text()) | {"process": dead.pid}
    handover_path().write_text(json.dumps(record))
    assert not hand_over(["/a.exr"], told.set) and not told.is_set()


def test_hand_over_reaches_the_later_of_two_windows(handover, wake_event):
    later = WindowHandover(wake_event.set)
    handover.close()
    assert hand_over(["/a.exr"]) and later.pop_names() == ["/a.exr"] and handover.pop_names() == []
    later.close()


def test_closed_later_window_gives_the_handover_back(handover, wake_event):
    later = WindowHandover(lambda: None)
    later.close()
    assert hand_over(["/a.exr"]) and wake_event.wait(10)
    assert handover.pop_names() == ["/a.exr"]


def test_handover_of_an_earlier_window_that_has_gone_answers_nobody(handover):
    later = WindowHandover(lambda: None)
    handover.close()
    assert hand_over(["/a.exr"]) and later.pop_names() == ["/a.exr"]
    later.close()
    assert not hand_over(["/a.exr"])


def test_hand_over_ignores_windows_with_other_preferences(handover, monkeypatch, tmp_path):
    monkeypatch.setenv("HEATLENS_CONFIG_DIR", str(tmp_path / "other"))
    assert not hand_over(["/a.exr"])


def test_command_without_options_hands_its_file_to_the_window(
    handover, monkeypatch, tmp_path, capsys
):
    plate_file(tmp_path)
    monkeypatch.chdir(tmp_path)
    assert main(["room.exr"]) == 0
    assert handover.pop_names() == [str(tmp_path / "room.exr")]
    assert "--new-window" in capsys.readouterr().err
    assert main(["view", "gone.exr"]) == 2 and handover.pop_names() == []
    assert main(["demo"]) == 0 and handover.pop_names() == ["demo"]


@pytest.mark.parametrize("words", [("--new-window",), ("--f-stop", "2")])
def test_command_with_options_opens_a_window_of_its_own(handover, monkeypatch, tmp_path, words):
    opened_plates: list[Path] = []
    monkeypatch.setattr(
        "heatlens.fronts.commands.view._open", lambda args: opened_plates.append(args.plate) or 0
    )
    assert main([str(plate_file(tmp_path)), *words]) == 0
    assert handover.pop_names() == [] and len(opened_plates) == 1


def test_window_handover_works_without_a_folder_for_its_file(monkeypatch, tmp_path):
    (tmp_path / "file").write_text("")
    new_handover = WindowHandover(lambda: None, tmp_path / "file" / "window.json")
    assert new_handover.pop_names() == []
    new_handover.close()
    with pytest.raises(OSError):
        window_handover._read_handover(tmp_path / "file" / "window.json")


def test_runtime_dir_exists_without_environment_variables(monkeypatch):
    monkeypatch.delenv("HEATLENS_RUNTIME_DIR", raising=False)
    monkeypatch.delenv("XDG_RUNTIME_DIR", raising=False)
    assert runtime_dir().is_absolute()
