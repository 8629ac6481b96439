"""List every property of glTF 2.0 and of the supported extensions, and how it is treated.

Sources: Khronos, glTF 2.0 specification, section 5 (properties reference), and the extensions that
`extensions` lists. Properties in none of these lists are reported to the user by name.

`unread_notes` reports the features that are not drawn, or not as intended, with counts.
"""

from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from fnmatch import fnmatchcase

from heatlens.core.base.outside_text import join_first_names
from heatlens.media.scene.gltf.file import READ_EXTENSIONS, GltfFile

# Extensions without a visible effect.
UNSEEN_EXTENSIONS = ("KHR_xmp*", "EXT_structural_metadata", "EXT_mesh_features", "KHR_node_select*")
_ANYWHERE = ("name", "extras", "extensions")
_NEAREST = 9728  # the magnification filter NEAREST
_MATERIAL = "KHR_materials_"
_GLASS, _VARIANTS = f"{_MATERIAL}transmission", f"{_MATERIAL}variants"
_LEVELS_MOST = 32

_Losses = Mapping[str, tuple[str, Callable[[object], bool]]]


@dataclass(frozen=True)
class Kind:
    """A kind of object of the JSON.

    read    patterns of properties that are read or have no visible effect
    within  properties that hold objects or lists of objects, and the kind of these
    lost    sentences on properties that are left out, if their value has an effect
    """

    read: tuple[str, ...] = ()
    within: Mapping[str, str] = field(default_factory=dict)
    lost: _Losses = field(default_factory=dict)

    def knows(self, name: str) -> bool:
        """Return whether a property is read or has no effect."""
        return any(fnmatchcase(name, pattern) for pattern in (*_ANYWHERE, *self.read))


def _make_kind(read: str = "", lost: _Losses | None = None, **within: str) -> Kind:
    """Return a kind; `read` holds patterns separated by spaces."""
    return Kind(read=tuple(read.split()), within=within, lost=lost or {})


def _loses_always(words: str) -> tuple[str, Callable[[object], bool]]:
    """Return a sentence on a property that has an effect with every value."""
    return words, lambda value: True


def _loses_if_among(words: str, values: tuple[int, ...]) -> tuple[str, Callable[[object], bool]]:
    """Return a sentence on a property that has an effect only with some values."""
    return words, lambda value: value in values


_FILTER_LOSS = _loses_if_among("Pictures with nearest-pixel filtering are smoothed", (_NEAREST,))
_RANGE_LOSS = _loses_always("The range of lights is ignored")
_COLOR_SETS_LOSS = _loses_always("Sets of vertex colours after the first are left out")
_SHAPES_LOSS = _loses_always("Morph targets of colours and texture coordinates are left out")

KINDS = {
    "file": _make_kind(
        "scene extensionsUsed extensionsRequired",
        asset="asset",
        accessors="accessor",
        animations="animation",
        buffers="buffer",
        bufferViews="bufferView",
        cameras="camera",
        images="image",
        materials="material",
        meshes="mesh",
        nodes="node",
        samplers="sampler",
        scenes="scene",
        skins="skin",
        textures="texture",
    ),
    "asset": _make_kind("version minVersion generator copyright"),
    # The minimum and maximum of an accessor follow from its bytes.
    "accessor": _make_kind(
        "bufferView byteOffset normalized componentType count type max min", sparse="sparse"
    ),
    "sparse": _make_kind("count", indices="sparse part", values="sparse part"),
    "sparse part": _make_kind("bufferView byteOffset componentType"),
    "animation": _make_kind(samplers="keys", channels="channel"),
    "keys": _make_kind("input output interpolation"),
    "channel": _make_kind("sampler", target="target"),
    "target": _make_kind("node path"),
    "buffer": _make_kind("uri byteLength"),
    "bufferView": _make_kind("buffer byteOffset byteLength byteStride target"),
    "camera": _make_kind("type orthographic", perspective="perspective"),
    "perspective": _make_kind("yfov aspectRatio znear zfar"),
    "image": _make_kind("uri mimeType bufferView"),
    # Every surface is visible from both sides, as in renderers.
    "material": _make_kind(
        "alphaMode alphaCutoff emissiveFactor doubleSided",
        pbrMetallicRoughness="metal",
        normalTexture="map",
        occlusionTexture="map",
        emissiveTexture="map",
    ),
    "metal": _make_kind(
        "baseColorFactor metallicFactor roughnessFactor",
        baseColorTexture="map",
        metallicRoughnessTexture="map",
    ),
    "map": _make_kind("index texCoord scale strength"),
    "mesh": _make_kind("weights", primitives="primitive"),
    "primitive": _make_kind("indices material mode", attributes="attributes", targets="shape"),
    # Applications store their own attributes under names that begin with an underscore.
    "attributes": _make_kind(
        "POSITION NORMAL TANGENT TEXCOORD_* COLOR_0 JOINTS_* WEIGHTS_* _*",
        {"COLOR_*": _COLOR_SETS_LOSS},
    ),
    "shape": _make_kind(
        "POSITION NORMAL TANGENT _*", {"TEXCOORD_*": _SHAPES_LOSS, "COLOR_*": _SHAPES_LOSS}
    ),
    "node": _make_kind("camera children skin matrix mesh rotation scale translation weights"),
    "sampler": _make_kind("wrapS wrapT minFilter", {"magFilter": _FILTER_LOSS}),
    "scene": _make_kind("nodes"),
    "skin": _make_kind("inverseBindMatrices joints skeleton"),
    "texture": _make_kind("sampler source"),
    # Extensions; one that belongs to both the file and a node has the properties of both.
    "EXT_mesh_gpu_instancing": _make_kind(attributes="instances"),
    "instances": _make_kind("TRANSLATION ROTATION SCALE _*"),
    "EXT_meshopt_compression": _make_kind(
        "buffer byteOffset byteLength byteStride count mode filter fallback"
    ),
    "EXT_texture_webp": _make_kind("source"),
    "KHR_animation_pointer": _make_kind("pointer"),
    "KHR_draco_mesh_compression": _make_kind("bufferView attributes"),
    "KHR_lights_punctual": _make_kind("light", lights="light"),
    "light": _make_kind("type color intensity", {"range": _RANGE_LOSS}, spot="spot"),
    "spot": _make_kind("innerConeAngle outerConeAngle"),
    "KHR_materials_emissive_strength": _make_kind("emissiveStrength"),
    "KHR_materials_pbrSpecularGlossiness": _make_kind(
        "diffuseFactor specularFactor glossinessFactor",
        diffuseTexture="map",
        specularGlossinessTexture="map",
    ),
    "KHR_materials_transmission": _make_kind("transmissionFactor", transmissionTexture="map"),
    "KHR_materials_unlit": _make_kind(),
    "KHR_mesh_quantization": _make_kind(),
    "KHR_node_visibility": _make_kind("visible"),
    "KHR_texture_basisu": _make_kind("source"),
    "KHR_texture_transform": _make_kind("offset rotation scale texCoord"),
}
KINDS["KHR_meshopt_compression"] = KINDS["EXT_meshopt_compression"]


def unread_notes(gltf: GltfFile) -> dict[str, None]:
    """Return sentences on features that are left out or replaced."""
    counts = _UnreadCounts()
    counts.walk(gltf.root.entry.value, "file")
    notes = [f"{words} ({len(places)})." for words, places in gltf.losses.items()]
    notes += [f"{words} ({count})." for words, count in counts.lost.items()]
    glass_count = counts.extensions.pop(_GLASS, 0)
    if glass_count:
        notes.append(
            f"Glass is drawn as thin panes, which bend no light ({_count_materials(glass_count)})."
        )
    if counts.extensions.pop(_VARIANTS, 0):
        notes.append("The default of its material variants is shown.")
    notes += _unread_sentences(gltf, counts)
    scenes = gltf.top_level("scenes")
    if len(scenes) > 1:
        notes.append(f"Only the default one of its {len(scenes)} scenes is read.")
    return dict.fromkeys(notes)


def _unread_sentences(gltf: GltfFile, counts: "_UnreadCounts") -> Iterator[str]:
    """Yield sentences on the extensions and properties that are not read at all."""
    unread_extensions = {
        name: count for name, count in counts.extensions.items() if not _is_read(name)
    }
    materials = [
        f"{name.removeprefix(_MATERIAL)} ({_count_materials(count)})"
        for name, count in unread_extensions.items()
        if name.startswith(_MATERIAL)
    ]
    other_extensions = [
        f"{name[:60]} ({count})"
        for name, count in unread_extensions.items()
        if not name.startswith(_MATERIAL)
    ]
    other_extensions += [
        name for name in _list_unread_extensions(gltf) if name not in unread_extensions
    ]
    unknown = [f"{name[:60]!r} ({count})" for name, count in counts.unknown.items()]
    for words, names in (
        ("Of materials these are left out", materials),
        ("These extensions of the file are not read", other_extensions),
        ("These properties are unknown in glTF 2.0 and not read", unknown),
    ):
        if names:
            yield f"{words}: {join_first_names(names)}."


class _UnreadCounts:
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
                for key, inner_value in item.items():
                    self._count_property(name, key, inner_value, level)
                self._count_extensions(item.get("extensions"), level)

    def _count_property(self, name: str, key: str, value: object, level: int) -> None:
        """Count property `key` of an object of kind `name`, and the properties inside its value."""
        kind = KINDS[name]
        if key in kind.within:
            self.walk(value, kind.within[key], level + 1)
        elif not kind.knows(key):
            losses = [words for pattern, words in kind.lost.items() if fnmatchcase(key, pattern)]
            if not losses:
                self.unknown[f"{name}.{key}"] += 1
            self.lost.update(words for words, has_effect in losses if has_effect(value))

    def _count_extensions(self, extensions: object, level: int) -> None:
        """Count the extensions of an object, and the properties inside the known ones."""
        for name, value in extensions.items() if isinstance(extensions, dict) else ():
            self.extensions[name] += 1
            if name in KINDS:
                self.walk(value, name, level + 1)


def _count_materials(count: int) -> str:
    """Return a number of materials as words."""
    return "1 material" if count == 1 else f"{count} materials"


def _is_read(name: str) -> bool:
    """Return True for an extension that is read or has no visible effect."""
    is_unseen = any(fnmatchcase(name, pattern) for pattern in UNSEEN_EXTENSIONS)
    return name in READ_EXTENSIONS or is_unseen


def _list_unread_extensions(gltf: GltfFile) -> list[str]:
    """Return the names of extensions that the file says it uses, and that are not read."""
    if not gltf.root.has("extensionsUsed"):
        return []
    used = [item.text()[:60] for item in gltf.root.entry_at("extensionsUsed").items()]
    return [name for name in used if not _is_read(name) and name != _VARIANTS]
