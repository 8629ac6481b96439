"""How the timeline is looked at, from one frame of the window to the next."""

from dataclasses import dataclass, field

from heatlens.session.focus_track import FocusTrack
from heatlens.session.key_drag import KeyDrag
from heatlens.session.key_stretch import KeyStretch
from heatlens.ui.timeline.curve_axis import CurveLine
from heatlens.ui.timeline.scale import TimeScale


@dataclass
class TimelineView:
    """What the panel remembers.

    drag          the keys that the mouse has taken hold of
    stretch       the end of the chosen keys that it has taken hold of
    scale         the frames that are seen; None: all
    heights       the lowest and highest place that the curve shows; None: as the curve needs
    line          the curve that is drawn
    track         what is sharp around the focus, and which frames are too close
    opens_frames  the popup about rendered frames opens in the next frame
    """

    drag: KeyDrag
    stretch: KeyStretch
    scale: TimeScale | None = None
    heights: tuple[float, float] | None = None
    line: CurveLine = field(default_factory=CurveLine)
    track: FocusTrack = field(default_factory=FocusTrack)
    opens_frames: bool = False

    def open_frames(self) -> None:
        """Show in the next frame how many rendered frames are kept."""
        self.opens_frames = True
