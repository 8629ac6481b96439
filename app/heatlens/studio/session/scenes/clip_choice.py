"""Choose which animation clip of a scene's file plays; a change reads the file again."""

from dataclasses import replace

from heatlens.core.model.shot.framing import Framing, SceneTiming
from heatlens.studio.session.messages import Worker
from heatlens.studio.session.shared import Commands, Shared

ALL_CLIPS = "all at once"


class ClipChoice(Commands, Worker):
    """Chooses a clip, and reads the scene again if the shot needs another clip.

    The choice is part of the shot, so undo, redo and opening a shot file can all change it.
    """

    def __init__(self, shared: Shared) -> None:
        super().__init__(shared)
        self._chosen: SceneTiming | None = None  # the user's choice while it is being read
        self._asked: SceneTiming | None = None  # the timing of the latest attempt to read the file

    @property
    def names(self) -> dict[str, str | None]:
        """The names to choose from, each with its `SceneTiming.clip`; empty if there is no choice.

        If several clips have the same name, their numbers are added to it.
        """
        scene = self._source.scene
        clips = () if scene is None else scene.clips
        if len(clips) < 2:
            return {}
        named: dict[str, str | None] = {ALL_CLIPS: None}
        for number, name in enumerate(clips, 1):
            is_alone = clips.count(name) == 1 and name not in named
            named[name if is_alone else f"{name} ({number})"] = name if is_alone else str(number)
        return named

    @property
    def now(self) -> str:
        """The clip that the shot plays, as one of `names`."""
        clip, names = self._shot_timing.clip, self.names
        if clip is not None and clip.isdecimal() and clip not in names:
            clips = list(names)
            return clips[int(clip)] if 0 < int(clip) < len(clips) else clip
        return next((name for name, value in names.items() if value == clip), clip or ALL_CLIPS)

    @property
    def _shot_timing(self) -> SceneTiming:
        framing = self._editing.shot.framing
        timing = None if framing is None else framing.timing
        return timing or SceneTiming()

    def choose(self, name: str) -> None:
        """Play the clip `name`, one of `names`, once the file has been read with it."""
        timing = replace(self._shot_timing, clip=self.names[name])
        if timing != self._shot_timing:
            self._chosen = timing
            self._read(timing)

    def poll(self) -> None:
        """Read the scene again if the shot needs another clip; call this once a frame."""
        opened = self._source.opened
        if opened is None or not self._source.has_camera:
            return
        if self._source.opener.opening is not None or self._editing.shot.source != opened.text:
            return
        self._chosen = None  # reading it has ended or failed
        wanted, read = self._shot_timing, opened.timing or SceneTiming()
        if wanted == read:
            self._asked = None
        elif wanted != self._asked:  # do not retry a clip that failed
            self._asked = wanted
            self._read(wanted)

    def _read(self, timing: SceneTiming) -> None:
        opened = self._source.opened
        assert opened is not None  # there is a scene
        usual = timing == SceneTiming()
        frame = self._editing.frame
        self._source.opener.open(opened.text, opened.options, frame, None if usual else timing)

    def arrived(self) -> None:
        """Put the clip that the user chose into the shot, with its frames, as one undo step.

        Call this when the scene of the shot has been opened.
        """
        opened, chosen = self._source.opened, self._chosen
        self._chosen = None
        if opened is None or chosen is None or (opened.timing or SceneTiming()) != chosen:
            return
        shot, timing = self._editing.shot, opened.timing
        framing = replace(shot.framing or Framing(), timing=timing)
        self._editing.do(replace(shot, framing=framing, frames=opened.frames))
