"""Notices about what is open: each says in a sentence what is missing, and offers answers."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

from heatlens.core.base.messages import window_words
from heatlens.core.model.depth_words import DepthConvention
from heatlens.media.plate.estimate.trusted import UnknownNetworkError
from heatlens.media.plate.header.channel_choice import NoDepthError
from heatlens.media.sequence.sequence import MissingPolicy
from heatlens.render.source.opened import Opened
from heatlens.studio.session.files.open_reel import OpenReel
from heatlens.studio.session.files.plate_reading import PlateReading
from heatlens.studio.session.files.reel_editing import ReelEditing
from heatlens.studio.session.playing.cluster_frames import ClusterFrames
from heatlens.studio.session.shared import Commands, Shared
from heatlens.studio.session.time.timeline import Timeline

_NAMES_MOST = 4  # of what is missing, in a notice
_MISSING_ANSWERS: dict[str, MissingPolicy] = {
    "Hold the frame before": "hold",
    "Show black": "black",
    "Stop there": "stop",
}


@dataclass(frozen=True)
class Answer:
    """An answer to a notice.

    run     what it does
    dialog  the file dialog that it opens, by the key of its purpose; "" for none
    panel   the panel that it brings to the front; "" for none
    """

    words: str
    run: Callable[[], None] = lambda: None
    dialog: str = ""
    panel: str = ""


@dataclass(frozen=True)
class Notice:
    """A sentence about what is open; Enter gives the first answer, and Escape gives none.

    A notice that was answered comes again only with other words, or about something else.
    """

    words: str
    answers: tuple[Answer, ...] = (Answer("OK"),)
    about: object = None


class Notices(Commands):
    """Finds what the user should know about the source, and forgets what was answered."""

    def __init__(
        self,
        shared: Shared,
        timeline: Timeline,
        cluster: ClusterFrames,
        reading: PlateReading,
        reel: OpenReel,
        reel_editing: ReelEditing,
    ) -> None:
        super().__init__(shared)
        self._reel_editing = reel_editing
        self._timeline, self._cluster = timeline, cluster
        self._reading, self._reel = reading, reel
        self._opened: Opened | None = None  # what the answered notices are about
        self._answered: set[tuple[str, object]] = set()

    @property
    def first(self) -> Notice | None:
        """The first notice that was not answered yet; None without one."""
        if self._opened is not self._source.opened:
            self._opened, self._answered = self._source.opened, set()
        present = self._present()
        return next((it for it in present if (it.words, it.about) not in self._answered), None)

    def answer(self, notice: Notice, answer: Answer | None = None) -> None:
        """Follow an answer, if there is one, and show the notice no more."""
        self._answered.add((notice.words, notice.about))
        if answer is not None:
            answer.run()

    def _present(self) -> Iterator[Notice]:
        """Yield the notices that are true now, the most urgent first."""
        yield from self._about_refused_file()
        yield from self._about_stream()
        yield from self._about_media()
        yield from self._about_removed_shot()
        if self._source.plate is not None:
            yield from self._about_depth()
            yield from self._about_frames()
        yield from self._about_scheduler()

    def _about_refused_file(self) -> Iterator[Notice]:
        """Yield why another file than the open one could not be opened, unless a box asks."""
        refused, opened = self._source.opener.failure, self._source.opened
        if refused is None or opened is None or opened.text == refused.text:
            return
        if not isinstance(refused.error, NoDepthError | UnknownNetworkError):
            answers = Answer("Open another...", dialog="open"), Answer("OK")
            yield Notice(window_words(refused.message), answers, refused.error)

    def _about_stream(self) -> Iterator[Notice]:
        """Yield what a renderer sent that cannot be used, and when it has left."""
        stream = self._source.stream
        if stream is None or not stream.is_shown:
            return
        if stream.refusal:
            yield Notice(window_words(stream.refusal), (Answer("Dismiss"),))
        if stream.left_at:
            yield Notice(f"Renderer left at {stream.left_at}. Its last picture stays.")

    def _about_media(self) -> Iterator[Notice]:
        """Yield which shots of the cut have no media."""
        reel = self._reel.reel
        if reel is not None and reel.missing_shots:
            names = _listed([shot.name for shot in reel.missing_shots])
            count = len(reel.missing_shots)
            have = "has" if count == 1 else "have"
            yield Notice(
                f"{count} of {len(reel.shots)} shots {have} no media here: {names}.",
                (Answer("Look in another folder...", dialog="media"), Answer("Go on without")),
            )

    def _about_removed_shot(self) -> Iterator[Notice]:
        """Yield which shot was removed from the reel, which no step of undo brings back."""
        if self._reel_editing.removed is not None:
            name, before = self._reel_editing.removed
            yield Notice(
                f"Removed {name} from the reel; its files stay.",
                (Answer("OK"), Answer("Put it back", self._reel_editing.put_back)),
                id(before),
            )

    def _about_depth(self) -> Iterator[Notice]:
        """Yield how the depth is read, where that is a guess between two likely readings.

        A convention whose ends are guessed too cannot be confirmed by one answer.
        """
        plate = self._source.plate
        if plate is None or not plate.depth.question or not self._reading.is_possible:
            return
        convention = plate.depth.convention
        question, _, _ = window_words(plate.depth.question).partition(" Give ")
        right = Answer(f"{convention.capitalize()} is right", partial(self._keep, convention))
        others = Answer("Change it...", panel="Source"), Answer("Leave it open")
        answers = others if convention.facts.takes_ends else (right, *others)
        yield Notice(f"{question} It is read as {convention} now.", answers)

    def _keep(self, convention: DepthConvention) -> None:
        """Read the depth as it was guessed, from now on without a doubt."""
        reading = self._reading
        reading.change(replace(reading.options, depth_convention=convention))

    def _about_frames(self) -> Iterator[Notice]:
        """Yield which frames of the sequence have no file."""
        cache = self._timeline.cache
        if cache is not None and (missing := cache.sequence.missing):
            count = f"{len(missing)} of {cache.sequence.last - cache.sequence.first + 1}"
            answers = (
                Answer(words, partial(self._show_missing, policy))
                for words, policy in _MISSING_ANSWERS.items()
            )
            yield Notice(f"{count} frames have no file: {_listed(missing)}.", tuple(answers))

    def _show_missing(self, policy: MissingPolicy) -> None:
        self._timeline.missing = policy

    def _about_scheduler(self) -> Iterator[Notice]:
        """Yield that a scheduler answers which the user has not agreed to."""
        if self._cluster.awaits_consent:
            place = self._preferences.values.export_place  # a change of it asks again
            yield Notice(
                f"A scheduler answers at {place.scheduler}. It and its workers would get the names "
                "of your files and send pictures.",
                (Answer("Use this scheduler", self._cluster.agree), Answer("Not now")),
                place,
            )


def _listed(names: Sequence[object]) -> str:
    """Return the first names in a row, and how many more there are."""
    more = len(names) - _NAMES_MOST
    words = ", ".join(str(name) for name in names[:_NAMES_MOST])
    return f"{words} and {more} more" if more > 0 else words
