"""Read lens kits from files: those that come with heatlens, and the user's own.

A file holds one kit with the fields of `LensKit`, `KitLens` and `LensCharacter`; the path of an
aperture image is relative to the file. The user's own kits are stored beside the preferences.
"""

import json
from dataclasses import dataclass
from pathlib import Path

from heatlens.core.base.errors import InputError
from heatlens.core.base.paths import kits_dir
from heatlens.core.model.lens.lens_kit import KitLens, LensKit
from heatlens.core.model.option import suggest_similar
from heatlens.media.files.json_record import read_json, record_to_json

KIT_VERSION = 1
_VERSION = "heatlens_lens_kit"
_SHIPPED = Path(__file__).with_name("kits")
_FIELDS = {
    "name": str,
    "words": str,
    "lenses": LensKit.__annotations__["lenses"],
    "character": LensKit.__annotations__["character"],
}


@dataclass(frozen=True)
class KitShelf:
    """All available kits.

    kits      by name; a user's kit replaces a shipped one of the same name
    own       the names of the user's own kits
    problems  a sentence for each of the user's files that holds no valid kit
    folder    the folder of the user's kits
    """

    kits: dict[str, LensKit]
    own: frozenset[str]
    problems: tuple[str, ...]
    folder: Path

    def select_kit(self, text: str) -> tuple[LensKit, float | None]:
        """Return the kit for "NAME[:LENGTH]" and the focal length in mm, None if not given.

        Raises InputError if there is no such kit, or it has no lens of this length.
        """
        name, _, length = text.partition(":")
        kit = self.kits.get(name.strip())
        if kit is None:
            hint = f" {self.problems[0]}" if self.problems else ""
            hint += suggest_similar(name.strip(), self.kits)
            raise InputError(
                f"There is no lens kit {name.strip()!r}; there are {', '.join(self.kits)}. "
                f"Put your own kits into {self.folder}.{hint}"
            )
        return kit, None if not length else _parse_kit_length(kit, length)


def kit_shelf(folder: Path | None = None) -> KitShelf:
    """Read all kits; `folder` holds the user's own kits, and None means the default folder."""
    folder = kits_dir() if folder is None else folder
    shipped_kits = [read_kit(path) for path in sorted(_SHIPPED.glob("*.json"))]
    own_kits, problems = [], []
    for path in sorted(folder.glob("*.json")):
        try:
            own_kits.append(read_kit(path))
        except InputError as error:
            problems.append(str(error))
    kits = {kit.name: kit for kit in (*shipped_kits, *own_kits)}
    return KitShelf(kits, frozenset(kit.name for kit in own_kits), tuple(problems), folder)


def read_kit(path: Path) -> LensKit:
    """Read a kit. Raises InputError that names the file and the damaged place in it."""
    from heatlens.media.plate.opening_picture import convert_kit_image, read_relative_image

    document = read_json(path)
    document.check_version(_VERSION, KIT_VERSION, "lens kit")
    entries = document.members([_VERSION, *_FIELDS], ["name", "words", "lenses"])
    values = {n: entries[n].convert(kind) for n, kind in _FIELDS.items() if n in entries}
    kit: LensKit = document.build(LensKit, values)
    try:
        return convert_kit_image(kit, lambda image: read_relative_image(image, path.parent))
    except InputError as error:
        document.refuse(f"the aperture image that it names: {error}")


def kit_text(kit: LensKit) -> str:
    """Return a kit as the text of a file that `read_kit` can read."""
    entries = {_VERSION: KIT_VERSION, **record_to_json(kit)}
    return json.dumps(entries, indent=2, ensure_ascii=False)


def _parse_kit_length(kit: LensKit, text: str) -> float:
    """Parse a focal length in mm, which a lens of the kit must have."""
    try:
        requested_mm = float(text.strip().lower().removesuffix("mm").replace(",", "."))
    except ValueError:
        raise InputError(
            f"{text!r} is not a focal length in mm. Example: "
            f"{kit.name}:{kit.lenses[0].longest_length_mm:g}."
        ) from None
    if not 0 < requested_mm < 1e6:
        raise InputError(f"A focal length must be above 0 mm, not {text}.")
    lens: KitLens = kit.nearest(requested_mm)
    if lens.length_near(requested_mm) != requested_mm:
        raise InputError(kit.missing_length_message(requested_mm))
    return requested_mm
