"""Test that commands load only the modules that they use; loading dominates small renders."""

import subprocess
import sys

import pytest

from support.command_line import ENVIRONMENT
from support.exports import write_shot_file
from support.exr_files import distances, rgb, write_file

RUN = """
import sys
from heatlens.fronts.commands.main import main
code = main(sys.argv[1:])
print(*sys.modules, file=sys.stderr)
sys.exit(code)
"""
RENDERER = (
    "heatlens.render.defocus",
    "heatlens.render.frame_renderer",
    "heatlens.render.gpu",
    "heatlens.render.scene_gpu",
    "moderngl",
)
RARE_PARTS = (
    *("PIL", "fileseq", "heatlens.media.documents.edit_file", "heatlens.media.plate.behind"),
    *("heatlens.media.plate.deep.deep_plate", "heatlens.media.plate.estimate.estimated_depth"),
    *("heatlens.media.plate.neighbours.found", "heatlens.media.plate.mattes.cutout"),
    *("heatlens.media.plate.picture.picture_open", "heatlens.media.plate.tracking"),
    *("heatlens.media.scene.scene", "numpy.ma"),
)
UNUSED_BY_RENDER = tuple(part for part in RARE_PARTS if part != "heatlens.media.scene.scene")
READERS = (
    "heatlens.media.scene.gltf",
    "heatlens.media.scene.usd",
    "heatlens.media.scene.mesh_read",
    "pxr",
    "trimesh",
)


def modules_loaded_by(*words: object) -> set[str]:
    """Return the modules that a process has loaded when its command has ended."""
    command = [sys.executable, "-c", RUN, *map(str, words)]
    run = subprocess.run(command, env=ENVIRONMENT, capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    return set(run.stderr.splitlines()[-1].split())


def parts_among(modules: set[str], parts: tuple[str, ...]) -> set[str]:
    """Return the parts that are loaded, as a whole or one of their modules."""
    return {part for part in parts if any(f"{name}.".startswith(f"{part}.") for name in modules)}


@pytest.fixture
def plate(tmp_path):
    return write_file(tmp_path / "plate.exr", rgb() | {"Z": distances()})


def test_render_of_plate_loads_neither_scene_readers_nor_rare_parts(plate, tmp_path):
    lens = "--f-stop 2 --focus-distance 3 --focal-length 50 --sensor-width 36".split()
    modules = modules_loaded_by("-q", "render", plate, "-o", tmp_path / "out.exr", *lens)
    assert "heatlens.render.defocus.pipeline" in modules
    assert not parts_among(modules, (*READERS, *UNUSED_BY_RENDER))
    assert "importlib.metadata" not in modules  # reports of faults alone tell versions


def test_info_of_plate_loads_neither_renderer_nor_rare_parts(plate):
    modules = modules_loaded_by("info", plate)
    assert not parts_among(modules, (*READERS, *RENDERER, *RARE_PARTS))


def test_shot_show_loads_no_renderer(tmp_path):
    shot = write_shot_file(tmp_path)
    assert not parts_among(modules_loaded_by("shot", "show", shot), (*READERS, *RENDERER))


def test_info_of_obj_loads_only_mesh_reader(tmp_path):
    mesh = tmp_path / "one.obj"
    mesh.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    modules = modules_loaded_by("info", mesh)
    assert "heatlens.media.scene.mesh_read" in modules
    assert not {name for name in modules if name.startswith(("heatlens.media.scene.usd", "pxr"))}
