"""The folders of the user where heatlens keeps its own files: preferences, cache and reports.

`platformdirs` knows the folders of each system. Environment variables override them:
HEATLENS_CONFIG_DIR, HEATLENS_CACHE_DIR, HEATLENS_RUNTIME_DIR and HEATLENS_LOG_DIR.
`system` is for tests of the other systems.
"""

import os
import sys
import warnings
from collections.abc import Callable
from pathlib import Path

from platformdirs import PlatformDirs
from platformdirs.api import PlatformDirsABC

from heatlens.base.paths import home_dir

_NAME = "heatlens"
_IS_LINUX = sys.platform.startswith("linux")


def preferences_dir(system: type[PlatformDirsABC] = PlatformDirs) -> Path:
    """Return the folder of the preferences; on Linux `~/.config/heatlens`."""
    dirs = system(_NAME, appauthor=False, roaming=True)
    return _chosen("HEATLENS_CONFIG_DIR", lambda: dirs.user_config_dir)


def kits_dir(system: type[PlatformDirsABC] = PlatformDirs) -> Path:
    """Return the folder of the user's own lens kits; on Linux `~/.config/heatlens/kits`."""
    return preferences_dir(system) / "kits"


def rendered_frames_dir(system: type[PlatformDirsABC] = PlatformDirs) -> Path:
    """Return the cache folder of rendered frames; on Linux `~/.cache/heatlens/frames`."""
    dirs = system(_NAME, appauthor=False)
    return _chosen("HEATLENS_CACHE_DIR", lambda: dirs.user_cache_dir) / "frames"


def estimates_dir() -> Path:
    """Return the cache folder of estimated depths, beside that of rendered frames."""
    return rendered_frames_dir().with_name("estimates")


def runtime_dir(system: type[PlatformDirsABC] = PlatformDirs) -> Path:
    """Return the folder for files of a running window; on Linux `/run/user/UID/heatlens`."""
    dirs = system(_NAME, appauthor=False)

    def usual() -> str:
        with warnings.catch_warnings():
            warnings.simplefilter(
                "ignore"
            )  # platformdirs warns if a login has no runtime folder and uses /tmp
            return dirs.user_runtime_dir

    return _chosen("HEATLENS_RUNTIME_DIR", usual)


def reports_dir(system: type[PlatformDirsABC] = PlatformDirs) -> Path:
    """Return the folder of the fault reports; on Linux `~/.local/state/heatlens`."""
    # On Linux platformdirs would add "log", but earlier versions wrote reports one level higher.
    is_plain = system is PlatformDirs and _IS_LINUX
    dirs = system(_NAME, appauthor=False, opinion=not is_plain)
    return _chosen("HEATLENS_LOG_DIR", lambda: dirs.user_log_dir)


def _chosen(variable: str, usual: Callable[[], str]) -> Path:
    """Return the folder that an environment variable names, else the usual one of the system."""
    chosen = os.environ.get(variable)
    if chosen:
        return Path(chosen)
    try:
        return Path(usual())
    except (RuntimeError, OSError):  # no home, as in a container; or others took the folder's name
        return home_dir() / f".{_NAME}"
