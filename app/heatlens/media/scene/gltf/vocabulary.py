"""List every property of glTF 2.0 and of the supported extensions, and how it is treated.

Sources: Khronos, glTF 2.0 specification, section 5 (properties reference), and the extensions that
`extensions` lists. Properties in none of these lists are reported to the user by name.

`unread_notes` reports the features that are not drawn, or not as intended, with counts.
"""

from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from fnmatch import fnmatchcase

from heatlens.core.base.outside_text import shortened
from heatlens.media.scene.gltf.file import READ_EXTENSIONS, GltfFile

# Extensions without a visible effect.
UNSEEN_EXTENSIONS = ("KHR_xmp*", "EXT_structural_metadata", "EXT_mesh_features", "KHR_node_select*")
_ANYWHERE = ("name", "extras", "extensions")
_NEAREST = 9728  # the magnification filter NEAREST
_MATERIAL = "KHR_materials_"
_GLASS, _VARIANTS = f"{_MATERIAL}transmission", f"{_MATERIAL}variants"
_LEVELS_MOST = 32

_Lost = Mapping[str, tuple[str, Callable[[object], bool]]]


@dataclass(frozen=True)
class Kind:
    """A kind of object of the JSON.

    read    patterns of properties that are read or have no visible effect
    within  properties that hold objects or lists of objects, and the kind of these
    lost    sentences on properties that are left out, if their value has an effect
    """

    read: tuple[str, ...] = ()
    within: Mapping[str, str] = field(default_factory=dict)
    lost: _Lost = field(default_factory=dict)

    def knows(self, name: str) -> bool:
        """Return whether a property is read or has no effect."""
        return any(fnmatchcase(name, pattern) for pattern in (*_ANYWHERE, *self.read))


def _kind(read: str = "", lost: _Lost | None = None, **within: str) -> Kind:
    return Kind(tuple(read.split()), within, lost or {})


def _always(words: str) -> tuple[str, Callable[[object], bool]]:
    return words, lambda value: True


def _among(words: str, values: tuple[int, ...]) -> tuple[str, Callable[[object], bool]]:
    return words, lambda value: value in values


_HARD = _among("Pictures with nearest-pixel filtering are smoothed", (_NEAREST,))
_ENDLESS = _always("The range of lights is ignored")
_MORE_COLORS = _always("Sets of vertex colours after the first are left out")
_OTHER_SHAPES = _always("Morph targets of colours and texture coordinates are left out")

KINDS = {
    "file": _kind(
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
    "asset": _kind("version minVersion generator copyright"),
    # The minimum and maximum of an accessor follow from its bytes.
    "accessor": _kind(
        "bufferView byteOffset normalized componentType count type max min", sparse="sparse"
    ),
    "sparse": _kind("count", indices="sparse part", values="sparse part"),
    "sparse part": _kind("bufferView byteOffset componentType"),
    "animation": _kind(samplers="keys", channels="channel"),
    "keys": _kind("input output interpolation"),
    "channel": _kind("sampler", target="target"),
    "target": _kind("node path"),
    "buffer": _kind("uri byteLength"),
    "bufferView": _kind("buffer byteOffset byteLength byteStride target"),
    "camera": _kind("type orthographic", perspective="perspective"),
    "perspective": _kind("yfov aspectRatio znear zfar"),
    "image": _kind("uri mimeType bufferView"),
    # Every surface is visible from both sides, as in renderers.
    "material": _kind(
        "alphaMode alphaCutoff emissiveFactor doubleSided",
        pbrMetallicRoughness="metal",
        normalTexture="map",
        occlusionTexture="map",
        emissiveTexture="map",
    ),
    "metal": _kind(
        "baseColorFactor metallicFactor roughnessFactor",
        baseColorTexture="map",
        metallicRoughnessTexture="map",
    ),
    "map": _kind("index texCoord scale strength"),
    "mesh": _kind("weights", primitives="primitive"),
    "primitive": _kind("indices material mode", attributes="attributes", targets="shape"),
    # Applications store their own attributes under names that begin with an underscore.
    "attributes": _kind(
        "POSITION NORMAL TANGENT TEXCOORD_* COLOR_0 JOINTS_* WEIGHTS_* _*",
        {"COLOR_*": _MORE_COLORS},
    ),
    "shape": _kind(
        "POSITION NORMAL TANGENT _*", {"TEXCOORD_*": _OTHER_SHAPES, "COLOR_*": _OTHER_SHAPES}
    ),
    "node": _kind("camera children skin matrix mesh rotation scale translation weights"),
    "sampler": _kind("wrapS wrapT minFilter", {"magFilter": _HARD}),
    "scene": _kind("nodes"),
    "skin": _kind("inverseBindMatrices joints skeleton"),
    "texture": _kind("sampler source"),
    # Extensions; one that belongs to both the file and a node has the properties of both.
    "EXT_mesh_gpu_instancing": _kind(attributes="instances"),
    "instances": _kind("TRANSLATION ROTATION SCALE _*"),
    "EXT_meshopt_compression": _kind(
        "buffer byteOffset byteLength byteStride count mode filter fallback"
    ),
    "EXT_texture_webp": _kind("source"),
    "KHR_animation_pointer": _kind("pointer"),
    "KHR_draco_mesh_compression": _kind("bufferView attributes"),
    "KHR_lights_punctual": _kind("light", lights="light"),
    "light": _kind("type color intensity", {"range": _ENDLESS}, spot="spot"),
    "spot": _kind("innerConeAngle outerConeAngle"),
    "KHR_materials_emissive_strength": _kind("emissiveStrength"),
    "KHR_materials_pbrSpecularGlossiness": _kind(
        "diffuseFactor specularFactor glossinessFactor",
        diffuseTexture="map",
        specularGlossinessTexture="map",
    ),
    "KHR_materials_transmission": _kind("transmissionFactor", transmissionTexture="map"),
    "KHR_materials_unlit": _kind(),
    "KHR_mesh_quantization": _kind(),
    "KHR_node_visibility": _kind("visible"),
    "KHR_texture_basisu": _kind("source"),
    "KHR_texture_transform": _kind("offset rotation scale texCoord"),
}
KINDS["KHR_meshopt_compression"] = KINDS["EXT_meshopt_compression"]


def unread_notes(gltf: GltfFile) -> dict[str, None]:
    """Return sentences on features that are left out or replaced."""
    unread = _Found()
    unread.walk(gltf.root.entry.value, "file")
    notes = [f"{words} ({len(places)})." for words, places in gltf.losses.items()]
    notes += [f"{words} ({count})." for words, count in unread.lost.items()]
    glass = unread.extensions.pop(_GLASS, 0)
    if glass:
        notes.append(f"Glass is drawn as thin panes, which bend no light ({_of(glass)}).")
    if unread.extensions.pop(_VARIANTS, 0):
        notes.append("The default of its material variants is shown.")
    notes += _unread(gltf, unread)
    scenes = gltf.listed("scenes")
    if len(scenes) > 1:
        notes.append(f"Only the default one of its {len(scenes)} scenes is read.")
    return dict.fromkeys(notes)


def _unread(gltf: GltfFile, places: "_Found") -> Iterator[str]:
    """Yield sentences on extensions and properties that are not read at all."""
    unread = {name: count for name, count in places.extensions.items() if not _is_read(name)}
    materials = [
        f"{name.removeprefix(_MATERIAL)} ({_of(count)})"
        for name, count in unread.items()
        if name.startswith(_MATERIAL)
    ]
    others = [f"{n[:60]} ({c})" for n, c in unread.items() if not n.startswith(_MATERIAL)]
    others += [name for name in _promised(gltf) if name not in unread]
    unknown = [f"{name[:60]!r} ({count})" for name, count in places.unknown.items()]
    for words, names in (
        ("Of materials these are left out", materials),
        ("These extensions of the file are not read", others),
        ("These properties are unknown in glTF 2.0 and not read", unknown),
    ):
        if names:
            yield f"{words}: {shortened(names)}."


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
            lost = [words for pattern, words in kind.lost.items() if fnmatchcase(key, pattern)]
            if not lost:
                self.unknown[f"{name}.{key}"] += 1
            self.lost.update(words for words, matters in lost if matters(inner))

    def _extend(self, extensions: object, level: int) -> None:
        for name, inner in extensions.items() if isinstance(extensions, dict) else ():
            self.extensions[name] += 1
            if name in KINDS:
                self.walk(inner, name, level + 1)


def _of(count: int) -> str:
    return "1 material" if count == 1 else f"{count} materials"


def _is_read(name: str) -> bool:
    is_unseen = any(fnmatchcase(name, pattern) for pattern in UNSEEN_EXTENSIONS)
    return name in READ_EXTENSIONS or is_unseen


def _promised(gltf: GltfFile) -> list[str]:
    """Return the names of extensions that the file says it uses, and that are not read."""
    if not gltf.root.has("extensionsUsed"):
        return []
    used = [item.text()[:60] for item in gltf.root.at("extensionsUsed").items()]
    return [name for name in used if not _is_read(name) and name != _VARIANTS]
