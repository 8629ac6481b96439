"""Choose which animation clip of a scene's file plays; a change reads the file again."""

from dataclasses import replace

from heatlens.core.base.messages import Worker
from heatlens.core.model.shot.framing import ALL_CLIPS, Framing, SceneTiming
from heatlens.studio.session.shared import Commands, Shared


class ClipChoice(Commands, Worker):
    """Chooses a clip, and reads the scene again if the shot needs another clip.

    The choice is part of the shot, so undo, redo and opening a shot file can all change it.
    """

    def __init__(self, shared: Shared) -> None:
        super().__init__(shared)
        self._chosen_timing: SceneTiming | None = None  # the user's choice while it is being read
        self._tried_timing: SceneTiming | None = (
            None  # the timing of the latest attempt to read the file
        )

    @property
    def names(self) -> dict[str, str | None]:
        """The names to choose from, each with its `SceneTiming.clip`; empty if there is no choice.

        If several clips have the same name, their numbers are added to it.
        """
        scene = self._source.scene
        clips = () if scene is None else scene.clips
        if len(clips) < 2:
            return {}
        clips_by_name: dict[str, str | None] = {ALL_CLIPS: None}
        for number, name in enumerate(clips, 1):
            is_unique = clips.count(name) == 1 and name not in clips_by_name
            clips_by_name[name if is_unique else f"{name} ({number})"] = (
                name if is_unique else str(number)
            )
        return clips_by_name

    @property
    def current_name(self) -> str:
        """The clip that the shot plays, as one of `names`."""
        clip, names = self._shot_timing.clip, self.names
        if clip is not None and clip.isdecimal() and clip not in names:
            clips = list(names)
            return clips[int(clip)] if 0 < int(clip) < len(clips) else clip
        return next((name for name, value in names.items() if value == clip), clip or ALL_CLIPS)

    @property
    def _shot_timing(self) -> SceneTiming:
        """The frame rate and clip of the shot; the default if it has none."""
        framing = self._editing.shot.framing
        timing = None if framing is None else framing.timing
        return timing or SceneTiming()

    def choose(self, name: str) -> None:
        """Play the clip `name`, one of `names`, once the file has been read with it."""
        timing = replace(self._shot_timing, clip=self.names[name])
        if timing != self._shot_timing:
            self._chosen_timing = timing
            self._read_scene(timing)

    def poll(self) -> None:
        """Read the scene again if the shot needs another clip; call this once a frame."""
        opened = self._source.opened
        if opened is None or not self._source.has_camera:
            return
        if self._source.opener.opening is not None or self._editing.shot.source != opened.text:
            return
        self._chosen_timing = None  # reading the chosen clip has ended or failed
        shot_timing, read_timing = self._shot_timing, opened.timing or SceneTiming()
        if shot_timing == read_timing:
            self._tried_timing = None
        elif shot_timing != self._tried_timing:  # do not retry a clip that failed
            self._tried_timing = shot_timing
            self._read_scene(shot_timing)

    def _read_scene(self, timing: SceneTiming) -> None:
        """Begin to read the open scene again with another timing."""
        opened = self._source.opened
        assert opened is not None  # there is a scene
        is_default = timing == SceneTiming()
        frame = self._editing.frame
        self._source.opener.open(opened.text, opened.options, frame, None if is_default else timing)

    def apply_choice(self) -> None:
        """Put the clip that the user chose into the shot, with its frames, as one undo step.

        Call this when the scene of the shot has been opened.
        """
        opened, chosen_timing = self._source.opened, self._chosen_timing
        self._chosen_timing = None
        if (
            opened is None
            or chosen_timing is None
            or (opened.timing or SceneTiming()) != chosen_timing
        ):
            return
        shot, timing = self._editing.shot, opened.timing
        framing = replace(shot.framing or Framing(), timing=timing)
        self._editing.do(replace(shot, framing=framing, frames=opened.frames))
