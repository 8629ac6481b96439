"""List the methods that are compared with each other, and their names."""

from dataclasses import replace

from heatlens.model.shot.settings import DefocusSettings, Method

# Numbers of views in the literature, from Haeberli and Akeley 1990 on.
KNOWN_VIEWS = (23, 66)


def entrants(settings: DefocusSettings) -> dict[str, DefocusSettings]:
    """Return the settings of every method by its name, in the order of `Method`.

    The name of a method that averages views contains their number: "accumulation 23".
    """
    found: dict[str, DefocusSettings] = {}
    for method in Method:
        asked = replace(settings, method=method)
        if method.needs_scene:
            found |= {f"{method} {n}": replace(asked, views=n) for n in _views(asked)}
        else:
            found[str(method)] = asked
    return found


def most_views(settings: DefocusSettings) -> int:
    """Return the largest number of views that any method of a bench renders."""
    return max(KNOWN_VIEWS[-1], settings.views)


def _views(settings: DefocusSettings) -> list[int]:
    """Return the numbers of views to measure; for accumulation, those of the literature too."""
    known = KNOWN_VIEWS if settings.method is Method.ACCUMULATION else ()
    return sorted({*known, settings.views})
