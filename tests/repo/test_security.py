"""The page on security tells the bounds that the program has."""

from pathlib import Path

from heatlens.media.files import limits
from heatlens.media.plate.depth.repair import COC_MOST_PX, LIGHT_MOST
from heatlens.media.plate.exr import exr_scan
from heatlens.media.scene import picture_read, scene
from heatlens.media.scene.gltf import file as gltf_file
from heatlens.media.scene.gltf import nodes as gltf_nodes
from heatlens.studio.share import client, connections, picture, server
from heatlens.studio.share.page_message import MESSAGE_MOST

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "app" / "SECURITY.md").read_text()


def test_every_bound_is_told_as_it_is():
    for told in (
        f"{exr_scan.MAX_SIDE_PX:,} px",
        f"{exr_scan.MAX_CHANNELS:,} channels",
        f"{exr_scan.MAX_BYTES / 1e9:g} GB of pixels",
        f"{exr_scan._TILE_LEAST_PX:,} px",
        f"light beyond {LIGHT_MOST:g}".replace("e+", "e"),
        f"{gltf_file._NUMBERS_MOST // 1_000_000} million numbers",
        f"{gltf_file._EMPTY_MOST // 1_000_000} million without bytes",
        f"{gltf_file._BUFFERS_MOST / 1e9:g} GB of buffers",
        f"{gltf_nodes._LEVELS_MOST} levels of nodes",
        f"{scene.INSTANCES_MOST:,} objects",
        f"{picture_read._TOGETHER_MOST // 1_000_000 + 1} million pixels together",
        f"{limits.SECONDS_MOST:g} seconds of processor time, {limits.SECONDS_A_MEGABYTE:g} more",
        f"for each megabyte of its files, and {limits.GIGABYTES_MOST:g} GB",
        limits.SECONDS,
        limits.GIGABYTES,
        f"{server.HANDS_MOST} hands and {server.LOOKERS_MOST} lookers",
        f"{connections.STRANGERS_MOST} connections without a right link",
        f"link and {connections.GUESTS_MOST} with one",
        f"idle one ends after {connections.KEPT_S:.0f} seconds",
        f"of a picture {picture._ENCODED_MOST} sizes are kept",
        f"{MESSAGE_MOST // 1024} kB and come {client._A_SECOND:.0f} a second",
        f"nothing for {client._STALLED_S:.0f} seconds",
    ):
        assert told in PAGE, told
    assert COC_MOST_PX == 1e6 and "beyond a million pixels" in PAGE


def test_readme_leads_there():
    assert "(app/SECURITY.md)" in (ROOT / "README.md").read_text()
