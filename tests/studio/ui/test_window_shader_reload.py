"""Changed shaders in the running window: another picture, or a sentence and the same picture."""

import numpy as np

from support.gui import gui_of
from support.session_files import QUICK, room_file
from support.shader_copies import edit, reloading_copy
from support.window_plates import region

LIMITS = "defocus/limits.comp.glsl"


def test_a_changed_shader_changes_the_picture_and_a_mistake_is_said(ctx, tmp_path, monkeypatch):
    shaders = reloading_copy(tmp_path / "shaders", monkeypatch)
    with gui_of(ctx, room_file(tmp_path / "room.exr"), defocus=QUICK) as gui:
        gui.do("1:1")
        gui.settled()
        before = region(gui)
        edit(shaders / LIMITS, "max(color.rgb, 0.0)", "max(color.gbr, 0.0)")
        gui.until(
            lambda: "Reloaded defocus/limits.comp.glsl" in gui.session.messages.text,
            "the new shader",
        )
        gui.settled()
        turned = region(gui)
        assert np.any(turned != before)
        edit(shaders / LIMITS, "color.gbr", "colour.rgb")
        gui.until(lambda: "colour" in gui.session.messages.text, "the mistake")
        assert "defocus/limits.comp.glsl:" in gui.session.messages.text
        gui.settled()
        np.testing.assert_array_equal(region(gui), turned)
