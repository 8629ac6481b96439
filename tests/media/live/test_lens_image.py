"""Test the lens that a renderer sends as an image of one pixel."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.media.live.stream.images import TevImages
from heatlens.media.live.stream.protocol import CreateImage, UpdateImage
from heatlens.media.live.stream.received_plate import LENS_IMAGE, lens_header
from heatlens.media.plate.header.camera_header import camera_at_header
from support.tev_peers import client_of, picture, send_image, serving, settle, wait_until

NAMES = ("focal_length_mm", "sensor_width_mm", "f_stop", "focus_distance_m")


def send_lens(server, **values):
    with client_of(server) as client:
        client.create_image(LENS_IMAGE, 1, 1, list(values))
        client.update_image(LENS_IMAGE, np.float32([[list(values.values())]]), list(values))
    settle(server)


def test_tev_server_sets_camera_from_lens_image_before_or_after_plate():
    with serving() as server:
        send_lens(server, focal_length_mm=35, f_stop=1.4, focus_distance_m=math.inf, frame=12)
        assert server.snapshot() is None and server.names == ()
        send_image(server, "a", picture())
        camera = server.snapshot().camera
        assert (camera.focal_length_mm, camera.f_stop) == (35, pytest.approx(1.4))
        assert camera.focus_distance_m == math.inf and camera.sensor_width_mm is None
        version = server.version
        send_lens(server, focal_length_mm=50, sensor_width_mm=36, sensor_height_mm=24)
        camera = server.snapshot().camera
        assert (camera.focal_length_mm, camera.f_stop) == (50, None)
        assert (camera.sensor_width_mm, camera.sensor_height_mm) == (36, 24)
        wait_until(lambda: server.version > version)
        assert server.dropped == 0


def test_tev_server_keeps_lens_image_beyond_image_limit():
    with serving(images=TevImages(max_images=2)) as server:
        send_lens(server, f_stop=4)
        for name in "abc":
            send_image(server, name, picture())
        assert server.snapshot().camera.f_stop == 4


def test_tev_server_converts_radial_depth_with_sent_lens():
    with serving() as server:
        send_image(server, "render", picture(), ["R", "G", "B", "dd.T"])
        assert server.snapshot() is None
        send_lens(server, focal_length_mm=35, sensor_width_mm=36)
        assert server.snapshot().depth.kind == "radial"


def test_lens_header_of_image_without_values_is_empty():
    images = TevImages()
    images.apply(CreateImage(name=LENS_IMAGE, width=1, height=1, channels=NAMES))
    assert lens_header(images.get(LENS_IMAGE)) == {} == lens_header(None)


@given(st.lists(st.floats(width=32), min_size=4, max_size=4))
def test_lens_header_of_any_values_keeps_only_possible_ones(values):
    images = TevImages()
    images.apply(CreateImage(name=LENS_IMAGE, width=2, height=1, channels=NAMES))
    tiles = {
        name: np.full((1, 2), value, np.float32) for name, value in zip(NAMES, values, strict=True)
    }
    images.apply(UpdateImage(name=LENS_IMAGE, x=0, y=0, tiles=tiles))
    camera = camera_at_header([dict(lens_header(images.get(LENS_IMAGE)))])
    for name, value in zip(NAMES, values, strict=True):
        is_possible = value > 0 and (math.isfinite(value) or name == "focus_distance_m")
        assert getattr(camera, name) == (np.float32(value) if is_possible else None)
