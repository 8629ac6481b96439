"""A shot with every entry, and its file, for tests of shot files."""

import math
from dataclasses import replace
from pathlib import Path

import pytest

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.curve import Curve, Key
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.curves.interpolation import Ease, Interpolation, Scale
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.marks.marks import DistanceMark, PointMark
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.shot.settings import Bokeh, DefocusSettings, Method, Quality
from heatlens.core.model.shot.shot import LensCurves, Shot
from heatlens.media.documents.shot_file import read_shot, write_shot

FIFTY = Lens(50.0, 1.3, 0.94, 36.0)
FULL = Shot(
    lens=replace(FIFTY, t_stop=1.5, close_focus_m=0.45),
    defocus=DefocusSettings(Bokeh.HEAT, Quality.DRAFT, 3, 0.5, Method.SCATTER),
    source="/shots/s1/plate.####.exr",
    plate_options=PlateOptions("Z", "", "normalized", "radial", 0.01, 0.1, 100.0, 50.0, 36.0),
    curves=LensCurves(
        Curve(
            (
                Key(1001, 0.94, Interpolation.BEZIER, Ease(80.0, -0.01), Ease()),
                Key(frame=1012.5, value=1.0, interpolation=Interpolation.HOLD),
                Key(1024, math.inf),
            ),
            Scale.RECIPROCAL,
        ),
        f_stop=Curve((Key(1010, 2.8, Interpolation.LINEAR),), Scale.LOGARITHMIC),
    ),
    marks=(DistanceMark("A", 0.94), DistanceMark("Ä", math.inf), PointMark("B", 960.5, 540.0, 5)),
    frames=FrameRange(1001, 1024),
    in_out=FrameRange(1005, 1020),
    frames_per_second=24000 / 1001,
)


def write_shot_in(shot: Shot, folder: Path) -> Path:
    path = folder / "s.heatlens.json"
    write_shot(path, shot)
    return path


def refusal(path: Path, text: str | bytes) -> str:
    """Write `text` to a shot file that must be refused. Return the error message."""
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(InputError) as error:
        read_shot(path)
    return str(error.value)
