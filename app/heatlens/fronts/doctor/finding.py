"""The result of a check, and the error handling that all checks share."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Literal

from heatlens.core.base.errors import HeatlensError

State = Literal["ok", "note", "fault"]


@dataclass(frozen=True)
class Finding:
    """One line of the report.

    state    ok; note: something optional is missing; fault: something is wrong
    said     the result as one sentence or a list, for people
    details  the same and more, as numbers and texts for programs
    """

    name: str
    state: State
    said: str
    details: Mapping[str, object] = field(default_factory=dict)


Check = Callable[[], Iterator[Finding]]


def run_check(name: str, check: Check) -> Iterator[Finding]:
    """Yield the findings of `check`; an error that it raises becomes a finding too."""
    try:
        yield from check()
    except HeatlensError as error:
        yield Finding(name, state="fault", said=str(error))
    except Exception as error:  # drivers and libraries may fail in any way
        yield Finding(name, state="fault", said=f"{type(error).__name__}: {error}")
