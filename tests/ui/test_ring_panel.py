"""A window whose lens follows a ring: what is sent is seen, and the hand can let go of it."""

import argparse
import time

import pytest

from heatlens.commands import view
from heatlens.errors import InputError
from heatlens.ring.address import Protocol, RingAddress
from heatlens.ring.lens_sample import LensSample
from heatlens.ring.receiver import LensReceiver
from heatlens.ring.sender import LensSender
from support.gui import gui_of
from support.window_plates import QUICK, room_file

PATIENCE_S = 30.0


@pytest.fixture(scope="module")
def receiver():
    with LensReceiver(RingAddress(Protocol.OPENTRACKIO, "127.0.0.1", 0)) as made:
        yield made


@pytest.fixture(scope="module")
def followed(session_context, receiver, tmp_path_factory):
    plate = room_file(tmp_path_factory.mktemp("ring") / "room.exr")
    with gui_of(session_context, plate, defocus=QUICK, lens_in=receiver) as gui:
        yield gui


@pytest.fixture
def ring(receiver):
    with LensSender(receiver.address, 24.0) as sender:
        yield sender


def until(gui, is_so) -> None:
    end = time.monotonic() + PATIENCE_S
    while not is_so():
        assert time.monotonic() < end
        gui.frame()
        time.sleep(0.001)


def test_the_lens_and_the_picture_follow(followed, ring):
    before = followed.session.seen
    assert "follow ring" in followed.drawn
    for distance_m in (1.8, 1.5, 1.2):
        ring.send(LensSample("A", focus_distance_m=distance_m, f_stop=2.0))
        until(followed, lambda at=distance_m: followed.session.lens.focus_distance_m == at)
    until(followed, lambda: followed.session.seen is not before)
    assert followed.session.lens.f_stop == 2.0
    until(followed, lambda: followed.session.ring.to_picture_s is not None)


def test_the_hand_lets_go_of_the_ring(followed, ring, receiver):
    ring.send(LensSample("A", focus_distance_m=2.0))
    until(followed, lambda: followed.session.lens.focus_distance_m == 2.0)
    followed.click(followed.middle("follow ring"))
    count = receiver.heard().version
    ring.send(LensSample("A", focus_distance_m=3.0))
    until(followed, lambda: receiver.heard().version > count)
    followed.frame(3)
    assert followed.session.lens.focus_distance_m == 2.0
    followed.click(followed.middle("follow ring"))
    ring.send(LensSample("A", focus_distance_m=3.5))
    until(followed, lambda: followed.session.lens.focus_distance_m == 3.5)


def test_another_source_can_be_chosen(followed, ring):
    session = followed.session
    ring.send(LensSample("A", focus_distance_m=2.0))
    ring.send(LensSample("B", focus_distance_m=1.0))
    until(followed, lambda: "B" in session.ring.heard.sources)
    assert session.lens.focus_distance_m != 1.0
    session.ring.listen_to("B")
    until(followed, lambda: session.lens.focus_distance_m == 1.0)
    session.ring.listen_to(None)


def test_a_port_that_is_taken_is_explained_before_the_window_opens(receiver, tmp_path):
    plate = room_file(tmp_path / "room.exr")
    parser = argparse.ArgumentParser()
    view.register(parser.add_subparsers())
    args = parser.parse_args(["view", str(plate), "--lens-in", str(receiver.address)])
    with pytest.raises(InputError, match="another program may listen there already"):
        view.run(args)
