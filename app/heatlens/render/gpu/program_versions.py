"""The variants of a shader, by their defines; each is compiled on first use."""

import itertools
from collections.abc import Callable, Mapping
from typing import Generic, TypeVar

Built = TypeVar("Built")
Defines = Mapping[str, object]


class ProgramVersions(Generic[Built]):
    """The builds of a program, by the defines that are on."""

    def __init__(self, build: Callable[[Defines], Built], defines: Defines | None = None) -> None:
        """Build the version with only `defines` at once; others are built on first use."""
        self._build = build
        self._defines = dict(defines or {})
        self._built = {frozenset[str](): build(self._defines)}

    def version(self, **switches: bool) -> Built:
        """Return the build in which the defines that are True are 1: `version(LISTS=True)`."""
        active = frozenset(name for name, is_on in switches.items() if is_on)
        if active not in self._built:
            self._built[active] = self._build(self._defines | dict.fromkeys(sorted(active), 1))
        return self._built[active]

    @property
    def all(self) -> tuple[Built, ...]:
        """All builds made so far."""
        return tuple(self._built.values())


Variants = tuple[Mapping[str, object], ...]  # the defines of each build of a shader

PLAIN: Variants = ({},)  # one build without defines


def without_and_with(define: str) -> Variants:
    """Return two variants: without a define and with it."""
    return {}, {define: 1}


def combine_variants(*choices: Variants) -> Variants:
    """Return every combination of one variant of each of `choices`."""
    return tuple(
        {name: value for variant in combination for name, value in variant.items()}
        for combination in itertools.product(*choices)
    )
