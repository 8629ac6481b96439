"""Report the features of a USD stage that are not drawn, or not as intended, with counts."""

import re
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

from heatlens.core.base.outside_text import printable, shortened
from heatlens.media.files.usd_library import UsdObject, usd_module
from heatlens.media.scene.usd.stage import UsdStage, kind_of

_PREVIEW = "UsdPreviewSurface"
# Inputs of UsdPreviewSurface that are read, and those whose given values change nothing.
_READ_INPUTS = (
    *("diffuseColor", "emissiveColor", "opacity", "opacityThreshold", "metallic", "roughness"),
    "opacityMode",
)
_HARMLESS_INPUTS: Mapping[str, object] = {
    "useSpecularWorkflow": 0,
    "specularColor": None,  # only has an effect in the specular workflow
    "clearcoat": 0.0,
    "clearcoatRoughness": None,  # only has an effect with clearcoat
    "ior": 1.5,
    "normal": (0.0, 0.0, 1.0),
    "displacement": 0.0,
    "occlusion": 1.0,
}
_COLOR_MAPS = ("diffuseColor", "emissiveColor")
_PLAIN_READER: Mapping[str, object] = {
    "scale": (1.0, 1.0, 1.0, 1.0),
    "bias": (0.0, 0.0, 0.0, 0.0),
    "wrapS": "repeat",
    "wrapT": "repeat",
}


@dataclass(frozen=True)
class _Loss:
    """An attribute of prims that is ignored: where it is, the note, and when it matters."""

    kind: str  # a schema of UsdGeom
    attribute: str
    words: str
    matters: Callable[[UsdObject], bool]


def _varies(attribute: UsdObject) -> bool:
    return bool(attribute.ValueMightBeTimeVarying())


def _has_value(attribute: UsdObject) -> bool:
    """Return True if the file has a value, and not only zeros or ones."""
    value = attribute.Get() if attribute.HasAuthoredValue() else None
    return value is not None and value not in (0, 1) and any(v != 1 for v in _flat(value))


def _flat(value: UsdObject) -> list[UsdObject]:
    try:
        return list(value)
    except TypeError:
        return [value]


_SHAPES = (
    *("points", "normals", "faceVertexIndices", "widths", "radius", "height", "size", "width"),
    *("length", "radiusTop", "radiusBottom", "primvars:st", "primvars:displayColor"),
)
_CHANGES = "Objects whose shape or color changes over time keep their first shape and color"
_SHIFTED = "The film offset of cameras is ignored"
_EDGES = "Subdivision surfaces with special edge rules are smoothed with the default rules"
_LOSSES = (
    *(_Loss("Gprim", name, _CHANGES, _varies) for name in _SHAPES),
    _Loss("Gprim", "primvars:displayOpacity", "The opacity of objects is ignored", _has_value),
    _Loss("Camera", "horizontalApertureOffset", _SHIFTED, lambda a: bool(a.Get())),
    _Loss("Camera", "verticalApertureOffset", _SHIFTED, lambda a: bool(a.Get())),
    _Loss("Camera", "clippingPlanes", "The clipping planes of cameras are ignored", _has_value),
    _Loss("Mesh", "interpolateBoundary", _EDGES, lambda a: a.Get() == "none"),
    _Loss(
        "Imageable",
        "visibility",
        "Objects that appear or vanish over time keep the file's default visibility",
        _varies,
    ),
)


def unread_notes(stage: UsdStage, shown: Iterable[object]) -> list[str]:
    """Return notes on what of the stage is not drawn; `shown` are the prims that could be drawn."""
    prims = list(shown)
    counted = _of_prims(stage.prims) + _of_materials(prims)
    sentences = [f"{words} ({count})." for words, count in counted.items()]
    lux, skeleton = usd_module("UsdLux"), usd_module("UsdSkel")
    lights = [p for p in stage.prims if p.HasAPI(lux.LightAPI)]
    named = (
        (_kinds(lights), "Lights of USD are not read, and daylight is used instead: {}."),
        (
            _kinds(
                p for p in stage.prims if p.IsA(skeleton.Skeleton) or p.IsA(skeleton.BlendShape)
            ),
            "Figures keep the pose in which they were modelled, because these are not read: {}.",
        ),
        (_kinds(filter(_is_unknown, stage.prims)), "Not drawn, of unknown kinds: {}."),
        (_missing(stage), "The stage refers to files that are missing: {}."),
    )
    return [*sentences, *(words.format(names) for names, words in named if names)]


def _of_prims(prims: Iterable[UsdObject]) -> Counter[str]:
    geometry = usd_module("UsdGeom")
    counts: Counter[str] = Counter()
    for prim in prims:
        kinds = {loss.kind for loss in _LOSSES if prim.IsA(getattr(geometry, loss.kind))}
        own = {
            loss.words
            for loss in _LOSSES
            if loss.kind in kinds
            and (attribute := prim.GetAttribute(loss.attribute))
            and loss.matters(attribute)
        }
        is_stand_in = prim.IsA(geometry.Gprim) and geometry.Imageable(prim).ComputePurpose() in (
            "guide",
            "proxy",
        )
        if is_stand_in:
            own.add("Guides and proxies, which are not part of a final picture, are not drawn")
        counts.update(sorted(own))
    return counts


def _of_materials(prims: Iterable[UsdObject]) -> Counter[str]:
    """Count the ignored inputs of materials; a material of several prims counts once."""
    shade, geometry = usd_module("UsdShade"), usd_module("UsdGeom")
    bound: dict[object, object] = {}
    for prim in prims:
        if prim.IsA(geometry.Gprim) or prim.IsA(geometry.Subset):
            material, _ = shade.MaterialBindingAPI(prim).ComputeBoundMaterial()
            surface = material.ComputeSurfaceSource()[0] if material else None
            if surface:
                bound.setdefault(material.GetPath(), surface)
    counts: Counter[str] = Counter()
    for surface in bound.values():
        counts.update(sorted(set(_of_surface(surface))))
    return counts


def _of_surface(surface: UsdObject) -> Iterable[str]:
    if surface.GetIdAttr().Get() != _PREVIEW:
        name = printable(str(surface.GetIdAttr().Get()))[:60]
        yield f"Materials other than {_PREVIEW} are read as far as they match it: {name}"
    for entry in surface.GetInputs():
        name = printable(entry.GetBaseName())
        sources = entry.GetConnectedSources()[0]
        if entry.GetAttr().ValueMightBeTimeVarying():
            yield "Materials that change over time keep their first values"
        if name in _HARMLESS_INPUTS:
            if sources or not _is_like(entry.Get(), _HARMLESS_INPUTS[name]):
                yield f"This input of materials is ignored: {name}"
        elif name not in _READ_INPUTS:
            yield f"This input of materials is ignored: {name[:60]}"
        elif sources and name not in _COLOR_MAPS:
            yield f"Pictures of this input are ignored, and its default value is used: {name}"
        elif sources:
            yield from _of_reader(sources[0].source.GetPrim())


def _of_reader(reader: UsdObject) -> Iterable[str]:
    """Yield notes on the settings of a picture reader that are ignored."""
    shade = usd_module("UsdShade").Shader(reader)
    for name, plain in _PLAIN_READER.items():
        entry = shade.GetInput(name)
        value = entry.Get() if entry else None
        if value is not None and not _is_like(value, plain) and value != "useMetadata":
            yield f"This setting of pictures is ignored: {name}"
    place = shade.GetInput("st")
    sources = place.GetConnectedSources()[0] if place else ()
    if sources and "Transform2d" in str(
        usd_module("UsdShade").Shader(sources[0].source.GetPrim()).GetIdAttr().Get()
    ):
        yield "The transforms of pictures are ignored"


def _is_like(value: object, plain: object) -> bool:
    if value is None or plain is None:
        return True
    return value == plain if not isinstance(plain, tuple) else tuple(_flat(value)) == plain


def _is_unknown(prim: UsdObject) -> bool:
    return bool(prim.GetTypeName()) and not kind_of(prim)


def _kinds(prims: Iterable[UsdObject]) -> str:
    """Return how many prims there are of each type, as words."""
    counts = Counter(printable(str(prim.GetTypeName()))[:60] for prim in prims)
    return shortened([f"{count} {kind}" for kind, count in sorted(counts.items())])


def _missing(stage: UsdStage) -> str:
    """Return the names of layers, references and payloads that could not be opened."""
    said = map(str, stage.stage.GetCompositionErrors())
    names = (re.search("@([^@]*)@", words) for words in said)
    return shortened(list(dict.fromkeys(repr(printable(m[1])[:80]) for m in names if m)))
