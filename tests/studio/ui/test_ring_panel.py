"""A window whose lens follows a ring, until following is switched off in the panel."""

import argparse

import pytest

from heatlens.core.base.errors import InputError
from heatlens.fronts.commands import view
from heatlens.fronts.commands.command_parser import add_command
from heatlens.media.live.ring.address import Protocol
from heatlens.media.live.ring.opentrackio import source_id
from heatlens.media.live.ring.sender import LensSender
from heatlens.media.live.ring.sources import LensSample
from heatlens.studio.ui.panels.ring_panel import _sender_name
from support.ring_window import draw_until, window_following_ring
from support.session_files import room_file

A, B = source_id("A"), source_id("B")


@pytest.fixture(scope="module")
def followed(session_context, tmp_path_factory):
    folder = tmp_path_factory.mktemp("ring")
    with window_following_ring(session_context, Protocol.OPENTRACKIO, folder) as gui:
        yield gui


@pytest.fixture
def receiver(followed):
    return followed.session.lens.ring.receiver


@pytest.fixture
def ring(receiver):
    with LensSender(receiver.address) as sender:
        yield sender


def test_lens_and_picture_follow_the_ring(followed, ring):
    before = followed.session.facts.shown_picture
    assert "follow ring" in followed.drawn
    for distance_m in (1.8, 1.5, 1.2):
        ring.send(LensSample(A, focus_distance_m=distance_m, f_stop=2.0))
        draw_until(
            followed, lambda at=distance_m: followed.session.facts.lens.focus_distance_m == at
        )
    draw_until(followed, lambda: followed.session.facts.shown_picture is not before)
    assert followed.session.facts.lens.f_stop == 2.0
    draw_until(followed, lambda: followed.session.lens.ring.median_latency_s is not None)


def test_follow_ring_checkbox_stops_and_resumes_following(followed, ring, receiver):
    ring.send(LensSample(A, focus_distance_m=2.0))
    draw_until(followed, lambda: followed.session.facts.lens.focus_distance_m == 2.0)
    followed.click(followed.middle("follow ring"))
    count = receiver.source_state().version
    ring.send(LensSample(A, focus_distance_m=3.0))
    draw_until(followed, lambda: receiver.source_state().version > count)
    followed.frame(3)
    assert followed.session.facts.lens.focus_distance_m == 2.0
    followed.click(followed.middle("follow ring"))
    ring.send(LensSample(A, focus_distance_m=3.5))
    draw_until(followed, lambda: followed.session.facts.lens.focus_distance_m == 3.5)


def test_listen_to_chooses_the_source_of_the_ring(followed, ring):
    session = followed.session
    ring.send(LensSample(A, focus_distance_m=2.0))
    ring.send(LensSample(B, focus_distance_m=1.0))
    draw_until(followed, lambda: B in session.lens.ring.heard.sources)
    assert session.facts.lens.focus_distance_m != 1.0
    session.lens.ring.listen_to(B)
    draw_until(followed, lambda: session.facts.lens.focus_distance_m == 1.0)
    session.lens.ring.listen_to(None)


def test_words_of_an_unnamed_sender_show_the_start_of_its_number():
    assert _sender_name("urn:uuid:9f1c6d1e-1f53-4b5e-8a3c-0d7c5b1a2e3f") == "sender 9f1c6d1e"
    assert _sender_name("A camera") == "A camera" and _sender_name("") == "without a name"


def test_port_in_use_is_reported_before_the_window_opens(receiver, tmp_path):
    plate = room_file(tmp_path / "room.exr")
    parser = argparse.ArgumentParser()
    add_command(parser.add_subparsers(), "view", "", view)
    args = parser.parse_args(["view", str(plate), "--lens-in", str(receiver.address)])
    with pytest.raises(InputError, match="another program may listen there already"):
        view.run(args)
