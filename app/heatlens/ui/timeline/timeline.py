"""The playhead over the frames: where it is, where it goes, and what is seen meanwhile."""

import math
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Literal

from heatlens.errors import InputError
from heatlens.frame_cache.cache import Direction, FrameCache
from heatlens.model.curve import SAME_FRAME
from heatlens.model.frames import FrameRange
from heatlens.model.shot import LensParameter, Shot
from heatlens.sequence.sequence import MissingPolicy
from heatlens.session.focus_track import FocusTrack, MarkTrack, MarkTracks
from heatlens.session.frame_states import FrameStates, Run
from heatlens.session.key_rows import CAMERA, Row
from heatlens.session.picture_feed import Playhead
from heatlens.session.playback import Playback
from heatlens.ui.panels.mark_commands import MarkCommands
from heatlens.ui.timeline.curve_axis import CurveLine
from heatlens.ui.timeline.key_commands import KeyCommands
from heatlens.ui.timeline.key_hand import KeyHand
from heatlens.ui.timeline.scale import TimeScale
from heatlens.ui.timeline.scene_mark_tracks import SceneMarkTracks

if TYPE_CHECKING:
    from heatlens.ui.app import App

NAME = "Timeline"
# Frames read ahead: two seconds while it plays, a few for the next step by hand.
_AHEAD_PLAYING, _AHEAD_STILL = 48, 8
_STILL_REACH = 100_000  # frames: as far as time can be gone along on a still
_FRAMES_MOST = 1_000_000  # of a shot
_NEXT_SLICE_S = 0.005  # until marks of a scene are measured on: the window answers in between
_BEHIND_S = 0.25  # news of the frames may be told so late


class Timeline:
    """What the timeline does; `timeline_panel` draws it."""

    def __init__(self, app: "App", wake: Callable[[], None] = lambda: None) -> None:
        self._app = app
        self.playback = Playback()
        kept = app.filing.preferences.now
        self.playback.ending, self.playback.is_every_frame = kept.ending, kept.every_frame
        self.missing: MissingPolicy = "hold"
        self.shows_curve = False
        self.curve_of = LensParameter.FOCUS_DISTANCE  # the row whose curve is shown
        self._is_on_camera = False  # its row was chosen after that one
        self.scale: TimeScale | None = None  # the frames that are seen; None: all
        self.keys = KeyCommands(app)
        self.hand = KeyHand(app)
        self.marks = MarkCommands(app, wake)
        self.opens_pull = False  # the popup of the pull, in the next frame
        self.line = CurveLine()
        self.track = FocusTrack()
        self.heights: tuple[float, float] | None = None  # places that the curve shows
        self._mark_tracks = MarkTracks()
        self.scene_mark_tracks = SceneMarkTracks(app)
        self._states = FrameStates()
        self.direction: Literal[1, -1] = 1  # in which it moved last
        self._said = ""

    # What there is

    @property
    def cache(self) -> FrameCache | None:
        """The frames of what is open."""
        opened = self._app.source.opened
        return None if opened is None else opened.cache

    @property
    def is_sequence(self) -> bool:
        """True where more than one frame is open."""
        frames = self._opened_frames
        return frames is not None and frames.count > 1

    @property
    def _opened_frames(self) -> FrameRange | None:
        """The frames of the source as they are now; None for a still."""
        opened = self._app.source.opened
        return None if opened is None else opened.frames

    @property
    def is_shown(self) -> bool:
        """There is something to see on it."""
        return self._app.panels[NAME] and self._app.source.plate is not None and self.has_time

    @property
    def has_time(self) -> bool:
        """There are frames, or keys at frames."""
        return self.is_sequence or bool(self._keyed)

    @property
    def _keyed(self) -> tuple[float, ...]:
        """Where the lens or the camera has a key, in order."""
        shot = self._app.shot
        return tuple(sorted({*shot.key_frames, *shot.camera_key_frames}))

    @property
    def frames(self) -> FrameRange | None:
        """The frames of the source as they are now; for a still, those that its keys span."""
        if self._opened_frames is not None:
            return self._opened_frames
        keyed = self._keyed
        return _range(keyed[0], keyed[-1]) if keyed else None

    @property
    def timed_shot(self) -> Shot:
        """The shot with the frames as they are now."""
        return replace(self._app.shot, frames=self.frames)

    @property
    def played(self) -> FrameRange:
        """From in to out, or all of them."""
        frame = self._app.editing.frame
        return self.timed_shot.played or FrameRange(frame, frame)

    @property
    def reach(self) -> FrameRange:
        """All that a ruler should show: frames, keys and the playhead."""
        frame = self._app.editing.frame
        keyed, frames = self._keyed, self.frames or FrameRange(frame, frame)
        ends = [frames.first, frames.last, frame, *keyed[:1], *keyed[-1:]]
        return _range(min(ends), max(ends))

    @property
    def chosen_row(self) -> Row:
        """That of the camera, while it is seen, or of what has the curve."""
        is_seen = self._app.has_scene and not self.shows_curve
        return CAMERA if self._is_on_camera and is_seen else self.curve_of

    def choose_row(self, row: Row) -> None:
        """Its curve is shown, if it has one."""
        self._is_on_camera = row is CAMERA
        self.curve_of = row if isinstance(row, LensParameter) else self.curve_of

    def runs(self) -> tuple[Run, ...]:
        """How the frames stand."""
        return () if self.cache is None else self._states.runs(self.cache, self._news)

    def mark_tracks(self) -> tuple[MarkTrack, ...]:
        """How far marked things are: of files at the frames in memory, of scenes once measured."""
        if self._app.has_scene:
            return self.scene_mark_tracks.tracks()
        return self._mark_tracks.tracks(self.cache, self.runs(), self._app.shot.marks)

    @property
    def _news(self) -> object:
        source = self._app.source
        return (source.opened.news if source.opened else 0, source.wanted)

    # Going somewhere

    def go(self, frame: int) -> None:
        """Put the playhead on a frame; nothing plays any more."""
        self.playback.stop()
        low, high = -_STILL_REACH, _STILL_REACH
        if self.is_sequence:
            low, high = self.reach.first, self.reach.last
        frame = min(max(frame, low), high)
        self._put(frame)

    def _put(self, frame: int) -> None:
        before = self._app.editing.frame
        if frame != before:
            self._app.editing.frame = frame
            self.direction = 1 if frame > before else -1

    def step(self, frames: int) -> None:
        """So many frames on, or back."""
        self.go(self._app.editing.frame + frames)

    def go_to_end(self, direction: int) -> None:
        """The first (-1) or the last frame that is played."""
        self.go(self.played.last if direction > 0 else self.played.first)

    def go_to_key(self, direction: int) -> None:
        """The next key, or the one before, of any parameter."""
        frame, keyed = self._app.editing.frame, self._keyed
        later = [math.ceil(k) for k in keyed if k > frame + SAME_FRAME]
        earlier = [math.floor(k) for k in keyed if k < frame - SAME_FRAME]
        if direction > 0 and later:
            self.go(later[0])
        elif direction < 0 and earlier:
            self.go(earlier[-1])

    def play(self, direction: int) -> None:
        """Play, or stop what plays in this direction."""
        if self.playback.direction == direction or self.played.count == 1:
            self.playback.stop()
        else:
            frame = self._app.editing.frame
            self._put(self.playback.play(direction, frame, self.played))

    def set_in(self) -> None:
        """Playing and exporting begin here."""
        frame = self._app.editing.frame
        self._set_in_out(frame, max(frame, self.played.last))

    def set_out(self) -> None:
        """They end here."""
        frame = self._app.editing.frame
        self._set_in_out(min(frame, self.played.first), frame)

    def _set_in_out(self, first: int, last: int) -> None:
        frames = FrameRange(first, last)
        whole = frames == self.frames
        self._app.editing.do(replace(self._app.shot, in_out=None if whole else frames))

    def play_all(self) -> None:
        """No in and no out."""
        self._app.editing.do(replace(self._app.shot, in_out=None))

    # What happens by itself

    def open_pull(self) -> None:
        """Ask where to pull the focus to, and how fast."""
        self.opens_pull = True

    def poll(self) -> None:
        """Once a frame of the window: the playhead moves on, and its plate is asked for."""
        app = self._app
        self.marks.poll()
        self.scene_mark_tracks.poll()
        self._show()
        if self.playback.direction:
            now, rate = app.editing.frame, app.shot.frames_per_second
            is_ready = self._is_there(now)
            frame = self.playback.moved(now, self.played, rate, is_ready)
            if frame != now and self._may_play(frame):
                self._put(frame)
                self._show()
        if app.source.problem != self._said:
            self._said = app.source.problem
            if self._said:
                app.say(self._said)

    def _may_play(self, frame: int) -> bool:
        """Where a gap shall stop it, it says so and stays in front of the gap."""
        try:
            if self.cache is not None:
                self.cache.sequence.shown_frame(frame, self.missing)
        except InputError as error:
            self.playback.stop()
            self._app.say(str(error))
            return False
        return True

    def _show(self) -> None:
        if self._app.pull.is_alone:
            return
        is_playing = self.playback.direction != 0
        direction: Direction = 1 if (self.playback.direction or self.direction) >= 0 else -1
        ahead = _AHEAD_PLAYING if is_playing else _AHEAD_STILL
        frame = self._app.editing.frame
        playhead = Playhead(frame, direction, is_playing, ahead, self.missing)
        self._app.source.show(self._app.shot, playhead)

    @property
    def is_due(self) -> bool:
        """A frame of the window is due, for the next frame of the film is."""
        return self._waits_for_nothing and self.playback.is_due(self._app.shot.frames_per_second)

    @property
    def _waits_for_nothing(self) -> bool:
        return self._is_there(self._app.frame) or not self.playback.is_every_frame

    def _is_there(self, frame: int) -> bool:
        """The frame is seen: as it was rendered before, else by its plate."""
        pull = self._app.pull
        if pull.is_alone:
            return pull.is_at_hand(frame)
        return self._app.source.is_settled_at(frame)

    def seconds_until_needed(self) -> float | None:
        """How long the loop may sleep; None: until a plate has been read, or for ever."""
        waits = []
        if self._waits_for_nothing:
            waits.append(self.playback.seconds_until_due(self._app.shot.frames_per_second))
        if self.cache is not None and self.is_shown:
            waits.append(_BEHIND_S if self._states.is_behind(self.cache, self._news) else None)
        if self.scene_mark_tracks.is_due:
            waits.append(_NEXT_SLICE_S)
        known = [wait for wait in waits if wait is not None]
        return min(known) if known else None


def _range(first: float, last: float) -> FrameRange:
    """All frames there, or as many of them as a shot can have: keys in a file may lie anywhere."""
    low = math.floor(first)
    return FrameRange(low, min(math.ceil(last), low + _FRAMES_MOST - 1))
