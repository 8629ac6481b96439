"""A term of the lens's geometry stands in one place: one that is added here arrives everywhere.

Fields of `FocusOffset` and GLSL cannot be extended from outside, so the tests edit a copy of the
program: a field of the opening, what it adds to `FocusOffset`, and its line of GLSL. All else is
found by itself.
The term bends the surface that is sharp to an S: its dioptres go with the square of the way from
the middle of the picture, and change their sign there.
"""

import subprocess
import textwrap
from pathlib import Path

import pytest

from support.program_copies import copy_program, run_in_copy

_FIELD = """
    split_dioptres: float = option_field("""
_NEW_FIELD = """
    bow_dioptres: float = option_field(
        0.0, "bow", "dioptres at the right edge", metavar="D", least=-5.0, most=5.0,
        label="bow", term="bow_dioptres",
    )"""
_FOCUS_OFFSET = {
    "    split: float = 0.0\n": "    split: float = 0.0\n    bow: Triple = (0.0, 0.0, 0.0)\n",
    "        return self.slope, self.edge\n": "        return self.slope, self.edge, self.bow\n",
    "tilted, split_part = (": "tilted, split_part, bow = (",
    "np.asarray(tilted + ": "np.asarray(tilted + bow * np.abs(bow) + ",
    "slope, edge = ((a, b, c -": "slope, edge, bow = ((a, b, c -",
    "slope, edge = ((a / scale": "slope, edge, bow = ((a / scale",
    "slope=slope, edge=edge)": "slope=slope, edge=edge, bow=bow)",
    "self.slope[0] * x + self.slope[1] * y for": """self.slope[0] * x + self.slope[1] * y
            + (self.bow[0] * x + self.bow[2]) * abs(self.bow[0] * x + self.bow[2]) for""",
    'return {\n            "focus_offset_slope": slope,': """sign = math.copysign(1.0, per_dioptre)
        bow = tuple(sign * abs(per_dioptre) ** 0.5 * it for it in self.bow)
        return {
            "focus_offset_bow": bow, "focus_offset_slope": slope,""",
    "    centered = FocusOffset(": """    bow = lens.bow_dioptres
    bow = math.copysign(abs(bow) ** 0.5, bow)
    centered = FocusOffset(""",
    "edge_at_middle), lens.split_dioptres)": """edge_at_middle), lens.split_dioptres,
        (bow / (width / 2), 0.0, 0.0))""",
}
_GLSL = {
    "\nfloat focus_offset_at(vec2 px) {": """
uniform vec3 focus_offset_bow;

float focus_offset_at(vec2 px) {""",
    "return dot(focus_offset_slope, position) +": """return dot(focus_offset_slope, position)
        + dot(focus_offset_bow, position) * abs(dot(focus_offset_bow, position)) +""",
}

_BEGIN = """
from dataclasses import replace
from heatlens.core.model.lens.lens import Lens
lens = Lens(50.0, 1.0, 3.0, 36.0, bow_dioptres=0.2)
level = replace(lens, bow_dioptres=0.0)
"""


@pytest.fixture(scope="module")
def copy(tmp_path_factory) -> Path:
    """Return the folder of a copy of the program that has the term."""
    model = "app/heatlens/core/model"
    edits = {
        f"{model}/lens/opening_fields.py": {_FIELD: _NEW_FIELD + _FIELD},
        f"{model}/focus/focus_offset.py": _FOCUS_OFFSET,
        "shaders/lib/focus_offset.lib.glsl": _GLSL,
    }
    return copy_program(tmp_path_factory.mktemp("copy"), edits)


def run(copy: Path, program: str) -> subprocess.CompletedProcess[str]:
    """Run `program` in the edited copy, after code that makes the lenses `lens` and `level`."""
    return run_in_copy(copy, _BEGIN + textwrap.dedent(program))


def test_every_method_draws_or_refuses_added_term(copy):
    run(
        copy,
        """
        import numpy as np
        from heatlens.core.model.shot.settings import Method
        refused = []
        scene = heatlens.open("demo", size=(48, 27))
        for method in Method:
            more = {"method": method, "quality": "draft"}
            more |= {"views": 4} if method.needs_scene else {}
            flat = scene.render(level, **more)
            try:
                bent = scene.render(lens, **more)
            except heatlens.HeatlensError as error:
                assert "no bow: use raytraced" in str(error), error
                refused.append(method)
                continue
            assert np.abs(bent - flat).max() > 0.02, method
        assert refused == [Method.ACCUMULATION], refused
        """,
    )


def test_render_command_accepts_option_of_added_term(copy):
    process = run(
        copy,
        """
        from heatlens.fronts.commands.main import main
        words = ["render", "demo", "--size", "48x27", "--bow", "0.5", "-o", "a.exr"]
        assert main([*words, "--method", "accumulation", "--views", "2"]) == 2
        assert not Path("a.exr").exists()
        """,
    )
    assert "no bow: use raytraced" in process.stderr


def test_focus_on_mark_accounts_for_added_term(copy):
    run(
        copy,
        """
        from heatlens.core.model.boxes import Box
        from heatlens.core.model.focus.coc import coc_line, coc_px, focus_offset_coc_px
        from heatlens.media.plate.coc_line import line_of
        from support.evening import LEFT, begin_session, run_until_settled, write_plates
        session = begin_session(folder / "preferences", write_plates(folder))
        run_until_settled(session)
        marks = session.time.marks
        marks.set_point(LEFT)
        session.editing.edit_lens(replace(session.editing.lens, bow_dioptres=0.5))
        marks.focus_on(session.editing.shot.mark_named("A"))
        now, plate = session.editing.lens, session.source.plate
        assert abs(now.focus_distance_m - 2.0) > 0.1, now
        line = line_of(plate, now)
        window, (x, y) = plate.data_window, LEFT
        bow_px = focus_offset_coc_px(line, Box(0, 0, window.width, window.height))
        assert abs(coc_px(2.0, line) + bow_px[y, x]) < 1e-6
        session.close()
        """,
    )


def test_files_store_added_term(copy):
    """Check shots, kits and cameras; for formats of others the term is written or named as lost."""
    run(
        copy,
        """
        from heatlens.media.camera.camera_file import unsupported_notes, read_camera, write_camera
        from heatlens.media.documents.lens_kits import kit_text, read_kit
        from heatlens.media.documents.shot_file import read_shot, write_shot
        from heatlens.core.model.curves.frames import FrameRange
        from heatlens.core.model.lens.lens_kit import KitLens, LensCharacter, LensKit
        from heatlens.core.model.shot.shot import Shot
        from heatlens.render.source.named import camera_of_shot
        write_shot(folder / "a.heatlens.json", Shot(lens))
        assert read_shot(folder / "a.heatlens.json").lens == lens
        kit = LensKit("own", "w", (KitLens(50.0, 1.0, 0.5),), LensCharacter(bow_dioptres=0.2))
        (folder / "own.json").write_text(kit_text(kit))
        assert read_kit(folder / "own.json") == kit
        camera = camera_of_shot(Shot(lens), "cam", FrameRange(1, 2))
        for name in ("cam.csv", "cam.json", "cam.usda"):
            write_camera(folder / name, camera)
        for name in ("cam.csv", "cam.json"):
            assert read_camera(str(folder / name)).opening["bow_dioptres"] == (0.2, 0.2)
        assert "bow" in (folder / "cam.usda").read_text()
        assert "bow" in unsupported_notes("cam.nk", camera)[0]
        """,
    )


def test_python_api_and_panel_have_added_term(copy):
    run(
        copy,
        """
        from imgui_bundle import imgui
        from heatlens.fronts.api.arguments import check_names
        from heatlens.studio.ui import widgets
        from heatlens.studio.ui.panels.opening_panel import opening_panel
        check_names("render", ["bow_dioptres"])
        imgui.create_context()
        io = imgui.get_io()
        io.set_ini_filename("")
        io.display_size = (800, 1600)
        io.backend_flags |= imgui.BackendFlags_.renderer_has_textures
        slider = widgets.slider
        widgets.slider = lambda words, value, *more: (
            slider(words, value, *more), 0.5 if words == "bow" else value)[1]
        for _ in range(2):
            imgui.new_frame()
            imgui.begin("panel")
            after = opening_panel(lens, print, lambda: None)
            imgui.end()
            imgui.render()
        assert after.bow_dioptres == 0.5, after
        """,
    )
