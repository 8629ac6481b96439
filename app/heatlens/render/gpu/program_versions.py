"""The variants in which a shader is built, by their defines."""

import itertools
from collections.abc import Mapping

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
