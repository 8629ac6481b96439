"""Test that a shot file reads back as the shot it was written from."""

import json
import math
import os
import string
from itertools import pairwise

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from heatlens.core.model.curves.curve import Curve, Key
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.curves.interpolation import Ease, Interpolation, Scale
from heatlens.core.model.lens.lens import Lens, LensModel
from heatlens.core.model.marks.marks import DistanceMark, MatteMark, MattePart, PointMark, WorldMark
from heatlens.core.model.marks.track_mark import Click, TrackedPoint, TrackMark
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.shot.settings import Bokeh, DefocusSettings, Method, Quality
from heatlens.core.model.shot.shot import LensCurves, Shot
from heatlens.media.documents.shot_file import read_shot, write_shot
from support.shot_files import FIFTY, FULL, write_shot_in

# Names that a file system takes; the path that a shot brings back is an absolute one.
NAMES = st.text(string.ascii_letters + "#%._- é日", min_size=1, max_size=8).filter(
    lambda name: name.strip(". ")
)
# So slow that no handle reaches far beyond a key, to where there is no lens.
EASES = st.builds(Ease, st.floats(0, 100), st.floats(-1e-6, 1e-6))


def curves_of(values, scale: Scale):
    keys = st.builds(
        Key, st.floats(-1e4, 1e4), values, st.sampled_from(Interpolation), EASES, EASES
    )
    ordered = st.lists(keys, max_size=4, unique_by=lambda key: round(key.frame)).map(
        lambda found: tuple(sorted(found, key=lambda key: key.frame))
    )
    apart = ordered.filter(lambda keys: all(b.frame - a.frame > 0.01 for a, b in pairwise(keys)))
    return st.builds(Curve, apart, st.just(scale))


FOCUS_DISTANCES = st.floats(0.5, 1e6) | st.just(math.inf)
# Focal lengths stay below every focus distance, so that any two keys make a lens.
LENSES = st.builds(
    Lens,
    st.floats(1, 400),
    st.floats(0.5, 64),
    FOCUS_DISTANCES,
    st.floats(1, 100),
    squeeze=st.floats(1, 2),
    t_stop=st.none() | st.floats(0.5, 64),
    acceptable_coc_mm=st.none() | st.floats(0.001, 1),
    close_focus_m=st.none() | st.floats(0.1, 5),
    model=st.sampled_from(list(LensModel)),
    blades=st.sampled_from((0, 3, 16)),
    blade_rotation_deg=st.floats(-360, 360),
    cat_eye=st.floats(0, 1),
    rim=st.floats(-1, 1),
    axial_colour_mm=st.floats(-5, 5),
    widest_f_stop=st.none() | st.floats(0.5, 64),
)
MARK_NAMES = st.text(string.ascii_letters + "äß日", min_size=1, max_size=4)
PLACES = st.just((TrackedPoint(1, 2.5, 3, 4.25, 0.5), TrackedPoint(frame=2, x_px=3.5, y_px=3)))
THINGS = st.builds(MatteMark, MARK_NAMES, st.just("cryptomatte:é"), st.sampled_from(MattePart))
MARKS = (
    THINGS
    | st.builds(WorldMark, MARK_NAMES, *[st.floats(-1e6, 1e6)] * 3)
    | st.builds(TrackMark, MARK_NAMES, st.just((Click(1, 2.5, 3), Click(9, 4, 5))), PLACES)
    | st.builds(DistanceMark, MARK_NAMES, FOCUS_DISTANCES)
    | st.builds(
        PointMark, MARK_NAMES, st.floats(-1e4, 1e4), st.floats(-1e4, 1e4), st.integers(1, 99)
    )
)
FRAME_RANGES = st.builds(
    lambda first, count: FrameRange(first, first + count),
    st.integers(-10_000, 2_000_000),
    st.integers(0, 5000),
)
SHOTS = st.builds(
    Shot,
    LENSES,
    st.builds(
        DefocusSettings,
        st.sampled_from(Bokeh),
        st.sampled_from(Quality),
        st.none() | st.integers(1, 7),
        st.floats(1 / 16, 1),
        st.sampled_from(Method),
    ),
    st.none() | st.lists(NAMES, min_size=1, max_size=3).map(lambda names: "/" + "/".join(names)),
    st.builds(
        PlateOptions,
        st.none() | NAMES,
        st.none() | st.just("") | NAMES,
        st.sampled_from(["auto", "inverse", "coc"]),
        st.sampled_from(["planar", "radial"]),
        st.floats(1e-3, 1e3),
        st.none() | st.floats(0, 10),
    ),
    st.builds(
        LensCurves,
        curves_of(FOCUS_DISTANCES, Scale.RECIPROCAL) | curves_of(st.floats(0.5, 9), Scale.LINEAR),
        curves_of(st.floats(0.5, 64), Scale.LOGARITHMIC),
        curves_of(st.floats(1, 400), Scale.LOGARITHMIC),
        st.just(Curve()) | st.builds(lambda v: Curve((Key(5.5, v),)), st.floats(1, 2)),
    ),
    st.lists(MARKS, max_size=3, unique_by=lambda mark: mark.name).map(tuple),
    st.none() | FRAME_RANGES,
    st.none() | FRAME_RANGES,
    st.floats(1, 1000),
)


@given(SHOTS)
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow])
def test_read_shot_returns_any_written_shot(tmp_path, shot):
    assert read_shot(write_shot_in(shot, tmp_path)) == shot


def test_read_shot_returns_every_entry(tmp_path):
    read_back = read_shot(write_shot_in(FULL, tmp_path))
    assert read_back == FULL
    assert read_back.lens_at(1007.25) == FULL.lens_at(1007.25)


def test_read_shot_fills_missing_entries_with_defaults(tmp_path):
    path = write_shot_in(Shot(FIFTY), tmp_path)
    assert read_shot(path) == Shot(FIFTY)
    path.write_text(
        '{"heatlens_shot": 1, "lens": {"focal_length_mm": 50, "f_stop": 1.3, '
        '"focus_distance_m": 0.94, "sensor_width_mm": 36}}'
    )
    assert read_shot(path) == Shot(FIFTY)


def test_shot_file_has_one_key_or_mark_per_line_with_units_in_names(tmp_path):
    lines = write_shot_in(FULL, tmp_path).read_text("utf-8").splitlines()
    keys = [line.strip() for line in lines if '"frame":' in line]
    assert len(keys) == 4
    assert keys[1] == '{"frame": 1012.5, "value": 1, "interpolation": "hold"},'
    assert keys[2] == '{"frame": 1024, "value": "inf", "interpolation": "smooth"}'
    assert '    {"name": "A", "distance_m": 0.94},' in lines
    assert '    {"name": "Ä", "distance_m": "inf"},' in lines
    assert '    "focal_length_mm": 50,' in lines
    assert lines[1] == '  "heatlens_shot": 1,'


def test_shot_file_stores_source_relative_to_itself(tmp_path):
    first_folder, second_folder = tmp_path / "there", tmp_path / "here"
    for folder in (first_folder, second_folder):
        folder.mkdir()
    path = write_shot_in(Shot(FIFTY, source=str(tmp_path / "plates" / "p.####.exr")), first_folder)
    assert json.loads(path.read_text())["source"] == "../plates/p.####.exr"
    (second_folder / path.name).write_bytes(path.read_bytes())
    moved = read_shot(second_folder / path.name)
    assert moved.source == str(tmp_path / "plates" / "p.####.exr")
    local_path = write_shot_in(Shot(FIFTY, source=str(first_folder / "p.####.exr")), first_folder)
    (second_folder / path.name).write_bytes(local_path.read_bytes())
    assert read_shot(second_folder / path.name).source == str(second_folder / "p.####.exr")


def test_write_shot_resolves_source_in_working_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write_shot("s.heatlens.json", Shot(FIFTY, source="plates/p.####.exr"))
    monkeypatch.chdir(tmp_path.parent)
    shot = read_shot(tmp_path / "s.heatlens.json")
    assert shot.source == str(tmp_path / "plates" / "p.####.exr")


def test_read_shot_returns_source_name_that_is_no_unicode(tmp_path):
    shot = Shot(FIFTY, source=str(tmp_path / os.fsdecode(b"pl\xe4te.exr")))
    assert read_shot(write_shot_in(shot, tmp_path)) == shot


def test_read_shot_accepts_byte_order_mark(tmp_path):
    path = write_shot_in(FULL, tmp_path)
    path.write_bytes(b"\xef\xbb\xbf" + path.read_bytes())
    assert read_shot(path) == FULL


def test_read_shot_of_earlier_version_has_photographic_lens(tmp_path):
    """Files without an entry for the lens model are from versions that had only this one."""
    path = tmp_path / "old.heatlens.json"
    lens = {"focal_length_mm": 50, "f_stop": 2, "focus_distance_m": 1.1, "sensor_width_mm": 36}
    path.write_text(json.dumps({"heatlens_shot": 1, "lens": lens}))
    assert read_shot(path).lens == Lens(50, 2, 1.1, 36, model=LensModel.PHOTOGRAPHIC)
