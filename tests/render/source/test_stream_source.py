"""A running renderer as a source: each frame arrives once, and a refusal is told in words."""

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
from support.tev_peers import CHANNELS, assert_shows, client_of, picture, send, settle, show
from support.tev_peers import wait_until as until


@contextmanager
def streaming():
    stream = StreamSource("127.0.0.1", 0)
    try:
        yield stream
    finally:
        stream.close()


def sent(stream, name, values, channels=CHANNELS):
    """Send an image, and wait until the server has told all of its news, 20 times a second."""
    show(stream._server, name, values, channels)
    until(lambda: not (stream._server._changed or stream._server._has_news))


def polled(stream):
    """Return the plate that `poll` brings next."""
    found = []

    def has_come():
        plate = stream.poll()
        found.extend([] if plate is None else [plate])
        return bool(found)

    until(has_come)
    return found[0]


def rested(stream):
    """Poll until nothing is being made, and return what came."""
    came = [stream.poll()]
    until(lambda: came.append(stream.poll()) or not stream._maker.is_busy)
    return [plate for plate in came if plate is not None]


def test_each_frame_arrives_once_and_wakes_the_loop():
    with streaming() as stream:
        woken = []
        stream.wake = lambda: woken.append(True)
        assert stream.poll() is None  # nothing has been sent
        stream.begin(PlateOptions())
        assert stream.is_wanted and not stream.is_shown
        sent(stream, "one", picture())
        assert_shows(polled(stream), picture())
        assert woken and rested(stream) == []
        sent(stream, "one", picture() + 1)
        assert_shows(polled(stream), picture() + 1)


def test_what_nobody_wants_is_not_made():
    with streaming() as stream:
        sent(stream, "one", picture())
        assert rested(stream) == [] and not stream._maker.is_busy
        stream.begin(PlateOptions())
        assert_shows(polled(stream), picture())
        stream.show(False)
        assert not (stream.is_wanted or stream.is_shown)
        sent(stream, "one", picture() + 1)
        assert rested(stream) == []
        stream.show(True)
        assert stream.is_wanted and stream.is_shown
        stream.begin(PlateOptions())  # as the opener does when it is chosen again
        assert_shows(polled(stream), picture() + 1)


def test_a_frame_is_read_again_with_other_options():
    with streaming() as stream:
        sent(stream, "one", picture())
        stream.begin(PlateOptions())
        polled(stream)
        stream.begin(PlateOptions(depth_convention=DepthConvention.DISTANCE, scene_unit_m=2.0))
        plate = polled(stream)
        np.testing.assert_allclose(plate.depth_m, 2 * picture()[..., 3])


def test_a_frame_that_is_no_plate_is_told_and_the_next_one_comes():
    with streaming() as stream:
        sent(stream, "flat", picture()[..., :3], CHANNELS[:3])
        stream.begin(PlateOptions())
        assert rested(stream) == []
        assert (
            stream.problem and stream.problem in stream.refusal and stream.refusal in stream.words
        )
        sent(stream, "whole", picture())
        assert_shows(polled(stream), picture())
        assert stream.problem == "" == stream.refusal == stream.arriving
        assert stream.words == f"Listening on {stream.address} ..."


def test_a_depth_that_is_still_being_sent_is_counted():
    with streaming() as stream:
        values = picture()
        with client_of(stream._server) as client:
            client.create_image("part", 9, 6, CHANNELS)
            client.update_image("part", values[:2], CHANNELS)
        settle(stream._server)
        stream.begin(PlateOptions())
        polled(stream)
        assert "36 of 54 pixels" in stream.arriving and stream.arriving in stream.words
        sent(stream, "part", values)
        polled(stream)
        assert stream.arriving == ""


def test_packets_that_are_dropped_are_counted():
    with streaming() as stream:
        assert stream.losses == ""
        send(stream._server, b"\x05\0\0\0\xff")
        settle(stream._server)
        until(lambda: stream.losses != "")
        assert "dropped: 1, refused: 0" in stream.losses and stream.losses in stream.refusal


def test_between_two_plates_there_is_a_tenth_of_a_second(monkeypatch):
    slept, now = [], [100.0]
    with streaming() as stream:
        monkeypatch.setattr(
            stream_source,
            "time",
            SimpleNamespace(sleep=slept.append, monotonic=lambda: now[0]),
        )
        sent(stream, "one", picture())
        stream.begin(PlateOptions())
        polled(stream)
        assert slept == [0.0]  # the first one comes at once
        now[0] += 0.03
        stream.begin(PlateOptions())
        polled(stream)
        assert slept[1] == pytest.approx(0.07)
        now[0] += 5.0
        stream.begin(PlateOptions())
        polled(stream)
        assert slept[2] == 0.0


def test_the_stream_is_opened_when_its_first_frame_has_come():
    with streaming() as stream:
        opener = SourceOpener(lambda: None, stream)
        options = PlateOptions(scene_unit_m=2.0)
        opener.open(stream.text, options)
        assert opener.opening is None and opener.poll() is None and stream.options == options
        sent(stream, "one", picture())
        found = []
        until(lambda: found.append(opener.poll()) or found[-1] is not None)
        opened = found[-1]
        assert isinstance(opened, OpenedStream) and opened.frame == 1
        assert (opened.text, opened.options) == (stream.text, options)
        assert (
            opened.frames is opened.timing is opened.scene is opened.cache is opened.again is None
        )
        assert opened.settled == options and opened.news == 0 and opened.attributes == {}
        assert (
            opened.stamps == opened.files_at(1, "stop") == () and opened.notes == opened.plate.notes
        )
        shot = opened.shot(opened.lens({"f_stop": 4.0}).lens, DefocusSettings())
        assert (shot.source, shot.plate_options, shot.lens.f_stop) == (stream.text, options, 4.0)
        stream.show(True)
        sent(stream, "one", picture() + 1)
        assert opener.poll() is None  # the next frames are not opened again
        opened.close()
        polled(stream)  # it goes on listening


def test_an_address_with_colons_stands_in_brackets(monkeypatch):
    class Server:
        address = ("::1", 14158)

        def __init__(self, *_args, **_more):
            pass

        def close(self):
            pass

    monkeypatch.setattr(stream_source, "TevServer", Server)
    assert StreamSource("::1", 14158).text == "tev://[::1]:14158"


def test_an_address_that_is_taken_is_refused():
    with streaming() as stream, pytest.raises(HeatlensError, match=stream.address.split(":")[1]):
        StreamSource("127.0.0.1", int(stream.address.rsplit(":", 1)[1]))


def test_a_closed_stream_wants_nothing_and_closes_twice():
    with streaming() as stream:
        stream.begin(PlateOptions())
        stream.close()
        assert not stream.is_wanted and stream.poll() is None
