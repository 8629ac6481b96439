"""Who takes part where methods are measured against each other, and under which name."""

from dataclasses import replace

from heatlens.model.settings import DefocusSettings, Method

# Numbers of views that pictures in the literature have: Haeberli and Akeley 1990 and after.
KNOWN_VIEWS = (23, 66)


def entrants(settings: DefocusSettings) -> dict[str, DefocusSettings]:
    """Every method by its name, in the order of `Method`, with the settings otherwise given.

    Those that look through many points of the lens say how many: "accumulation 23".
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
    """Points of the lens that the one with the most of them looks through."""
    return max(KNOWN_VIEWS[-1], settings.views)


def _views(settings: DefocusSettings) -> list[int]:
    """Those asked for; of accumulation, which costs as much as it has views, the known ones too."""
    known = KNOWN_VIEWS if settings.method is Method.ACCUMULATION else ()
    return sorted({*known, settings.views})
