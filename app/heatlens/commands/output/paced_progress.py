"""Show the progress of planned work and the time left."""

import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager

from heatlens.commands.output.progress_line import progress_line, time_text
from heatlens.commands.output.say import say
from heatlens.measure.bench.schedule import Pace, Step


@contextmanager
def paced_progress(
    steps: Sequence[Step], clock: Callable[[], float] = time.perf_counter
) -> Iterator[Callable[[str], None]]:
    """Print the expected time, and yield a function to call with the sentence of each step.

    Sentences that are not in the plan, such as notes on skipped parts, stay on their own lines; ""
    clears the line of the progress.
    """
    pace = Pace(steps, clock)
    say(f"this takes about {time_text(pace.left_s)}; Ctrl-C ends it")
    with progress_line() as show:

        def tell(sentence: str) -> None:
            if pace.begin(sentence):
                where = f"{pace.number} of {len(pace.steps)}, about {time_text(pace.left_s)} left"
                show(f"{sentence} ({where})")
                return
            show("")
            say(*filter(None, [sentence]))

        yield tell
