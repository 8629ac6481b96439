"""The variants of a shader, by their defines; each is compiled on first use."""

import itertools
from collections.abc import Callable, Mapping
from typing import Generic, TypeVar

Built = TypeVar("Built")
Defines = Mapping[str, object]


class ProgramVersions(Generic[Built]):
    """The builds of a program, by the defines that are on."""

    def __init__(self, build: Callable[[Defines], Built], defines: Defines | None = None) -> None:
        """Build the version with only `defines`, which is used most."""
        self._build = build
        self._defines = dict(defines or {})
        self._built = {frozenset[str](): build(self._defines)}

    def with_(self, **wanted: bool) -> Built:
        """Return the build in which the defines given as True are 1: `with_(LISTS=True)`."""
        on = frozenset(name for name, is_on in wanted.items() if is_on)
        if on not in self._built:
            self._built[on] = self._build(self._defines | dict.fromkeys(sorted(on), 1))
        return self._built[on]

    @property
    def all(self) -> tuple[Built, ...]:
        """All builds made so far."""
        return tuple(self._built.values())


Variants = tuple[Mapping[str, object], ...]

PLAIN: Variants = ({},)


def either(define: str) -> Variants:
    """Return two variants: without a define and with it."""
    return {}, {define: 1}


def crossed(*choices: Variants) -> Variants:
    """Return every combination of one variant of each of `choices`."""
    return tuple(
        {name: value for one in chosen for name, value in one.items()}
        for chosen in itertools.product(*choices)
    )
