"""Common interface of all sources: plates, scenes and streams."""

from pathlib import Path

import numpy as np
import pytest

import heatlens
from heatlens.core.base.errors import HeatlensError, InputError
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.marks.marks import PointMark
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.shot.settings import Method
from heatlens.core.model.shot.shot import Shot
from heatlens.deliver.export.job import ExportJob
from heatlens.deliver.export.output import parse_output
from heatlens.deliver.export.plan import plan_export
from heatlens.media.plate.read import read_plate
from heatlens.render.frame_renderer import FrameRenderer
from heatlens.render.source.kinds import PLATES, SCENES, STREAMS, kind_of
from heatlens.render.source.named import single_source, source_named, source_of
from heatlens.render.source.opened import Opening
from heatlens.render.source.opener import SourceOpener
from heatlens.render.source.stream_source import StreamSource
from support.exr_files import write_file
from support.scenes import still_life
from support.session_files import room_file, write_scene

LENS = Lens(50.0, 2.0, 2.0, 36.0)


@pytest.mark.parametrize(
    ("text", "kind"),
    [
        ("demo", SCENES),
        ("a/b.glb", SCENES),
        ("b.usda", SCENES),
        ("shot.####.exr", PLATES),
        ("folder", PLATES),
        ("tev://127.0.0.1:14158", STREAMS),
    ],
)
def test_kind_of_tells_kind_from_name(text, kind, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert kind_of(text) is kind


def test_kind_of_prefers_file_named_demo_to_demo_scene(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    room_file(tmp_path / "demo")
    assert kind_of("demo") is PLATES


def test_sequence_source_has_frames_and_still_has_none(tmp_path):
    for frame in (7, 9):
        room_file(tmp_path / f"shot.{frame:04}.exr", 8, 6)
    still = room_file(tmp_path / "still.exr", 8, 6)
    sequence = source_named(str(tmp_path / "shot.####.exr"))
    assert (sequence.frames.first, sequence.frames.last) == (7, 9)
    assert sequence.frames_of(Shot(LENS)) == (7, 8, 9)
    assert sequence.first_file == tmp_path / "shot.0007.exr"
    assert source_named(str(still)).frames is None
    alone = single_source(tmp_path / "shot.0009.exr", PlateOptions())
    assert alone.first_file == tmp_path / "shot.0009.exr" and alone.frames is None


def test_origin_includes_separate_depth_file(tmp_path):
    image = np.zeros((4, 4), np.float32)
    for frame in (1, 2):
        write_file(tmp_path / f"rgb.{frame:04}.exr", dict.fromkeys("RGB", image))
        write_file(tmp_path / f"depth.{frame:04}.exr", {"Z": image})
    options = PlateOptions(depth_source=str(tmp_path / "depth.####.exr"))
    source = source_named(str(tmp_path / "rgb.####.exr"), options)
    origin = source.origin(Shot(LENS), 2, "stop")
    assert [file.path.name for file in origin.files] == ["rgb.0002.exr", "depth.0002.exr"]
    assert None not in [file.stamp for file in origin.files]
    (tmp_path / "depth.0002.exr").unlink()
    with pytest.raises(InputError, match="depth"):
        source.origin(Shot(LENS), 2, "stop")


def test_plan_export_refuses_to_overwrite_its_depth_file(tmp_path):
    room_file(tmp_path / "rgb.exr", 8, 6)
    depth = room_file(tmp_path / "depth.exr", 8, 6)
    shot = Shot(
        LENS, source=str(tmp_path / "rgb.exr"), plate_options=PlateOptions(depth_source=str(depth))
    )
    plan_export(ExportJob(shot, frames=(1,), output=parse_output(tmp_path / "out.exr")))
    with pytest.raises(InputError, match=r"depth\.exr is an input of this export"):
        plan_export(ExportJob(shot, frames=(1,), output=parse_output(depth)))


def test_scene_source_has_same_files_at_every_frame(tmp_path):
    scene = write_scene(tmp_path / "scene.glb")
    source = source_named(str(scene))
    assert source.origin(Shot(LENS), 3, "stop").files == source.origin(Shot(LENS), 9, "stop").files
    assert [file.path for file in source.origin(Shot(LENS), 3, "stop").files] == [scene]
    assert source.first_file is None and source.span(Shot(LENS)) == source.frames
    scene.unlink()
    with pytest.raises(InputError, match=r"scene\.glb"):
        source.require()


def test_demo_source_has_no_files():
    source = source_named("demo")
    source.require()
    assert source.files is None and source.origin(Shot(LENS), 1, "stop").files == ()


def test_stream_is_refused_as_source_of_a_render():
    stream = StreamSource("127.0.0.1", 0)
    try:
        for open_stream in (
            lambda: source_of(Shot(LENS, source=stream.text)),
            lambda: source_named(stream.text),
            lambda: kind_of(stream.text).open_source(Opening(stream.text, PlateOptions())),
            lambda: heatlens.open(stream.text),
        ):
            with pytest.raises(HeatlensError, match="come from a renderer"):
                open_stream()
    finally:
        stream.close()


def test_source_of_shot_without_source_raises_input_error():
    with pytest.raises(InputError, match="The shot names no plate"):
        source_of(Shot(LENS))


def test_renderer_offers_scene_methods_for_scenes_only(ctx, tmp_path):
    renderer = FrameRenderer(ctx)
    renderer.load(read_plate(room_file(tmp_path / "room.exr", 16, 12)))
    of_plates = set(renderer.methods)
    renderer.load_scene(still_life())
    assert renderer.methods == tuple(Method)
    assert {method for method in Method if method.needs_scene} == set(Method) - of_plates


@pytest.mark.parametrize("kind", ["plates", "scene"])
def test_opened_plates_and_scene_share_interface(tmp_path, kind):
    """Check the interface that the window uses, and that the new shot finds its source again."""
    path = room_file(tmp_path / "a.exr") if kind == "plates" else write_scene(tmp_path / "a.glb")
    opened = _open_source(str(path))
    try:
        shot = opened.shot(opened.lens({"f_stop": 4.0}).lens, Shot(LENS).defocus)
        assert shot.lens.f_stop == 4.0 and shot.source == opened.text == str(path)
        assert source_of(shot).has_many_views is (opened.scene is not None)
        assert (opened.cache is None) is (opened.scene is not None)
        assert Path(opened.render_source.files) == path
    finally:
        opened.close()


def _open_source(text: str):
    opener = SourceOpener(lambda: None)
    opener.open(text, PlateOptions())
    opener._current.wait()
    opened = opener.poll()
    opener.close()
    return opened


def test_distances_m_of_mark_uses_earlier_plate_for_missing_frame(tmp_path):
    for frame, depth_m in ((1001, 2.0), (1002, 3.0), (1004, 5.0)):
        depth = np.full((8, 12), depth_m, np.float32)
        color = {name: np.ones((8, 12), np.float32) for name in "RGB"}
        write_file(tmp_path / f"wall.{frame}.exr", color | {"Z": depth})
    source, progress_lines = source_named(str(tmp_path / "wall.####.exr"), PlateOptions()), []
    distances_m = source.distances_m(Shot(LENS), PointMark("wall", 4, 4), progress_lines.append)
    assert distances_m == pytest.approx({1001: 2.0, 1002: 3.0, 1003: 3.0, 1004: 5.0})
    assert ["wall" in line for line in progress_lines] == [True] * 4 and "1003" in progress_lines[2]
