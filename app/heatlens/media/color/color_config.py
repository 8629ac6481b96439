"""Load the OpenColorIO config: its displays and views, and the default input space for plates.

Plates are scene-linear. Renderers write Rec.709 (sRGB) primaries by default, so that space is the
default input if the config has it.
"""

import os
import re
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from heatlens.core.base.errors import InputError
from heatlens.core.base.extras import ocio
from heatlens.core.base.paths import read_file_bytes, unreadable_error
from heatlens.media.plate.header.entries import FOR_THE_EYE

# The full name, because `ocio://default` differs between versions of the library, which would
# change every picture. This config (ACES 2.0) comes with OpenColorIO 2.5, of VFX Platform 2026.
BUILT_IN = "cg-config-v4.0.0_aces-v2.0_ocio-v2.5"

# Names of linear Rec.709 in configs of ACES 2, the Color Interop Forum, ACES 1, and Blender.
PLAIN_OCIO_VIEW = "Un-tone-mapped"
LINEAR_REC709 = (
    "Linear Rec.709 (sRGB)",
    "lin_rec709_scene",
    "lin_rec709",
    "Utility - Linear - sRGB",
    "Utility - Linear - Rec.709",
    "Linear Rec.709",
    "lin_srgb",
)
_ARCHIVE = b"PK"  # .ocioz
_REPEATED_PREFIX = re.compile(r"^Error: Loading the OCIO profile '.*?' failed\. ")


@dataclass(frozen=True, eq=False)
class ColorConfig:
    """An OpenColorIO config that was read and validated."""

    source: str  # where the config came from, for messages
    config: Any  # PyOpenColorIO.Config

    def displays(self) -> tuple[str, ...]:
        """Return the names of the displays, in the config's order; at least one."""
        return tuple(self.config.getDisplays())

    def views(self, display: str) -> tuple[str, ...]:
        """Return the names of the views of `display`, in the config's order.

        Raises InputError if there is no such display.
        """
        check_known(f"{self.source}: display", display, self.displays())
        return tuple(self.config.getViews(display))

    @property
    def default_display(self) -> str:
        """The display that the config puts first."""
        return str(self.config.getDefaultDisplay())

    @property
    def default_view(self) -> str:
        """The view that the config puts first for its default display.

        A studio's config shows the starting point of its grade, and the built-in one rolls off
        highlights as film does, while the plain curve would clip every bright disc to flat white.
        To compare with a renderer's own window, which uses that plain curve, choose
        "Un-tone-mapped".
        """
        return str(self.config.getDefaultView(self.default_display))

    @property
    def default_input_space(self) -> str:
        """Linear Rec.709 if the config has it, else its role scene_linear. Raises InputError."""
        for name in (*LINEAR_REC709, "scene_linear"):
            space = self.config.getColorSpace(name)
            if space is not None:
                return str(space.getName())
        raise InputError(
            f"{self.source}: it has neither a linear Rec.709 space nor the role scene_linear, so "
            "the plate's colours cannot be interpreted. Add that role."
        )

    def find_space(self, *names: str) -> str | None:
        """Return the first color space with one of `names`.

        A name may be the space's own, an alias or its interop identifier. Returns None where there
        is none, or the space is marked as data.
        """
        for name in names:
            space = self.config.getColorSpace(name) or self._find_by_interop_id(name)
            if space is not None and not space.isData():
                return str(space.getName())
        return None

    def _find_by_interop_id(self, name: str) -> Any:
        """Return the space with this identifier, which configs may give since OpenColorIO 2.5."""
        for space in self.config.getColorSpaces():
            if name and space.getInteropID() == name:
                return space
        return None

    def grading_space(self, input_space: str) -> str:
        """Return the space for grades: the config's role color_timing, else the input space."""
        space = self.config.getColorSpace("color_timing")
        return input_space if space is None else str(space.getName())

    def is_data_view(self, display: str, view: str) -> bool:
        """Return whether a view shows the numbers of a picture as they are."""
        space = self.config.getColorSpace(self.config.getDisplayViewColorSpaceName(display, view))
        return space is not None and bool(space.isData())

    def input_spaces(self) -> tuple[str, ...]:
        """Return the spaces that a scene-linear picture may have, the default first.

        These are the spaces marked as scene-linear; if the config marks none, as before
        OpenColorIO 2, every space that is not data.
        """
        spaces = list(self.config.getColorSpaces())
        linear = [space for space in spaces if space.getEncoding() == "scene-linear"]
        names = [space.getName() for space in linear or spaces if not space.isData()]
        return tuple(dict.fromkeys([self.default_input_space, *names]))


def load_color_config(path: str | None) -> ColorConfig:
    """Load the config at `path`, else the one $OCIO names, else the built-in one.

    `path` may be a .ocio or .ocioz file or an `ocio://` name. Raises InputError if the config is
    missing or broken, or OpenColorIO is not installed.
    """
    address = path or os.environ.get("OCIO")
    if not address:
        return ColorConfig(
            f"built-in {BUILT_IN}", _read_config(f"ocio://{BUILT_IN}", "built-in config")
        )
    source = address if path else f"$OCIO {address}"
    return ColorConfig(source, _read_config(address, source))


def list_config_files(path: Path) -> tuple[Path, ...]:
    """Return the config at `path`, then the files of its transforms that exist."""
    library, config = ocio(), load_color_config(str(path)).config
    files = [path]
    for name in dict.fromkeys(
        name for transform in _all_transforms(config) for name in _table_names(transform)
    ):
        with suppress(library.Exception, library.ExceptionMissingFile):
            files.append(Path(config.getCurrentContext().resolveFileLocation(name)))
    return tuple(files)


def _all_transforms(config: Any) -> Iterator[Any]:
    """Yield every transform of the config, in both directions; some are None."""
    library = ocio()
    for kind, entries in (
        ("COLORSPACE", list(config.getColorSpaces())),
        ("VIEWTRANSFORM", list(config.getViewTransforms())),
    ):
        for direction_name in ("TO", "FROM"):
            direction = getattr(library, f"{kind}_DIR_{direction_name}_REFERENCE")
            yield from (entry.getTransform(direction) for entry in entries)
    for look in config.getLooks():
        yield from (look.getTransform(), look.getInverseTransform())


def _table_names(transform: Any) -> Iterator[str]:
    """Return the names of the files that a transform refers to, alone or as a group."""
    if isinstance(transform, ocio().FileTransform):
        yield transform.getSrc()
    elif isinstance(transform, ocio().GroupTransform):
        for inner in transform:
            yield from _table_names(inner)


def _read_config(address: str, source: str) -> object:
    """Read and check the config at `address`; `source` names it in messages. Raises InputError.

    An error in one of its views appears only when that view is used.
    """
    library = ocio()
    if not address.isprintable():  # bytes of another encoding arrive as surrogates
        raise InputError(f"{source!a}: OpenColorIO accepts only Unicode paths. Rename the file.")
    _check_file(Path(address), source)
    try:
        config = library.Config.CreateFromFile(address)
    except UnicodeDecodeError as error:  # the library cut its message inside a character
        raise InputError(f"{source} is not a usable OpenColorIO config: it is damaged.") from error
    except (library.Exception, library.ExceptionMissingFile) as error:
        raise InputError(
            f"{source} is not a usable OpenColorIO config ({error_text(error)}). Use another one."
        ) from error
    if not config.getDisplays():
        raise InputError(
            f"{source} defines no display, so it cannot show a picture: use another config."
        )
    return config


def _check_file(path: Path, source: str) -> None:
    """Raise InputError for a config that is not UTF-8 text; archives are not checked."""
    if not path.exists():  # OpenColorIO's own name, or a missing file, which the library reports
        return
    try:
        data = read_file_bytes(path)
        if not data.startswith(_ARCHIVE):
            data.decode("utf-8")
    except UnicodeDecodeError as error:
        raise InputError(
            f"{source} is not a usable OpenColorIO config: byte {error.start} is not UTF-8."
        ) from error
    except OSError as error:
        raise unreadable_error(path, error) from error


def error_text(error: Exception) -> str:
    """Return the library's message without line breaks and without the file's name."""
    return _REPEATED_PREFIX.sub("", " ".join(str(error).split())).rstrip(".") + "."


def check_known(kind: str, name: str, known_names: tuple[str, ...]) -> None:
    """Raise InputError, which lists `known_names`, unless `name` is one of them."""
    if name not in known_names:
        raise InputError(f"{kind} {name!r} is not known; there are: {', '.join(known_names)}.")


def default_view(config: ColorConfig, display: str, attributes: Mapping[str, object]) -> str:
    """Return the initial view of a display for a plate whose header has `attributes`.

    This is the first view of the config. A photo is already display-referred, so it gets the view
    without tone mapping, if there is one.
    """
    views = config.views(display)
    if attributes.get(FOR_THE_EYE) and PLAIN_OCIO_VIEW in views:
        return PLAIN_OCIO_VIEW
    return views[0]
