"""The clip of a scene: chosen in its tab, undone, and kept in the shot file."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from imgui_bundle import imgui

from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.shot.framing import ALL_CLIPS, SceneTiming
from heatlens.media.documents.shot_file import read_shot, write_shot
from heatlens.render.gpu.device import Device
from support.gltf_files import GltfWriter
from support.gui import Gui, gui_of
from support.session_files import QUICK


def clips_file(path: Path, names: tuple[str, ...] = ("walk", "run", "run")) -> Path:
    """Write a scene with a square that moves farther and longer in each clip, and 12 still ones."""
    writer = GltfWriter()
    mesh = writer.mesh()
    node = writer.node(name="square", mesh=mesh)
    for index in range(12):
        writer.node(name=f"other {index}", mesh=mesh, translation=[0, 0, -1 - index])
    for index, name in enumerate(names):
        writer.animate(node, "translation", [0, index + 1], [[0, 0, 0], [0.1 * index, 0, 0]])
        writer.json["animations"][-1]["name"] = name
    return writer.write(path)


@pytest.fixture
def gui(ctx: Device, tmp_path) -> Iterator[Gui]:
    scene = clips_file(tmp_path / "clips.glb")
    timing = SceneTiming("walk", 10.0)
    with gui_of(ctx, scene, defocus=QUICK, timing=timing) as gui:
        imgui.set_window_focus("Source")
        gui.frame(3)
        yield gui


def clip_frames_and_travel(gui: Gui) -> tuple[str | None, FrameRange | None, float]:
    """Return the clip and the frames of the shot, and how far the square moves."""
    scene, shot = gui.session.scenes.scene, gui.session.facts.shot
    return shot.framing.timing.clip, shot.frames, scene.transforms_at(scene.frames.last)[0, 0, 3]


def choose(gui: Gui, name: str) -> None:
    gui.click(gui.middle("clip"))
    gui.frame(2)
    gui.click(gui.middle(f"clip: {name}"))


def test_clip_choice_is_undone_and_redone(gui):
    assert clip_frames_and_travel(gui) == ("walk", FrameRange(1, 11), 0.0)
    choose(gui, "run (2)")
    gui.until(lambda: clip_frames_and_travel(gui)[0] == "2", "the other clip")
    assert clip_frames_and_travel(gui) == ("2", FrameRange(1, 21), pytest.approx(0.1))
    assert gui.session.scenes.clips.current_name == "run (2)"
    gui.key(imgui.Key.z, ctrl=True)
    gui.until(lambda: gui.session.scenes.scene.frames.last == 11, "the clip before")
    assert clip_frames_and_travel(gui) == ("walk", FrameRange(1, 11), 0.0)
    gui.key(imgui.Key.z, ctrl=True, shift=True)
    gui.until(lambda: gui.session.scenes.scene.frames.last == 21, "the clip again")
    assert clip_frames_and_travel(gui) == ("2", FrameRange(1, 21), pytest.approx(0.1))


def test_shot_file_keeps_the_clip_and_its_rate(gui, tmp_path):
    choose(gui, ALL_CLIPS)
    gui.until(lambda: clip_frames_and_travel(gui)[0] is None, "all clips")
    assert gui.session.facts.shot.framing.timing == SceneTiming(None, 10.0)
    write_shot(tmp_path / "s.heatlens.json", gui.session.facts.shot)
    saved_shot = read_shot(tmp_path / "s.heatlens.json")
    assert (saved_shot.framing, saved_shot.frames) == (
        gui.session.facts.shot.framing,
        FrameRange(1, 11),
    )  # of two that move one thing the first is played


def test_scene_tab_fits_without_scrolling(gui):
    """With a choice of clips and many objects, the buttons under the list are visible too."""
    window = imgui.internal.find_window_by_name("Source")
    assert "clip" in gui.drawn
    assert gui.rect("mark object")[3] < window.pos.y + window.size.y
    assert not window.scrollbar_y


def test_scene_tab_offers_no_clip_choice_for_one_clip(ctx, tmp_path):
    scene = clips_file(tmp_path / "one.glb", ("walk",))
    with gui_of(ctx, scene, defocus=QUICK) as gui:
        imgui.set_window_focus("Source")
        gui.frame(3)
        assert "camera" in gui.drawn and "clip" not in gui.drawn
