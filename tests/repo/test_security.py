"""Test that the page on security states the limits that the program has."""

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
PAGE = " ".join((ROOT / "app" / "SECURITY.md").read_text(encoding="utf-8").split())


def test_security_page_states_current_limits():
    for statement in (
        f"{exr_scan.MAX_SIDE_PX:,} px",
        f"{exr_scan.MAX_CHANNELS:,} channels",
        f"{exr_scan.MAX_BYTES / 1e9:g} GB of pixels",
        f"{exr_scan._TILE_LEAST_PX:,} px",
        f"light beyond {LIGHT_MOST:g}".replace("e+", "e"),
        f"{gltf_file._NUMBERS_MOST // 1_000_000} million numbers",
        f"{gltf_file._EMPTY_NUMBERS_MOST // 1_000_000} million without bytes",
        f"{gltf_file._BUFFERS_MOST / 1e9:g} GB of buffers",
        f"{gltf_nodes._LEVELS_MOST} levels of nodes",
        f"{scene.INSTANCES_MOST:,} objects",
        f"{picture_read._TOGETHER_MOST // 1_000_000 + 1} million pixels together",
        f"{limits.SECONDS_MOST:g} seconds of processor time, {limits.SECONDS_A_MEGABYTE:g} more",
        f"for each megabyte of its files, and {limits.GIGABYTES_MOST:g} GB",
        limits.SECONDS,
        limits.GIGABYTES,
        f"{server.MOST_HANDS} hands and {server.MOST_LOOKERS} lookers",
        f"{connections.MOST_STRANGERS} connections without a right link",
        f"link and {connections.MOST_GUESTS} with one",
        f"idle one ends after {connections.KEEP_ALIVE_S:.0f} seconds",
        f"of a picture {picture._MOST_ENCODED} sizes are kept",
        f"{MESSAGE_MOST // 1024} kB and come {client._MESSAGES_PER_SECOND:.0f} a second",
        f"nothing for {client._STALLED_S:.0f} seconds",
    ):
        assert statement in PAGE, statement
    assert COC_MOST_PX == 1e6 and "beyond a million pixels" in PAGE


def test_readme_links_to_security_page():
    assert "(app/SECURITY.md)" in (ROOT / "README.md").read_text()
