"""What a glTF file holds that is not drawn, or not as it is meant, said once, with its count."""

from collections import Counter

from heatlens.scene.gltf.extensions import READ_EXTENSIONS
from heatlens.scene.gltf.file import GltfFile

_SILENT = ("KHR_xmp", "EXT_structural_metadata", "EXT_mesh_features")  # not for the eye
_MATERIAL = "KHR_materials_"
_GLASS = f"{_MATERIAL}transmission"
_SETS = "variants"  # of materials, which are told for the whole file
_LISTED_MOST = 8


def unread_notes(gltf: GltfFile) -> dict[str, None]:
    """Return sentences on extensions that are left out, and on what stands for another thing."""
    notes: dict[str, None] = {}
    materials = gltf.listed("materials")
    found: Counter[str] = Counter()
    for record in materials:
        found.update(record.inside("extensions").entry.value.keys())
    if found[_GLASS]:
        notes[f"Glass is drawn as thin panes, which bend no light ({_of(found[_GLASS])})."] = None
    coats = {n: c for n, c in found.items() if n.startswith(_MATERIAL) and not _is_read(n)}
    if coats:
        told = (f"{name.removeprefix(_MATERIAL)} ({_of(c)})" for name, c in coats.items())
        notes[f"Of materials these are left out: {_listed(list(told))}."] = None
    if gltf.root.inside("extensions").has(f"{_MATERIAL}{_SETS}"):
        notes["Of the variants of its materials the first look is shown."] = None
    others = [name for name in _used(gltf) if not _is_read(name) and name not in found]
    if others:
        notes[f"These extensions of the file are not read: {_listed(others)}."] = None
    scenes = gltf.listed("scenes")
    if len(scenes) > 1:
        notes[f"Of its {len(scenes)} scenes the one it shows first is read."] = None
    return notes


def _of(count: int) -> str:
    return "1 material" if count == 1 else f"{count} materials"


def _listed(names: list[str]) -> str:
    more = f" and {len(names) - _LISTED_MOST} more" if len(names) > _LISTED_MOST else ""
    return ", ".join(names[:_LISTED_MOST]) + more


def _is_read(name: str) -> bool:
    is_variants = name == f"{_MATERIAL}{_SETS}"
    return name in READ_EXTENSIONS or name.startswith(_SILENT) or is_variants


def _used(gltf: GltfFile) -> list[str]:
    """Return the names of the extensions that the file says it uses."""
    if not gltf.root.has("extensionsUsed"):
        return []
    return [item.text()[:60] for item in gltf.root.at("extensionsUsed").items()]
