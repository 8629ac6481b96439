"""Ask about a source that could not be opened; each answer opens it again with other options."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from heatlens.core.base.errors import HeatlensError
from heatlens.core.model.depth_words import DepthSide
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.media.plate.estimate.trusted import UnknownNetworkError, trust
from heatlens.media.plate.header.channel_choice import NoDepthError
from heatlens.render.source.opener import Refused
from heatlens.studio.session.shared import Commands, Shared

_ONE_DISTANCE_M = 3.0  # of everything in a picture that is opened without depth


class OpenQuestion(Commands):
    """A question about a source that could not be opened for a reason of one kind."""

    def __init__(
        self,
        shared: Shared,
        open_again: Callable[[str, PlateOptions], None],
        kind: type[HeatlensError],
    ) -> None:
        super().__init__(shared)
        self._open_again, self._kind = open_again, kind
        self._answered: Refused | None = None  # the failure that the user has answered

    @property
    def _asked(self) -> Refused | None:
        """The failure to ask about: not one of other options for what is open already."""
        failure, opened = self._source.opener.failure, self._source.opened
        is_open = failure is not None and opened is not None and opened.text == failure.text
        if failure is None or failure is self._answered or is_open:
            return None
        return failure if isinstance(failure.error, self._kind) else None

    @property
    def name(self) -> str:
        """The name of the source that was not opened; "" if there is nothing to ask."""
        return "" if self._asked is None else Path(self._asked.text).name

    def end(self) -> None:
        """End the question."""
        self._answered = self._asked

    def _open(self, change: Callable[[PlateOptions], PlateOptions]) -> None:
        """Open the source that was asked about with changed options."""
        if self._answered is not None:
            self._open_again(self._answered.text, change(self._answered.options))


class DepthQuestion(OpenQuestion):
    """The question where the depth of a picture or movie is."""

    def __init__(self, shared: Shared, open_again: Callable[[str, PlateOptions], None]) -> None:
        super().__init__(shared, open_again, NoDepthError)

    def use_no_depth(self) -> None:
        """Open the picture with everything at one distance."""
        self.end()
        self._open(lambda options: replace(options, one_distance_m=_ONE_DISTANCE_M))

    def use_side(self, side: DepthSide) -> None:
        """Take a half of the picture as its depth."""
        self.end()
        self._open(lambda options: replace(options, depth_side=side))

    def use_file(self, path: Path) -> None:
        """Take the depth from a file or a pattern of files."""
        self._open(lambda options: replace(options, depth_source=str(path)))

    def use_network(self, path: Path) -> None:
        """Estimate the depth with a network in an ONNX file, which the user has named so."""
        trust(path)
        self._open(lambda options: replace(options, depth_model=str(path)))


class NetworkQuestion(OpenQuestion):
    """The question whether a network may run that estimates the depth of a shot."""

    def __init__(self, shared: Shared) -> None:
        super().__init__(shared, shared.source.opener.open, UnknownNetworkError)

    @property
    def network(self) -> str:
        """The path of the network; "" if there is nothing to ask."""
        return "" if self._asked is None else self._asked.options.depth_model or ""

    def run_network(self) -> None:
        """Let the network run, now and later."""
        trust(self.network)
        self.end()
        self._open(lambda options: options)
