"""A shot with keys and marks, for tests of saving it."""

from dataclasses import replace

from heatlens.core.model.marks.marks import DistanceMark, PointMark
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.shot.shot import Shot

FOCUS = LensParameter.FOCUS_DISTANCE


def with_keys_and_marks(shot: Shot) -> Shot:
    """Return the shot with keys, marks and another blur."""
    shot = shot.with_key(1002, FOCUS, 1.5).with_key(1006, FOCUS, 3.0)
    shot = shot.with_key(1004, LensParameter.F_STOP, 2.8)
    return replace(shot, marks=(DistanceMark("A", 2.5), PointMark("B", 60.0, 32.0)))


def draw_until_saved(gui) -> None:
    """Draw frames until all changes have been autosaved."""
    gui.frame(2)
    gui.until(lambda: not gui.session.files.documents._writes, "the autosave")
