"""Report the features of a glTF file that are not drawn, or not as intended, with counts."""

from collections import Counter
from collections.abc import Iterator
from fnmatch import fnmatchcase

from heatlens.scene.gltf.file import READ_EXTENSIONS, GltfFile
from heatlens.scene.gltf.vocabulary import KINDS, UNSEEN_EXTENSIONS

_MATERIAL = "KHR_materials_"
_GLASS, _VARIANTS = f"{_MATERIAL}transmission", f"{_MATERIAL}variants"
_LISTED_MOST = 8
_LEVELS_MOST = 32


def unread_notes(gltf: GltfFile) -> dict[str, None]:
    """Return sentences on features that are left out or replaced."""
    found = _Found()
    found.walk(gltf.root.entry.value, "file")
    notes = [f"{words} ({len(places)})." for words, places in gltf.losses.items()]
    notes += [f"{words} ({count})." for words, count in found.lost.items()]
    glass = found.extensions.pop(_GLASS, 0)
    if glass:
        notes.append(f"Glass is drawn as thin panes, which bend no light ({_of(glass)}).")
    if found.extensions.pop(_VARIANTS, 0):
        notes.append("The default of its material variants is shown.")
    notes += _unread(gltf, found)
    scenes = gltf.listed("scenes")
    if len(scenes) > 1:
        notes.append(f"Only the default one of its {len(scenes)} scenes is read.")
    return dict.fromkeys(notes)


def _unread(gltf: GltfFile, found: "_Found") -> Iterator[str]:
    """Yield sentences on extensions and properties that are not read at all."""
    unread = {name: count for name, count in found.extensions.items() if not _is_read(name)}
    of_materials = [name for name in unread if name.startswith(_MATERIAL)]
    if of_materials:
        coats = [f"{n.removeprefix(_MATERIAL)} ({_of(unread[n])})" for n in of_materials]
        yield f"Of materials these are left out: {_listed(coats)}."
    others = [f"{n[:60]} ({unread[n]})" for n in unread if n not in of_materials]
    others += [name for name in _promised(gltf) if name not in unread]
    if others:
        yield f"These extensions of the file are not read: {_listed(others)}."
    if found.unknown:
        told = [f"{name[:60]!r} ({count})" for name, count in found.unknown.items()]
        yield f"These properties are unknown in glTF 2.0 and not read: {_listed(told)}."


class _Found:
    """Counts of the parts of a file that are not read.

    extensions  every extension, by name
    lost        sentences on known properties that are left out
    unknown     unknown properties, by the kind of object and their name
    """

    def __init__(self) -> None:
        self.extensions: Counter[str] = Counter()
        self.lost: Counter[str] = Counter()
        self.unknown: Counter[str] = Counter()

    def walk(self, value: object, name: str, level: int = 0) -> None:
        """Count the properties in an object or a list of objects; ignore other values."""
        if level == _LEVELS_MOST:  # deeply nested extensions, which no program writes
            return
        for item in value if isinstance(value, list) else [value]:
            if isinstance(item, dict):
                for key, inner in item.items():
                    self._take(name, key, inner, level)
                self._extend(item.get("extensions"), level)

    def _take(self, name: str, key: str, inner: object, level: int) -> None:
        kind = KINDS[name]
        if key in kind.within:
            self.walk(inner, kind.within[key], level + 1)
        elif not kind.knows(key):
            told = [words for pattern, words in kind.lost.items() if fnmatchcase(key, pattern)]
            if not told:
                self.unknown[f"{name}.{key}"] += 1
            self.lost.update(words for words, matters in told if matters(inner))

    def _extend(self, extensions: object, level: int) -> None:
        for name, inner in extensions.items() if isinstance(extensions, dict) else ():
            self.extensions[name] += 1
            if name in KINDS:
                self.walk(inner, name, level + 1)


def _of(count: int) -> str:
    return "1 material" if count == 1 else f"{count} materials"


def _listed(names: list[str]) -> str:
    more = f" and {len(names) - _LISTED_MOST} more" if len(names) > _LISTED_MOST else ""
    return ", ".join(names[:_LISTED_MOST]) + more


def _is_read(name: str) -> bool:
    is_unseen = any(fnmatchcase(name, pattern) for pattern in UNSEEN_EXTENSIONS)
    return name in READ_EXTENSIONS or is_unseen


def _promised(gltf: GltfFile) -> list[str]:
    """Return the names of extensions that the file says it uses, and that are not read."""
    if not gltf.root.has("extensionsUsed"):
        return []
    used = [item.text()[:60] for item in gltf.root.at("extensionsUsed").items()]
    return [name for name in used if not _is_read(name) and name != _VARIANTS]
