"""StreamSource, frames sent by a running renderer: each arrives once, refusals have messages."""

from contextlib import contextmanager
from types import SimpleNamespace

import numpy as np
import pytest

from heatlens.core.base.errors import HeatlensError
from heatlens.core.model.depth_words import DepthConvention
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.shot.settings import DefocusSettings
from heatlens.render.source import stream_source
from heatlens.render.source.opener import SourceOpener
from heatlens.render.source.stream_source import OpenedStream, StreamSource
from support.tev_peers import CHANNELS, assert_shows, client_of, picture, send, send_image, settle
from support.tev_peers import wait_until as until


@contextmanager
def open_stream(wake=lambda: None):
    stream = StreamSource(host="127.0.0.1", port=0, wake=wake)
    try:
        yield stream
    finally:
        stream.close()


def send_and_settle(stream, name, values, channels=CHANNELS):
    """Send an image, and wait until the server, 20 times a second, has reported all changes."""
    send_image(stream._server, name, values, channels)
    until(lambda: not (stream._server._has_changed_images or stream._server._has_new_fault))


def poll_next_plate(stream):
    """Poll until a plate arrives, and return it."""
    plates = []

    def has_come():
        plate = stream.poll()
        plates.extend([] if plate is None else [plate])
        return bool(plates)

    until(has_come)
    return plates[0]


def poll_until_idle(stream):
    """Poll until the plate maker is idle, and return the plates that arrived."""
    results = [stream.poll()]

    def is_idle():
        results.append(stream.poll())
        return not stream._plate_maker.is_busy

    until(is_idle)
    return [plate for plate in results if plate is not None]


def test_stream_delivers_each_frame_once_and_wakes_loop():
    wake_calls = []
    with open_stream(lambda: wake_calls.append(True)) as stream:
        assert stream.poll() is None  # nothing has been sent
        stream.begin(PlateOptions())
        assert stream.should_show and not stream.is_shown
        send_and_settle(stream, "one", picture())
        assert_shows(poll_next_plate(stream), picture())
        assert wake_calls and poll_until_idle(stream) == []
        send_and_settle(stream, "one", picture() + 1)
        assert_shows(poll_next_plate(stream), picture() + 1)


def test_stream_makes_no_plate_unless_shown():
    with open_stream() as stream:
        send_and_settle(stream, "one", picture())
        assert poll_until_idle(stream) == [] and not stream._plate_maker.is_busy
        stream.begin(PlateOptions())
        assert_shows(poll_next_plate(stream), picture())
        stream.show(False)
        assert not (stream.should_show or stream.is_shown)
        send_and_settle(stream, "one", picture() + 1)
        assert poll_until_idle(stream) == []
        stream.show(True)
        assert stream.should_show and stream.is_shown
        stream.begin(PlateOptions())  # as the opener does when it is chosen again
        assert_shows(poll_next_plate(stream), picture() + 1)


def test_stream_rereads_frame_with_changed_options():
    with open_stream() as stream:
        send_and_settle(stream, "one", picture())
        stream.begin(PlateOptions())
        poll_next_plate(stream)
        stream.begin(PlateOptions(depth_convention=DepthConvention.DISTANCE, scene_unit_m=2.0))
        plate = poll_next_plate(stream)
        np.testing.assert_allclose(plate.depth_m, 2 * picture()[..., 3])


def test_stream_reports_frame_without_depth_and_delivers_next():
    with open_stream() as stream:
        send_and_settle(stream, "flat", picture()[..., :3], CHANNELS[:3])
        stream.begin(PlateOptions())
        assert poll_until_idle(stream) == []
        assert (
            stream.problem
            and stream.problem in stream.refusal
            and stream.refusal in stream.status_text
        )
        send_and_settle(stream, "whole", picture())
        assert_shows(poll_next_plate(stream), picture())
        assert stream.problem == "" == stream.refusal == stream.arriving
        assert stream.status_text == f"Listening on {stream.address} ..."


def test_stream_reports_pixels_of_arriving_depth():
    with open_stream() as stream:
        values = picture()
        with client_of(stream._server) as client:
            client.create_image("part", 9, 6, CHANNELS)
            client.update_image("part", values[:2], CHANNELS)
        settle(stream._server)
        stream.begin(PlateOptions())
        poll_next_plate(stream)
        assert "36 of 54 pixels" in stream.arriving and stream.arriving in stream.status_text
        send_and_settle(stream, "part", values)
        poll_next_plate(stream)
        assert stream.arriving == ""


def test_stream_counts_dropped_packets():
    with open_stream() as stream:
        assert stream.losses == ""
        send(stream._server, b"\x05\0\0\0\xff")
        settle(stream._server)
        until(lambda: stream.losses != "")
        assert "dropped: 1, refused: 0" in stream.losses and stream.losses in stream.refusal


def test_stream_waits_a_tenth_of_a_second_between_plates(monkeypatch):
    sleeps_s, clock_s = [], [100.0]
    with open_stream() as stream:
        monkeypatch.setattr(
            stream_source,
            "time",
            SimpleNamespace(sleep=sleeps_s.append, monotonic=lambda: clock_s[0]),
        )
        send_and_settle(stream, "one", picture())
        stream.begin(PlateOptions())
        poll_next_plate(stream)
        assert sleeps_s == [0.0]  # the first one comes at once
        clock_s[0] += 0.03
        stream.begin(PlateOptions())
        poll_next_plate(stream)
        assert sleeps_s[1] == pytest.approx(0.07)
        clock_s[0] += 5.0
        stream.begin(PlateOptions())
        poll_next_plate(stream)
        assert sleeps_s[2] == 0.0


def test_opener_opens_stream_with_its_first_frame():
    with open_stream() as stream:
        opener = SourceOpener(lambda: None, stream)
        options = PlateOptions(scene_unit_m=2.0)
        opener.open(stream.text, options)
        assert opener.opening is None and opener.poll() is None and stream.options == options
        send_and_settle(stream, "one", picture())
        polled_sources = []
        until(lambda: polled_sources.append(opener.poll()) or polled_sources[-1] is not None)
        opened = polled_sources[-1]
        assert isinstance(opened, OpenedStream) and opened.frame == 1
        assert (opened.text, opened.options) == (stream.text, options)
        assert (
            opened.frames
            is opened.timing
            is opened.scene
            is opened.cache
            is opened.render_source
            is None
        )
        assert (
            opened.settled_options == options
            and opened.change_count == 0
            and opened.attributes == {}
        )
        assert (
            opened.stamps == opened.files_at(1, "stop") == () and opened.notes == opened.plate.notes
        )
        shot = opened.shot(opened.lens({"f_stop": 4.0}).lens, DefocusSettings())
        assert (shot.source, shot.plate_options, shot.lens.f_stop) == (stream.text, options, 4.0)
        stream.show(True)
        send_and_settle(stream, "one", picture() + 1)
        assert opener.poll() is None  # the next frames are not opened again
        opened.close()
        poll_next_plate(stream)  # it goes on listening


def test_stream_text_puts_ipv6_address_in_brackets(monkeypatch):
    class Server:
        address = ("::1", 14158)

        def __init__(self, *_args, **_more):
            pass

        def close(self):
            pass

    monkeypatch.setattr(stream_source, "TevServer", Server)
    assert StreamSource("::1", 14158).text == "tev://[::1]:14158"


def test_stream_source_refuses_address_in_use():
    with open_stream() as stream, pytest.raises(HeatlensError, match=stream.address.split(":")[1]):
        StreamSource("127.0.0.1", int(stream.address.rsplit(":", 1)[1]))


def test_closed_stream_returns_nothing_and_can_close_again():
    with open_stream() as stream:
        stream.begin(PlateOptions())
        stream.close()
        assert not stream.should_show and stream.poll() is None
