"""Show progress in one line of the terminal, which is rewritten and then cleared."""

import io
import os
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext
from typing import TextIO

from heatlens.core.base.pace import Pace, Step
from heatlens.fronts.commands.output.say import print_messages, shows_progress

_CLEAR_LINE = "\r\x1b[K"
_LINE_OF_SPACES = f"\r{'':79}\r"  # for consoles of Windows that show ESC as a sign
_MUCH_LONGER_FACTOR, _MUCH_LONGER_S = (
    1.5,
    5.0,
)  # a time longer by this factor and seconds is printed again


@contextmanager
def progress_line(stream: TextIO | None = None) -> Iterator[Callable[[str], None]]:
    """Yield a function that replaces the text of the line; "" clears it.

    Nothing is shown if `stream` (default stderr) is not a terminal, or with `--quiet`.
    """
    stream_shown = stream or sys.stderr
    if not shows_progress(stream_shown):
        yield lambda _: None
        return
    with _own_stream(stream_shown) as line:
        clear_line = _CLEAR_LINE if _takes_sequences(line) else _LINE_OF_SPACES

        def show(text: str) -> None:
            line.write(f"{clear_line}heatlens: {text}" if text else clear_line)
            line.flush()

        try:
            yield show
        finally:
            show("")


def _takes_sequences(stream: TextIO) -> bool:
    """Return whether the terminal obeys ESC sequences, as all do but old ones of Windows."""
    if sys.platform == "win32":
        from heatlens.core.base.windows_calls import take_sequences

        try:
            return take_sequences(stream.fileno())
        except io.UnsupportedOperation:
            return False
    return True


def _own_stream(stream: TextIO) -> AbstractContextManager[TextIO]:
    """Return a copy of `stream` with a descriptor of its own, or `stream` if it has no descriptor.

    Python's stderr is replaced at times while other threads read files, to hide messages of the EXR
    library.
    """
    try:
        return open(os.dup(stream.fileno()), "w", encoding=stream.encoding, errors=stream.errors)
    except io.UnsupportedOperation:
        return nullcontext(stream)


def time_text(seconds: float) -> str:
    """Return a duration as text, with the precision of an estimate."""
    if seconds < 100:
        return f"{seconds:.0f} s"
    minutes = round(seconds / 60)
    return f"{minutes} min" if minutes < 100 else f"{minutes // 60} h {minutes % 60} min"


@contextmanager
def paced_progress(
    steps: Sequence[Step], clock: Callable[[], float] = time.perf_counter
) -> Iterator[Callable[[str], None]]:
    """Print the expected time, and yield a function to call with the name of each step.

    The time is printed again if the steps so far show that it will be much longer. Texts that are
    not names of steps, such as notes on skipped parts, are printed on lines of their own; ""
    clears the line of the progress.
    """
    pace = Pace(steps, clock)
    printed_s = pace.left_s
    print_messages(f"this takes about {time_text(printed_s)}; Ctrl-C ends it")
    with progress_line() as show:

        def print_time_if_much_longer() -> None:
            """Print the expected time again if it has grown a lot."""
            nonlocal printed_s
            if pace.whole_s > _MUCH_LONGER_FACTOR * printed_s + _MUCH_LONGER_S:
                printed_s = pace.whole_s
                show("")
                print_messages(f"this takes longer here, about {time_text(printed_s)} in all")

        def report_step(sentence: str) -> None:
            """Show a step of the plan with the time left; print any other sentence as a message."""
            if pace.begin_if_step(sentence):
                print_time_if_much_longer()
                position = (
                    f"{pace.number} of {len(pace.steps)}, about {time_text(pace.left_s)} left"
                )
                show(f"{sentence} ({position})")
                return
            show("")
            if sentence:
                print_messages(sentence)

        yield report_step
