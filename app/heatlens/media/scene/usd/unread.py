"""Report the features of a USD stage that are not drawn, or not as intended, with counts."""

import re
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

from heatlens.core.base.outside_text import join_first_names, printable
from heatlens.media.files.usd_library import UsdObject, usd_module
from heatlens.media.scene.usd.stage import UsdStage, kind_of

_PREVIEW_SURFACE = "UsdPreviewSurface"
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
_READER_DEFAULTS: Mapping[str, object] = {
    "scale": (1.0, 1.0, 1.0, 1.0),
    "bias": (0.0, 0.0, 0.0, 0.0),
    "wrapS": "repeat",
    "wrapT": "repeat",
}


@dataclass(frozen=True)
class _Loss:
    """An attribute that is ignored.

    kind        the schema of UsdGeom that has it
    attribute   its name
    words       the note for the user
    has_effect  returns True if the value would change the picture
    """

    kind: str  # a schema of UsdGeom
    attribute: str
    words: str
    has_effect: Callable[[UsdObject], bool]


def _may_vary(attribute: UsdObject) -> bool:
    """Return True if the value may change over time."""
    return bool(attribute.ValueMightBeTimeVarying())


def _has_value(attribute: UsdObject) -> bool:
    """Return True if the file has a value that is not only zeros or ones."""
    value = attribute.Get() if attribute.HasAuthoredValue() else None
    return value is not None and value not in (0, 1) and any(v != 1 for v in _list_values(value))


def _list_values(value: UsdObject) -> list[UsdObject]:
    """Return the items of a list or vector, or a single value as a list."""
    try:
        return list(value)
    except TypeError:
        return [value]


_SHAPES = (
    *("points", "normals", "faceVertexIndices", "widths", "radius", "height", "size", "width"),
    *("length", "radiusTop", "radiusBottom", "primvars:st", "primvars:displayColor"),
)
_CHANGES_NOTE = "Objects whose shape or color changes over time keep their first shape and color"
_FILM_OFFSET_NOTE = "The film offset of cameras is ignored"
_EDGE_RULES_NOTE = (
    "Subdivision surfaces with special edge rules are smoothed with the default rules"
)
_LOSSES = (
    *(_Loss("Gprim", name, _CHANGES_NOTE, _may_vary) for name in _SHAPES),
    _Loss("Gprim", "primvars:displayOpacity", "The opacity of objects is ignored", _has_value),
    _Loss("Camera", "horizontalApertureOffset", _FILM_OFFSET_NOTE, lambda a: bool(a.Get())),
    _Loss("Camera", "verticalApertureOffset", _FILM_OFFSET_NOTE, lambda a: bool(a.Get())),
    _Loss("Camera", "clippingPlanes", "The clipping planes of cameras are ignored", _has_value),
    _Loss("Mesh", "interpolateBoundary", _EDGE_RULES_NOTE, lambda a: a.Get() == "none"),
    _Loss(
        "Imageable",
        "visibility",
        "Objects that appear or vanish over time keep the file's default visibility",
        _may_vary,
    ),
)


def unread_notes(stage: UsdStage, drawable_prims: Iterable[object]) -> list[str]:
    """Return notes on the features of the stage that are not drawn.

    `drawable_prims` are the prims outside instancers, whose materials are examined.
    """
    prims = list(drawable_prims)
    counts = _count_in_prims(stage.prims) + _count_in_materials(prims)
    sentences = [f"{words} ({count})." for words, count in counts.items()]
    lux, skeleton = usd_module("UsdLux"), usd_module("UsdSkel")
    lights = [prim for prim in stage.prims if prim.HasAPI(lux.LightAPI)]
    lists_and_words = (
        (_count_kinds(lights), "Lights of USD are not read, and daylight is used instead: {}."),
        (
            _count_kinds(
                prim
                for prim in stage.prims
                if prim.IsA(skeleton.Skeleton) or prim.IsA(skeleton.BlendShape)
            ),
            "Figures keep the pose in which they were modelled, because these are not read: {}.",
        ),
        (_count_kinds(filter(_is_unknown, stage.prims)), "Not drawn, of unknown kinds: {}."),
        (_missing_files(stage), "The stage refers to files that are missing: {}."),
    )
    return [*sentences, *(words.format(names) for names, words in lists_and_words if names)]


def _count_in_prims(prims: Iterable[UsdObject]) -> Counter[str]:
    """Count the prims with each ignored feature."""
    geometry = usd_module("UsdGeom")
    counts: Counter[str] = Counter()
    for prim in prims:
        kinds = {loss.kind for loss in _LOSSES if prim.IsA(getattr(geometry, loss.kind))}
        prim_losses = {
            loss.words
            for loss in _LOSSES
            if loss.kind in kinds
            and (attribute := prim.GetAttribute(loss.attribute))
            and loss.has_effect(attribute)
        }
        is_guide_or_proxy = prim.IsA(geometry.Gprim) and geometry.Imageable(
            prim
        ).ComputePurpose() in ("guide", "proxy")
        if is_guide_or_proxy:
            prim_losses.add(
                "Guides and proxies, which are not part of a final picture, are not drawn"
            )
        counts.update(sorted(prim_losses))
    return counts


def _count_in_materials(prims: Iterable[UsdObject]) -> Counter[str]:
    """Count the ignored inputs of materials; a material of several prims counts once."""
    shade, geometry = usd_module("UsdShade"), usd_module("UsdGeom")
    surfaces: dict[object, object] = {}
    for prim in prims:
        if prim.IsA(geometry.Gprim) or prim.IsA(geometry.Subset):
            material, _ = shade.MaterialBindingAPI(prim).ComputeBoundMaterial()
            surface = material.ComputeSurfaceSource()[0] if material else None
            if surface:
                surfaces.setdefault(material.GetPath(), surface)
    counts: Counter[str] = Counter()
    for surface in surfaces.values():
        counts.update(sorted(set(_surface_notes(surface))))
    return counts


def _surface_notes(surface: UsdObject) -> Iterable[str]:
    """Yield notes on the inputs of a material's surface that are ignored."""
    if surface.GetIdAttr().Get() != _PREVIEW_SURFACE:
        name = printable(str(surface.GetIdAttr().Get()))[:60]
        yield f"Materials other than {_PREVIEW_SURFACE} are read as far as they match it: {name}"
    for entry in surface.GetInputs():
        name = printable(entry.GetBaseName())
        sources = entry.GetConnectedSources()[0]
        if entry.GetAttr().ValueMightBeTimeVarying():
            yield "Materials that change over time keep their first values"
        if name in _HARMLESS_INPUTS:
            if sources or not _is_default(entry.Get(), _HARMLESS_INPUTS[name]):
                yield f"This input of materials is ignored: {name}"
        elif name not in _READ_INPUTS:
            yield f"This input of materials is ignored: {name[:60]}"
        elif sources and name not in _COLOR_MAPS:
            yield f"Pictures of this input are ignored, and its default value is used: {name}"
        elif sources:
            yield from _reader_notes(sources[0].source.GetPrim())


def _reader_notes(reader: UsdObject) -> Iterable[str]:
    """Yield notes on the settings of a picture reader that are ignored."""
    shade = usd_module("UsdShade").Shader(reader)
    for name, default in _READER_DEFAULTS.items():
        entry = shade.GetInput(name)
        value = entry.Get() if entry else None
        if value is not None and not _is_default(value, default) and value != "useMetadata":
            yield f"This setting of pictures is ignored: {name}"
    coordinate_input = shade.GetInput("st")
    sources = coordinate_input.GetConnectedSources()[0] if coordinate_input else ()
    if sources and "Transform2d" in str(
        usd_module("UsdShade").Shader(sources[0].source.GetPrim()).GetIdAttr().Get()
    ):
        yield "The transforms of pictures are ignored"


def _is_default(value: object, default: object) -> bool:
    """Return True if the value is the default, missing, or without effect (default None)."""
    if value is None or default is None:
        return True
    return (
        value == default
        if not isinstance(default, tuple)
        else tuple(_list_values(value)) == default
    )


def _is_unknown(prim: UsdObject) -> bool:
    """Return True for a prim whose type is unknown to OpenUSD."""
    return bool(prim.GetTypeName()) and not kind_of(prim)


def _count_kinds(prims: Iterable[UsdObject]) -> str:
    """Return how many prims there are of each type, as words."""
    counts = Counter(printable(str(prim.GetTypeName()))[:60] for prim in prims)
    return join_first_names([f"{count} {kind}" for kind, count in sorted(counts.items())])


def _missing_files(stage: UsdStage) -> str:
    """Return the names of layers, references and payloads that could not be opened."""
    messages = map(str, stage.stage.GetCompositionErrors())
    names = (re.search("@([^@]*)@", message) for message in messages)
    return join_first_names(list(dict.fromkeys(repr(printable(m[1])[:80]) for m in names if m)))
