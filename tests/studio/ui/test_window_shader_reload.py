"""Changed shaders in the running window: a new picture, or a message and the same picture."""

import numpy as np

from support.gui import gui_of
from support.session_files import QUICK, room_file
from support.shader_copies import edit_shader_file, reloading_copy
from support.window_plates import screen_region

LIMITS = "defocus/limits.comp.glsl"


def test_changed_shader_is_reloaded_and_its_errors_are_reported(ctx, tmp_path, monkeypatch):
    shaders = reloading_copy(tmp_path / "shaders", monkeypatch)
    with gui_of(ctx, room_file(tmp_path / "room.exr"), defocus=QUICK) as gui:
        gui.do("1:1")
        gui.settled()
        before = screen_region(gui)
        edit_shader_file(shaders / LIMITS, "max(color.rgb, 0.0)", "max(color.gbr, 0.0)")
        gui.until(
            lambda: "Reloaded defocus/limits.comp.glsl" in gui.session.messages.text,
            "the new shader",
        )
        gui.settled()
        after_change = screen_region(gui)
        assert np.any(after_change != before)
        edit_shader_file(shaders / LIMITS, "color.gbr", "colour.rgb")
        gui.until(lambda: "colour" in gui.session.messages.text, "the mistake")
        assert "defocus/limits.comp.glsl:" in gui.session.messages.text
        gui.settled()
        np.testing.assert_array_equal(screen_region(gui), after_change)
