"""Declare in which variants a shader is built: the defines of each build."""

import itertools
from collections.abc import Mapping

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
