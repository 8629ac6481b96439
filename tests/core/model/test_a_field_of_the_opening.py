"""Check that a field added to `OpeningFields` reaches files, commands and panels by itself.

Each test runs in a process of its own, in which `OpeningFields` has two more fields before anything
else is imported: a number, and words, for which files of cameras have no place.
"""

import subprocess
import sys
import textwrap
from pathlib import Path

import pytest

_BEGIN = """
from dataclasses import dataclass
from enum import StrEnum
from heatlens.core.model.lens import opening_fields
from heatlens.core.model.option import option_field

class Coating(StrEnum):
    NONE = "none"
    GOLD = "gold"

@dataclass(frozen=True, slots=True, kw_only=True)
class MoreFields(opening_fields.OpeningFields):
    astigmatism: float = option_field(
        0.0, "astigmatism", "how far crosses tear", least=0.0, most=1.0, label="tearing"
    )
    coating: Coating = option_field(Coating.NONE, "coating", "of the glass")

opening_fields.OpeningFields = MoreFields

import sys
from pathlib import Path
from heatlens.core.model.lens.lens import Lens
folder = Path(sys.argv[1])
needed = dict(focal_length_mm=50.0, f_stop=2.0, focus_distance_m=2.0, sensor_width_mm=36.0)
lens = Lens(**needed, astigmatism=0.25, coating=Coating.GOLD)
"""


def run_with_two_new_fields(folder: Path, program: str) -> str:
    """Run `program` in a new process, and return its standard output.

    There the opening has the fields `astigmatism` and `coating`. The program finds a `lens` that
    sets both, the `needed` values of a lens, and `folder`.
    """
    text = _BEGIN + textwrap.dedent(program)
    process = subprocess.run(
        [sys.executable, "-c", text, str(folder)], capture_output=True, text=True, check=False
    )
    assert process.returncode == 0, process.stderr
    return process.stdout


def test_new_opening_field_is_in_aperture_and_checked(tmp_path):
    run_with_two_new_fields(
        tmp_path,
        """
        assert lens.aperture.astigmatism == 0.25 and not lens.aperture.is_plain
        try:
            Lens(**needed, astigmatism=2.0)
        except Exception as error:
            assert "astigmatism must be between 0 and 1" in str(error)
        else:
            raise AssertionError("no range")
        """,
    )


def test_new_opening_field_survives_lens_kit_file(tmp_path):
    run_with_two_new_fields(
        tmp_path,
        """
        from heatlens.media.documents.lens_kits import kit_text, read_kit
        from heatlens.core.model.lens.lens_kit import KitLens, LensCharacter, LensKit
        character = LensCharacter(astigmatism=0.25, coating=Coating.GOLD)
        kit = LensKit("own", "of the test", (KitLens(50.0, 2.0, 0.5),), character)
        (folder / "own.json").write_text(kit_text(kit))
        assert read_kit(folder / "own.json") == kit
        assert kit.limit_lens(Lens(**needed)).astigmatism == 0.25
        """,
    )


def test_new_opening_field_survives_shot_file(tmp_path):
    run_with_two_new_fields(
        tmp_path,
        """
        from heatlens.media.documents.shot_file import read_shot, write_shot
        from heatlens.core.model.shot.shot import Shot
        write_shot(folder / "a.heatlens.json", Shot(lens))
        assert read_shot(folder / "a.heatlens.json").lens == lens
        """,
    )


_CAMERA = """
        from heatlens.media.camera.camera_file import unsupported_notes, read_camera, write_camera
        from heatlens.render.source.named import camera_of_shot
        from heatlens.media.camera.into_shot import with_camera
        from heatlens.media.camera.usd_read import usd_camera
        from heatlens.core.model.curves.frames import FrameRange
        from heatlens.core.model.shot.shot import Shot
        camera = camera_of_shot(Shot(lens), "cam", FrameRange(1, 3))
        assert camera.opening["astigmatism"] == (0.25,) * 3
        assert camera.shaped_fields == ("astigmatism",)
        lost = [note for note in camera.notes if "coating" in note]
        assert len(lost) == 1 and "lost" in lost[0], camera.notes
"""


@pytest.mark.parametrize("suffix", [".csv", ".json", ".usda", ".usd"])
def test_camera_files_keep_numeric_field_and_note_lost_word_field(tmp_path, suffix):
    reader = "usd_camera" if suffix.startswith(".usd") else "read_camera"
    run_with_two_new_fields(
        tmp_path,
        f"""{_CAMERA}
        write_camera(folder / "cam{suffix}", camera)
        # A process of its own, as `read_camera` starts for USD, would not know the fields.
        read = {reader}(str(folder / "cam{suffix}"))
        assert read.shaped_fields == ("astigmatism",)
        assert set(read.opening["astigmatism"]) == {{0.25}}
        assert with_camera(Shot(Lens(35.0, 4.0, 1.0, 24.0)), read).lens.astigmatism == 0.25
        """,
    )


def test_nuke_and_python_cameras_get_new_field_or_note_it_as_lost(tmp_path):
    run_with_two_new_fields(
        tmp_path,
        f"""{_CAMERA}
        for name in ("cam.nk", "cam.py"):
            write_camera(folder / name, camera)
            assert "astigmatism" in (folder / name).read_text()
        (note,) = unsupported_notes("cam.nk", camera)
        assert "astigmatism" in note
        """,
    )


def test_command_line_and_python_api_accept_new_opening_field(tmp_path):
    out = run_with_two_new_fields(
        tmp_path,
        """
        import numpy as np, heatlens
        from heatlens.fronts.api.arguments import check_names
        from heatlens.fronts.commands.main import main
        check_names("render", ["astigmatism", "coating"])
        plate = heatlens.open(np.ones((8, 8, 3), np.float32), np.full((8, 8), 3.0, np.float32))
        try:
            plate.render(lens, astigmatism=7.0)
        except heatlens.HeatlensError as error:
            assert "astigmatism must be between 0 and 1" in str(error)
        else:
            raise AssertionError("not handed to the lens")
        try:
            main(["render", "--help-all"])
        except SystemExit:
            pass
        """,
    )
    assert "--astigmatism" in out and "how far crosses tear" in out
    assert "--coating {none,gold}" in out


def test_panel_and_settings_search_show_new_opening_field(tmp_path):
    out = run_with_two_new_fields(
        tmp_path,
        """
        from imgui_bundle import imgui
        from heatlens.studio.ui import widgets
        from heatlens.studio.ui.panels.opening_panel import opening_panel
        from heatlens.studio.ui.setting_places import SETTINGS
        assert {"tearing", "coating"} <= set(SETTINGS["Lens"])
        imgui.create_context()
        io = imgui.get_io()
        io.set_ini_filename("")
        io.display_size = (800, 1600)
        io.backend_flags |= imgui.BackendFlags_.renderer_has_textures
        drawn, label, slider = [], widgets.label, widgets.slider
        widgets.label = lambda words, *more: (drawn.append(words), label(words, *more))
        widgets.slider = lambda words, value, *more: (
            slider(words, value, *more), 0.5 if words == "tearing" else value)[1]
        for _ in range(2):
            imgui.new_frame()
            imgui.begin("panel")
            after = opening_panel(lens, print, lambda: None)
            imgui.end()
            imgui.render()
        assert after.astigmatism == 0.5 and after.coating is Coating.GOLD
        print(*drawn, sep=", ")
        """,
    )
    assert "tearing" in out and "coating" in out
