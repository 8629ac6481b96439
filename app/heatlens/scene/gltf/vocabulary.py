"""List every property of glTF 2.0 and of the supported extensions, and how it is treated.

Sources: Khronos, glTF 2.0 specification, section 5 (properties reference), and the extensions that
`extensions` lists. Properties in none of these lists are reported to the user by name.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from typing import Any

# Extensions without a visible effect.
UNSEEN_EXTENSIONS = ("KHR_xmp*", "EXT_structural_metadata", "EXT_mesh_features", "KHR_node_select*")
_ANYWHERE = ("name", "extras", "extensions")
_NEAREST = 9728  # the magnification filter NEAREST


@dataclass(frozen=True)
class Kind:
    """A kind of object of the JSON.

    read    patterns of properties that are read or have no visible effect
    within  properties that hold objects or lists of objects, and the kind of these
    lost    sentences on properties that are left out, if their value has an effect
    """

    read: tuple[str, ...] = ()
    within: Mapping[str, str] = field(default_factory=dict)
    lost: Mapping[str, tuple[str, Callable[[object], bool]]] = field(default_factory=dict)

    def knows(self, name: str) -> bool:
        """Return whether a property is read or has no effect."""
        return any(fnmatchcase(name, pattern) for pattern in (*_ANYWHERE, *self.read))


def _kind(read: str = "", lost: Mapping[str, Any] | None = None, **within: str) -> Kind:
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
