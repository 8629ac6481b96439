"""A session that listens: what a renderer sends is shown, read as told, and followed."""

import numpy as np
import pytest

from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.media.live.stream.received_plate import LENS_IMAGE
from heatlens.render.source.stream_source import StreamSource
from support.evening import session_of, settled, turn, until
from support.session_files import room_file
from support.tev_peers import CHANNELS, client_of, picture, settle, show

SENT = {"focal_length_mm": 35, "sensor_width_mm": 36, "f_stop": 4, "focus_distance_m": 3}


@pytest.fixture
def stream():
    made = StreamSource("127.0.0.1", 0)
    yield made
    made.close()


@pytest.fixture
def listening(stream, tmp_path):
    session = session_of(tmp_path, source=stream.text, stream=stream)
    yield session
    session.close()


def test_a_session_waits_for_a_stream_and_shows_what_comes(listening, stream):
    assert listening.facts.is_waiting and listening.facts.stream is stream
    assert listening.facts.picture_shape.width_px == 1
    show(stream._server, "one", picture())
    until(listening, lambda: listening.facts.plate is not None, "the frame")
    assert stream.is_shown and not listening.facts.is_waiting
    assert listening.source.once_only and not listening.source.is_sequence
    assert not listening.time.pull.is_on
    version = listening.facts.plate_version
    show(stream._server, "one", picture() + 1)
    until(listening, lambda: listening.facts.plate_version > version, "the next one")
    listening.files.commands.reload()
    assert listening.messages.text == listening.source.once_only
    assert not listening.files.commands.may_choose("save shot")
    assert listening.files.exports.why_not == listening.source.once_only


def test_the_options_of_a_stream_are_those_of_the_panel_and_of_undo(listening, stream):
    show(stream._server, "one", picture())
    until(listening, lambda: listening.facts.plate is not None, "the frame")
    settled(listening)
    reading = listening.files.commands.reading
    reading.change(PlateOptions(scene_unit_m=0.5))
    until(listening, lambda: listening.facts.plate.depth_m.max() == 25.0, "half of it")
    assert listening.editing.shot.plate_options.scene_unit_m == 0.5
    assert listening.editing.shot.source == stream.text
    listening.editing.settle()
    listening.editing.undo()
    until(listening, lambda: listening.facts.plate.depth_m.max() == 50.0, "it as before")
    assert reading.options == PlateOptions()


def test_a_stream_goes_when_a_file_is_opened_and_comes_back(listening, stream, tmp_path):
    show(stream._server, "one", picture())
    until(listening, lambda: listening.facts.plate is not None, "the frame")
    path = str(room_file(tmp_path / "still.exr", 8, 6))
    listening.files.commands.open(path)
    until(listening, lambda: listening.editing.shot.source == path, "the file")
    assert not stream.is_shown and not stream.is_wanted
    start = listening.files.start_choices
    card = next(card for card in start.cards() if card.text == stream.text)
    start.show()
    assert start.take(card) and not start.is_wanted
    until(listening, lambda: listening.editing.shot.source == stream.text, "the stream")
    assert stream.is_shown


def test_a_focus_that_nobody_told_waits_for_the_whole_depth(listening, stream):
    values = picture()
    with client_of(stream._server) as client:
        client.create_image("one", 9, 6, CHANNELS)
        client.update_image("one", values[:2], CHANNELS)
    settle(stream._server)
    until(listening, lambda: listening.facts.plate is not None, "a part")
    first = listening.facts.lens.focus_distance_m
    show(stream._server, "one", values)
    until(listening, lambda: listening.facts.plate.missing_count == 0, "all of it")
    until(listening, lambda: listening.facts.lens.focus_distance_m != first, "another focus")
    middle = np.sort(values[2:-2, 3:-3, 3], None)  # the middle third of 9x6 pixels
    assert listening.facts.lens.focus_distance_m == pytest.approx(middle[len(middle) // 2])
    listening.lens.commands.focus(1.25)
    show(stream._server, "one", values * np.float32([1, 1, 1, 2]))
    until(listening, lambda: listening.facts.plate.depth_m.max() > values[..., 3].max(), "another")
    turn(listening)
    assert listening.facts.lens.focus_distance_m == 1.25  # what a hand has set stays


def test_a_focus_that_was_set_before_the_depth_was_whole_stays(listening, stream):
    values = picture()
    with client_of(stream._server) as client:
        client.create_image("one", 9, 6, CHANNELS)
        client.update_image("one", values[:2], CHANNELS)
    until(listening, lambda: listening.facts.plate is not None, "a part")
    listening.lens.commands.focus(1.25)
    show(stream._server, "one", values)
    until(listening, lambda: listening.facts.plate.missing_count == 0, "all of it")
    turn(listening)
    assert listening.facts.lens.focus_distance_m == 1.25


def test_the_lens_of_a_renderer_is_followed_except_for_what_was_given(stream, tmp_path):
    def send(**values):
        show(stream._server, LENS_IMAGE, np.float32([[list(values.values())]]), list(values))

    session = session_of(
        tmp_path, source=stream.text, stream=stream, lens={"sensor_width_mm": 30.0}
    )
    try:
        show(stream._server, "one", picture())
        until(session, lambda: session.facts.plate is not None, "the frame")
        send(**SENT)
        until(session, lambda: session.facts.lens.f_stop == 4, "the lens that was sent")
        lens = session.facts.lens
        assert (lens.focal_length_mm, lens.focus_distance_m, lens.sensor_width_mm) == (35, 3, 30)
        session.lens.commands.focus(2.0)
        send(**SENT | {"f_stop": 8})
        until(session, lambda: session.facts.lens.f_stop == 8, "what has changed")
        assert session.facts.lens.focus_distance_m == 2.0
        send(focal_length_mm=35, focus_distance_m=0.02)  # within the focal length
        until(session, lambda: "cannot be used" in session.messages.text, "a sentence")
        assert session.facts.lens.f_stop == 8
    finally:
        session.close()
