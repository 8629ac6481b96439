"""Keep the state of the timeline panel between frames of the window."""

from dataclasses import dataclass, field

from heatlens.session.keys.key_drag import KeyDrag
from heatlens.session.keys.key_stretch import KeyStretch
from heatlens.session.time.focus_track import FocusTrack
from heatlens.ui.timeline.curve_axis import CurveLine
from heatlens.ui.timeline.scale import TimeScale


@dataclass
class TimelineView:
    """The state of the timeline panel.

    drag          the drag of keys with the mouse
    stretch       the drag of one end of the chosen keys
    scale         the visible frames; None for all
    heights       the visible range of the curve, as places; None to fit the curve
    zoomed        the range that the user zoomed to; None to fit keys
    frames_all    fit marks too, not only keys
    pointed_at    the curve is under the pointer
    height_before the height of the panel before the curve was shown; None without a curve
    line          the points of the curve
    track         the depth of field along the shot, and the frames that are too close
    opens_frames  open the popup about rendered frames in the next frame
    """

    drag: KeyDrag
    stretch: KeyStretch
    scale: TimeScale | None = None
    heights: tuple[float, float] | None = None
    line: CurveLine = field(default_factory=CurveLine)
    track: FocusTrack = field(default_factory=FocusTrack)
    opens_frames: bool = False
    zoomed: tuple[float, float] | None = None
    frames_all: bool = False
    pointed_at: bool = False
    height_before: float | None = None

    def frame_all(self) -> None:
        """Fit keys and marks into the curve editor; a second time, only the keys."""
        self.frames_all = self.zoomed is not None or not self.frames_all
        self.zoomed = None

    def open_frames(self) -> None:
        """Open the popup about rendered frames in the next frame."""
        self.opens_frames = True
