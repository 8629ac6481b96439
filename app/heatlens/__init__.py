"""heatlens: depth of field by simulated diffusion, seen live, rendered, or called from Python.

    import heatlens

    plate = heatlens.open("plate.exr")
    picture = plate.render(f_stop=1.4, focus_distance_m=2.24)   # NumPy, (H, W, 4) float32

`heatlens.fronts.api` documents the functions. Modules are loaded only on first use.
"""

TYPE_CHECKING = False  # type checkers know this name; importing `typing` would take milliseconds
if TYPE_CHECKING:
    from heatlens.core.base.errors import HeatlensError, HeatlensWarning
    from heatlens.core.model.lens.lens import Lens
    from heatlens.core.model.shot.settings import DefocusSettings
    from heatlens.core.model.shot.shot import Shot
    from heatlens.fronts.api import Source, open
    from heatlens.version import __version__

__all__ = [
    "DefocusSettings",
    "HeatlensError",
    "HeatlensWarning",
    "Lens",
    "Shot",
    "Source",
    "__version__",
    "open",
]

_HOMES = {
    "DefocusSettings": "heatlens.core.model.shot.settings",
    "HeatlensError": "heatlens.core.base.errors",
    "HeatlensWarning": "heatlens.core.base.errors",
    "Lens": "heatlens.core.model.lens.lens",
    "Shot": "heatlens.core.model.shot.shot",
    "Source": "heatlens.fronts.api",
    "__version__": "heatlens.version",
    "open": "heatlens.fronts.api",
}


def __getattr__(name: str) -> object:
    """Import the home module of `name` on first use, so that `import heatlens` is cheap."""
    import importlib

    if name not in _HOMES:
        raise AttributeError(f"module 'heatlens' has no attribute {name!r}")
    found = globals()[name] = getattr(importlib.import_module(_HOMES[name]), name)
    return found


def __dir__() -> list[str]:
    return sorted(__all__)
