"""Test a renderer's frames over tev's protocol: which are accepted, refused and reported."""

import numpy as np
import pytest
import tevclient

from heatlens.core.model.boxes import Box
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.media.live.stream.chosen_image import plate_path
from heatlens.media.live.stream.images import TevImages
from heatlens.media.live.stream.protocol import CreateImage, TevPacketError
from heatlens.media.plate.plate import Plate
from support.tev_peers import (
    CHANNELS,
    assert_shows,
    client_of,
    packet,
    picture,
    send,
    send_image,
    settle,
    wait_until,
)


@pytest.mark.parametrize("tiled", [True, False])
def test_tev_snapshot_has_image_of_real_client(server, tiled):
    values = picture(150, 131)  # more than one tile each way
    with client_of(server) as client:
        client.create_image("shot.exr", 150, 131, CHANNELS)
        client.update_image("shot.exr", values, CHANNELS, perform_tiling=tiled)
    settle(server)
    plate = server.snapshot()
    assert isinstance(plate, Plate) and server.problem is None and server.dropped == 0
    assert_shows(plate, values)
    assert (plate.color[..., 3] == 1).all() and not plate.has_alpha
    assert plate.color.dtype == plate.depth_m.dtype == np.float32
    assert plate.color.flags.c_contiguous
    assert plate.data_window == plate.display_window == Box(0, 0, 150, 131)
    assert plate.aovs == tuple(CHANNELS) and plate.path.name == "shot.exr"
    assert plate.depth.convention == "distance" and plate.notes == ()


def test_tev_snapshot_shows_missing_pixels_black_and_infinitely_far(server):
    values = picture()
    with client_of(server) as client:
        client.create_image("a", 9, 6, [*CHANNELS, "A"])
    settle(server)
    assert server.snapshot() is None and "has arrived yet" in server.problem
    with client_of(server) as client:
        client.update_image("a", values[:, :4], CHANNELS)
        client.update_image("a", np.ones((6, 4), np.float32), ["A"])
    settle(server)
    plate = server.snapshot()
    expected = np.zeros((6, 9, 4), np.float32)
    expected[..., 3] = np.inf
    expected[:, :4] = values[:, :4]
    assert_shows(plate, expected)
    assert (plate.color[:, 4:] == 0).all() and (plate.color[:, :4, 3] == 1).all()
    assert plate.depth.infinite_count == 30 and plate.depth.far_m == values[:, :4, 3].max()
    assert plate.missing_count == 30
    assert_shows(server.snapshot(), expected)  # having looked changed nothing
    with client_of(server) as client:
        client.update_image("a", values[:, 4:], CHANNELS, x=4)
    settle(server)
    assert_shows(server.snapshot(), values)


def test_tev_snapshot_ignores_missing_pixels_in_depth_convention(server):
    """Values from 0.1 to 0.9 are ambiguous, as in a file, whether or not pixels are missing."""
    values = picture(far_m=0.9)
    values[..., 3] /= 2
    with client_of(server) as client:
        client.create_image("a", 9, 6, CHANNELS)
        client.update_image("a", values[:3], CHANNELS)
    settle(server)
    assert server.snapshot() is None
    assert "--depth-convention" in server.problem
    plate = server.snapshot(options=PlateOptions(depth_convention="distance", scene_unit_m=10.0))
    np.testing.assert_allclose(plate.depth_m[:3], values[:3, :, 3] * 10, rtol=1e-6)


def test_tev_snapshot_waits_for_pixels_of_newest_image(server):
    """An older image with the channels is not shown in the meantime."""
    send_image(server, "old", picture())
    with client_of(server) as client:
        client.create_image("new", 4, 3, CHANNELS)
    settle(server)
    assert server.snapshot() is None and "new" in server.problem
    assert_shows(server.snapshot("old"), picture())
    assert server.problem is None


def test_tev_snapshot_treats_missing_circle_of_confusion_as_in_focus(server):
    values = picture()
    with client_of(server) as client:
        client.create_image("a", 9, 6, ["R", "G", "B", "coc"])
        client.update_image("a", values[:2], ["R", "G", "B", "coc"])
    settle(server)
    plate = server.snapshot(options=PlateOptions(depth_convention="coc"))
    np.testing.assert_array_equal(plate.coc_px[:2], values[:2, :, 3])
    assert (plate.coc_px[2:] == 0).all() and plate.depth_m is None


def test_tev_snapshot_shows_newest_image_with_depth_until_closed(server):
    first_image, second_image = picture(), picture(4, 3, far_m=7.0)
    send_image(server, "one", first_image)
    send_image(server, "two", second_image)
    send_image(server, "flat", second_image[..., :3], "RGB")  # later still, but without a depth
    assert server.names == ("flat", "two", "one")
    assert_shows(server.snapshot(), second_image)
    assert_shows(server.snapshot("one"), first_image)
    with client_of(server) as client:
        client.close_image("two")
        client.close_image("never there")
    settle(server)
    assert server.names == ("flat", "one") and server.dropped == 0
    assert_shows(server.snapshot(), first_image)
    assert server.snapshot("two") is None and "'two'" in server.problem
    send_image(server, "flat", second_image)  # created anew, now with depth
    send_image(server, "one", first_image)
    assert server.names == ("one", "flat")


def test_tev_snapshot_does_not_change_after_later_updates(server):
    send_image(server, "a", picture())
    plate, version = server.snapshot(), server.version
    send_image(server, "a", picture() + 1)
    wait_until(lambda: server.version > version)
    assert_shows(plate, picture())
    assert_shows(server.snapshot(), picture() + 1)


def test_tev_snapshot_reports_missing_depth(server):
    assert server.snapshot() is None and str(server.address[1]) in server.problem
    send_image(server, "flat", picture()[..., :3], "RGB")
    assert server.snapshot() is None
    assert "flat has no depth channel" in server.problem


PLANES = np.moveaxis(picture(), -1, 0)


def test_tev_update_versions_1_to_3_give_same_image(server):
    planes = np.ascontiguousarray(PLANES)
    for name in ("v1", "v2", "v3"):
        send(server, packet(4, True, name, 9, 6, 4, *CHANNELS))
    for channel, plane in zip(CHANNELS, planes, strict=True):
        send(server, packet(3, True, "v1", channel, 0, 0, 9, 6, plane.tobytes()))
    send(server, packet(5, True, "v2", 4, *CHANNELS, 0, 0, 9, 6, planes.tobytes()))
    layout = np.array([0, 1, 2, 3, 4, 4, 4, 4], "<i8").tobytes()
    interleaved = picture().tobytes()
    send(server, packet(6, True, "v3", 4, *CHANNELS, 0, 0, 9, 6, layout, interleaved))
    settle(server)
    assert server.dropped == 0
    for name in server.names:
        assert_shows(server.snapshot(name), picture())


BAD = {
    "beyond the right": packet(3, True, "a", "R", 1, 0, 9, 6, bytes(216)),
    "above": packet(3, True, "a", "R", 0, -1, 9, 6, bytes(216)),
    "too few values": packet(3, True, "a", "R", 0, 0, 9, 6, bytes(212)),
    "no such channel": packet(3, True, "a", "Q", 0, 0, 9, 6, bytes(216)),
    "no such image": packet(3, True, "b", "R", 0, 0, 9, 6, bytes(216)),
    "nothing": packet(3, True, "a", "R", 0, 0, 0, 0),
    "negative": packet(3, True, "a", "R", 0, 0, -3, -3, bytes(36)),
    "huge": packet(4, True, "a", 16384, 16384, 2, "R", "G"),
    "huge side": packet(4, True, "a", 1 << 30, 1, 1, "R"),
    "no channel": packet(4, True, "a", 9, 6, 0),
    "a channel twice": packet(4, True, "a", 9, 6, 2, "R", "R"),
    "2 billion channels": packet(4, True, "a", 9, 6, 2**31 - 1, "R"),
    "not UTF-8": packet(2, b"\xff\xfe\0"),
    "endless name": packet(2, b"n" * 5000),
    "unknown operation": packet(77, True, "a"),
    "empty": b"\4\0\0\0",
    "offset": packet(6, True, "a", 1, "R", 0, 0, 1, 1, b"\xff" * 8 + b"\1" + bytes(11)),
    "stride": packet(6, True, "a", 1, "R", 0, 0, 2, 1, bytes(8) + b"\xff" * 7 + b"\x7f" * 9),
}


@pytest.mark.parametrize("kind", BAD)
def test_tev_server_drops_bad_packet_and_takes_the_next(server, kind):
    send_image(server, "a", picture())
    send(server, BAD[kind] + packet(4, True, "after", 2, 2, 1, "R"))
    settle(server)
    assert server.dropped == 1 and "dropped: " in server.fault
    assert server.names == ("after", "a")  # on the same connection
    assert_shows(server.snapshot(), picture())


def test_tev_server_ignores_vector_graphics(server):
    with client_of(server) as client:
        client.update_vector_graphics("a", [tevclient.vg_fill(), tevclient.vg_text(0, 0, "hi")])
    settle(server)
    assert server.names == () and server.snapshot() is None and server.dropped == 0


@pytest.mark.parametrize(
    "name", ["../../etc/passwd", "C:\\a", "", "..", "a\nb\0", "x" * 5000, "~/"]
)
def test_plate_path_of_any_name_has_no_folder(name):
    path = plate_path(name)
    assert len(path.parts) == 1 and path.name and len(path.name) <= 100
    assert path.name.isprintable() and not set(path.name) & set('/\\:"')


def test_tev_images_drop_oldest_beyond_limits():
    images = TevImages(max_images=3, max_values=100)
    for index in range(5):
        images.apply(CreateImage(name=str(index), width=5, height=5, channels=("Z",)))
    assert images.names == ("4", "3", "2")
    images.apply(CreateImage(name="wide", width=5, height=12, channels=("Z",)))
    assert images.names == ("wide", "4") and images.value_count == 85
    with pytest.raises(TevPacketError):
        images.apply(CreateImage(name="4", width=5, height=21, channels=("Z",)))
    assert images.names == ("wide", "4")
