"""Ask for the depth of a picture or movie that was opened without one."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from heatlens.core.model.depth_words import DepthSide
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.render.source.opener import Refused
from heatlens.studio.session.shared import Commands, Shared


class DepthQuestion(Commands):
    """The question where the depth is; each answer opens the picture again with it."""

    def __init__(self, shared: Shared, open_again: Callable[[str, PlateOptions], None]) -> None:
        super().__init__(shared)
        self._open_again = open_again
        self._answered: Refused | None = None  # the failure that the user has answered

    @property
    def _asked(self) -> Refused | None:
        """The failure to ask about: not one of other options for what is open already."""
        failure, opened = self._source.opener.failure, self._source.opened
        is_open = failure is not None and opened is not None and opened.text == failure.text
        if failure is None or failure is self._answered or is_open or not failure.lacks_depth:
            return None
        return failure

    @property
    def name(self) -> str:
        """The name of the picture without depth; "" if there is nothing to ask."""
        return "" if self._asked is None else Path(self._asked.text).name

    def wait_for_file(self) -> None:
        """End the question, because a dialog asks for a file now."""
        self._answered = self._asked

    def use_side(self, side: DepthSide) -> None:
        """Take a half of the picture as its depth."""
        self.wait_for_file()
        self._open(lambda options: replace(options, depth_side=side))

    def use_file(self, path: Path) -> None:
        """Take the depth from a file or a pattern of files."""
        self._open(lambda options: replace(options, depth_source=str(path)))

    def use_network(self, path: Path) -> None:
        """Estimate the depth with a network in an ONNX file."""
        self._open(lambda options: replace(options, depth_model=str(path)))

    def _open(self, change: Callable[[PlateOptions], PlateOptions]) -> None:
        """Open the picture that was asked about with changed options."""
        if self._answered is not None:
            self._open_again(self._answered.text, change(self._answered.options))
