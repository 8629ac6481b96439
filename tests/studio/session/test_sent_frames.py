"""A session with a stream: frames and lenses that a renderer sends are shown and followed."""

import numpy as np
import pytest

from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.media.live.stream.received_plate import LENS_IMAGE
from heatlens.render.source.stream_source import StreamSource
from support.evening import run_loop_once, run_until, run_until_settled, session_of
from support.session_files import room_file
from support.tev_peers import CHANNELS, client_of, picture, send_image, settle

SENT_LENS = {"focal_length_mm": 35, "sensor_width_mm": 36, "f_stop": 4, "focus_distance_m": 3}


@pytest.fixture
def stream():
    new_source = StreamSource("127.0.0.1", 0)
    yield new_source
    new_source.close()


@pytest.fixture
def listening(stream, tmp_path):
    session = session_of(tmp_path, source=stream.text, stream=stream)
    yield session
    session.close()


def test_session_waits_for_a_stream_and_shows_its_frames(listening, stream):
    assert listening.facts.is_waiting and listening.facts.stream is stream
    assert listening.facts.shape.width_px == 1
    send_image(stream._server, "one", picture())
    run_until(listening, lambda: listening.facts.plate is not None, "the frame")
    assert stream.is_shown and not listening.facts.is_waiting
    assert listening.source.why_shown_once and not listening.source.is_sequence
    assert not listening.time.frames_ahead.is_on
    version = listening.facts.plate_version
    send_image(stream._server, "one", picture() + 1)
    run_until(listening, lambda: listening.facts.plate_version > version, "the next one")
    listening.files.commands.reload()
    assert listening.messages.text == listening.source.why_shown_once
    assert not listening.files.commands.may_choose("save shot")
    assert listening.files.exports.why_not == listening.source.why_shown_once


def test_plate_options_of_a_stream_apply_and_can_be_undone(listening, stream):
    send_image(stream._server, "one", picture())
    run_until(listening, lambda: listening.facts.plate is not None, "the frame")
    run_until_settled(listening)
    reading = listening.files.commands.reading
    reading.change(PlateOptions(scene_unit_m=0.5))
    run_until(listening, lambda: listening.facts.plate.depth_m.max() == 25.0, "half of it")
    assert listening.editing.shot.plate_options.scene_unit_m == 0.5
    assert listening.editing.shot.source == stream.text
    listening.editing.settle()
    listening.editing.undo()
    run_until(listening, lambda: listening.facts.plate.depth_m.max() == 50.0, "it as before")
    assert reading.options == PlateOptions()


def test_stream_is_left_for_a_file_and_reopened_from_its_card(listening, stream, tmp_path):
    send_image(stream._server, "one", picture())
    run_until(listening, lambda: listening.facts.plate is not None, "the frame")
    path = str(room_file(tmp_path / "still.exr", 8, 6))
    listening.files.commands.open(path)
    run_until(listening, lambda: listening.editing.shot.source == path, "the file")
    assert not stream.is_shown and not stream.should_show
    start = listening.files.start_choices
    card = next(card for card in start.cards() if card.text == stream.text)
    start.show()
    assert start.open_card(card) and not start.is_shown
    run_until(listening, lambda: listening.editing.shot.source == stream.text, "the stream")
    assert stream.is_shown


def test_default_focus_is_set_again_once_the_streamed_depth_is_whole(listening, stream):
    values = picture()
    with client_of(stream._server) as client:
        client.create_image("one", 9, 6, CHANNELS)
        client.update_image("one", values[:2], CHANNELS)
    settle(stream._server)
    run_until(listening, lambda: listening.facts.plate is not None, "a part")
    first = listening.facts.lens.focus_distance_m
    send_image(stream._server, "one", values)
    run_until(listening, lambda: listening.facts.plate.missing_count == 0, "all of it")
    run_until(listening, lambda: listening.facts.lens.focus_distance_m != first, "another focus")
    middle = np.sort(values[2:-2, 3:-3, 3], None)  # the middle third of 9x6 pixels
    assert listening.facts.lens.focus_distance_m == pytest.approx(middle[len(middle) // 2])
    listening.lens.commands.focus(1.25)
    send_image(stream._server, "one", values * np.float32([1, 1, 1, 2]))
    run_until(
        listening, lambda: listening.facts.plate.depth_m.max() > values[..., 3].max(), "another"
    )
    run_loop_once(listening)
    assert listening.facts.lens.focus_distance_m == 1.25  # what a hand has set stays


def test_focus_set_before_the_streamed_depth_is_whole_stays(listening, stream):
    values = picture()
    with client_of(stream._server) as client:
        client.create_image("one", 9, 6, CHANNELS)
        client.update_image("one", values[:2], CHANNELS)
    run_until(listening, lambda: listening.facts.plate is not None, "a part")
    listening.lens.commands.focus(1.25)
    send_image(stream._server, "one", values)
    run_until(listening, lambda: listening.facts.plate.missing_count == 0, "all of it")
    run_loop_once(listening)
    assert listening.facts.lens.focus_distance_m == 1.25


def test_streamed_lens_is_followed_except_for_given_options(stream, tmp_path):
    def send(**values):
        send_image(stream._server, LENS_IMAGE, np.float32([[list(values.values())]]), list(values))

    session = session_of(
        tmp_path, source=stream.text, stream=stream, lens={"sensor_width_mm": 30.0}
    )
    try:
        send_image(stream._server, "one", picture())
        run_until(session, lambda: session.facts.plate is not None, "the frame")
        send(**SENT_LENS)
        run_until(session, lambda: session.facts.lens.f_stop == 4, "the lens that was sent")
        lens = session.facts.lens
        assert (lens.focal_length_mm, lens.focus_distance_m, lens.sensor_width_mm) == (35, 3, 30)
        session.lens.commands.focus(2.0)
        send(**SENT_LENS | {"f_stop": 8})
        run_until(session, lambda: session.facts.lens.f_stop == 8, "what has changed")
        assert session.facts.lens.focus_distance_m == 2.0
        send(focal_length_mm=35, focus_distance_m=0.02)  # within the focal length
        run_until(session, lambda: "cannot be used" in session.messages.text, "a sentence")
        assert session.facts.lens.f_stop == 8
    finally:
        session.close()
