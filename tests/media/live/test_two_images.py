"""Test streams with color and depth in two images, in a file, or under Mitsuba's names."""

import math

import numpy as np
import pytest

from heatlens.core.model.shot.plate_options import PlateOptions
from support.exr_files import write_file
from support.tev_peers import assert_shows, picture, send_image

GREY = ["R", "G", "B"]


@pytest.mark.parametrize(
    ("name", "channels"),
    [
        ("depth", ["Z"]),
        ("depth", ["V"]),
        ("depth", GREY),
        ("shot.0001/z-depth.exr", ["Y"]),
        ("aovs", ["Z", "objectId"]),
    ],
)
@pytest.mark.parametrize("is_depth_first", [True, False])
def test_tev_snapshot_takes_depth_of_second_image(server, name, channels, is_depth_first):
    values = picture()
    depth = np.repeat(values[..., 3:], len(channels), axis=2)
    images = [("beauty", values[..., :3], GREY), (name, depth, channels)]
    for image in images[:: 1 if is_depth_first else -1]:
        send_image(server, *image)
    assert_shows(server.snapshot(), values)
    assert server.problem is None and server.snapshot().path.name == "beauty"


def test_tev_snapshot_ignores_depth_of_other_size_or_of_full_image(server):
    send_image(server, "depth", picture(5, 4)[..., 3:], ["Z"])
    send_image(server, "earlier", picture())
    send_image(server, "beauty", 2 * picture()[..., :3], GREY)
    assert_shows(server.snapshot(), picture())  # the newest that has both
    assert "beauty has no depth channel" in server.problem


def test_tev_snapshot_takes_named_channel_of_second_image(server):
    values = picture()
    send_image(server, "beauty", values[..., :3], GREY)
    send_image(server, "extra", np.dstack([values[..., 3:], values]), ["q", "R", "G", "B", "w"])
    options = PlateOptions(depth_channel="extra.q", color_layer="")
    plate = server.snapshot("beauty", options)
    assert plate is None  # one image was asked for, and it has no such channel
    np.testing.assert_array_equal(server.snapshot(options=options).depth_m, values[..., 3])


def test_tev_snapshot_takes_depth_from_file(server, tmp_path):
    values = picture()
    depth = write_file(tmp_path / "depth.exr", {"Z": np.ascontiguousarray(values[..., 3])})
    send_image(server, "beauty", values[..., :3], GREY)
    assert server.snapshot() is None and "no depth channel" in server.problem
    plate = server.snapshot(options=PlateOptions(depth_source=str(depth)))
    assert_shows(plate, values)


@pytest.mark.parametrize("channel", ["dd.T", "dd.y.T", "T"])
def test_tev_snapshot_converts_mitsuba_ray_distance_to_planar_depth(server, channel):
    """For a lens of 18 mm on 36 mm, the ray through the corner of a wide image is the longest."""
    values = picture(90, 60)
    values[..., 3] = 10.0
    send_image(server, "render", values, ["R", "G", "B", channel])
    assert server.snapshot() is None and "radial depth to planar" in server.problem
    options = PlateOptions(focal_length_mm=18.0, sensor_width_mm=36.0)
    plate = server.snapshot(options=options)
    x, y = 44.5 * 36 / 90 / 18, 29.5 * 36 / 90 / 18
    assert plate.depth_m[0, 0] == pytest.approx(10 / math.hypot(1, x, y), rel=1e-5)


def test_tev_snapshot_takes_mitsuba_dd_y_as_depth(server):
    send_image(server, "render", picture(), ["R", "G", "B", "dd.y"])
    assert_shows(server.snapshot(), picture())
