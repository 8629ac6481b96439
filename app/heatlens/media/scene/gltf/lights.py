"""Read the lights of a glTF file, and scale them to a suitable exposure.

Source: Khronos, KHR_lights_punctual. Its units are candela and lux, in which daylight is a hundred
thousand times too bright for a picture: see `GltfLights.scale_to_exposure`.
"""

import math
from dataclasses import dataclass, field, replace

import numpy as np

from heatlens.media.scene.gltf.animation import Animation
from heatlens.media.scene.gltf.file import GltfFile
from heatlens.media.scene.gltf.json_values import Record
from heatlens.media.scene.material import Color
from heatlens.media.scene.scene import Array, Daylight, Lighting, PointLight

# Blender multiplies its watts by 683, the lumens of a watt of green light, for lux and candela.
_LUMENS_OF_WATT = 683.0
_BLENDER_GENERATOR = "Khronos glTF Blender I/O"
# The irradiance that a picture is exposed for, and the one above which lights are scaled to it.
_TARGET_IRRADIANCE, _TOO_BRIGHT = 3.0, 30.0
_LAMPS_MOST = 32
_FAR_MOST_M = 1e9
_NIGHT = (0.0, 0.0, 0.0)


@dataclass(frozen=True, eq=False)
class MovingLights:
    """Lights on nodes, some of which move.

    lighting  the lights at the first frame
    nodes     the node of each lamp
    sun_node  the node of the sun, None for the default sun of a scene without one
    """

    animation: Animation
    lighting: Lighting
    nodes: tuple[int, ...]
    sun_node: int | None

    def __call__(self, frame: float) -> Lighting:
        """Return the lights at a frame; one without a direction keeps its first direction."""
        worlds = self.animation.worlds(frame)
        pairs = zip(self.lighting.lights, self.nodes, strict=True)
        lamps = tuple(_move_lamp(lamp, worlds[node]) for lamp, node in pairs)
        daylight = self.lighting.daylight
        axis = None if self.sun_node is None else _light_direction(worlds[self.sun_node])
        if axis is not None:
            daylight = replace(daylight, to_sun=(-axis[0], -axis[1], -axis[2]))
        return Lighting(lamps, daylight)


@dataclass
class GltfLights:
    """The lights on the nodes of the scene, with the intensities of the file.

    Raises InputError for a light with an impossible position or values.
    """

    gltf: GltfFile
    animation: Animation
    lights: list[PointLight] = field(default_factory=list)
    daylight: Daylight = field(default_factory=Daylight)
    notes: dict[str, None] = field(default_factory=dict)  # in order, each once
    _sun_count: int = 0
    _sun_node: int | None = None
    _nodes: list[int] = field(default_factory=list)  # nodes of the lamps

    def __post_init__(self) -> None:
        tree = self.animation.tree
        light_records = self.gltf.root.object_at("extensions", "KHR_lights_punctual").records(
            "lights"
        )
        worlds = self.animation.worlds(self.animation.first_frame)
        for node in tree.scene_nodes:
            extension = tree.records[node].object_at("extensions", "KHR_lights_punctual")
            light = extension.index("light", len(light_records))
            if light is not None and node not in tree.hidden:
                self._add_light(node, light_records[light], worlds[node])
        if self.lights and not self._sun_count:
            self.daylight = replace(self.daylight, sun=_NIGHT)

    @property
    def is_blender(self) -> bool:
        """Whether Blender wrote the file."""
        return self.gltf.root.object_at("asset").text("generator").startswith(_BLENDER_GENERATOR)

    def _add_light(self, node: int, light: Record, world: Array) -> None:
        """Add a lamp or a sun on a node, whose matrix (4, 4) to the world is `world`."""
        kind, axis = light.text("type"), _light_direction(world)
        if axis is None or not np.abs(world[:3, 3]).max() <= _FAR_MOST_M:
            light.refuse("a light is scaled to zero, or its place is not finite")
        color, (x, y, z) = _read_intensity(light), axis
        if kind == "directional":
            self._add_sun(node, (-x, -y, -z), color)
            return
        if kind not in ("point", "spot"):
            light.refuse(f"{kind[:20]!r} is not a light type of glTF")
        position = tuple(map(float, world[:3, 3]))
        lamp = PointLight((position[0], position[1], position[2]), color)
        self._nodes.append(node)
        self.lights.append(self._make_spot(lamp, light, (x, y, z)) if kind == "spot" else lamp)

    def _make_spot(self, lamp: PointLight, light: Record, axis: Color) -> PointLight:
        """Return the lamp with the direction and the cone of a spot light."""
        spot = light.object_at("spot")
        outer = min(spot.number("outerConeAngle", math.pi / 4, least=1e-6), math.pi / 2)
        inner = min(spot.number("innerConeAngle", 0.0, least=0.0), outer)
        cosines = math.cos(inner), math.cos(outer)
        if self.is_blender:
            # Blender writes its blend as a part of the angle, but Cycles blends over the cosine.
            cosines = cosines[1] + (1 - cosines[1]) * (1 - inner / outer), cosines[1]
        return replace(lamp, direction=axis, cone_cosines=cosines, is_smooth=self.is_blender)

    def _add_sun(self, node: int, to_sun: Color, irradiance: Color) -> None:
        """Keep the brightest sun, because the scene can have one; note that others are left out."""
        self._sun_count += 1
        if self._sun_count > 1:
            self.gltf.note_loss(
                "Suns except the brightest are left out", self.animation.tree.records[node]
            )
        if self._sun_count == 1 or sum(irradiance) > sum(self.daylight.sun):
            self._sun_node = node
            self.daylight = replace(self.daylight, to_sun=to_sun, sun=irradiance)

    @property
    def motion(self) -> MovingLights | None:
        """The lights at each frame, with their current exposure; None if none of them moves."""
        light_nodes = [*self._nodes, *([] if self._sun_node is None else [self._sun_node])]
        if not any(self.animation.is_moving(node) for node in light_nodes):
            return None
        lighting = Lighting(tuple(self.lights), self.daylight)
        return MovingLights(self.animation, lighting, tuple(self._nodes), self._sun_node)

    def scale_to_exposure(self, points_m: Array) -> None:
        """Scale the lights to a suitable exposure of the points `points_m` (N, 3).

        Blender's lights are converted back to watts under a black sky, as Cycles renders them with
        a black world. Lights of other programs that are much too bright are taken as photometric:
        they are scaled until the median of the points gets the daylight of a scene without lights.
        """
        if not self.lights and not self._sun_count:
            return
        if len(self.lights) > _LAMPS_MOST:
            self.notes[
                f"Only the {_LAMPS_MOST} brightest of {len(self.lights)} lamps are used."
            ] = None
        median_irradiance = float(np.median(self._irradiance(points_m)))
        factor = 1.0
        if self.is_blender and self._brightest_intensity() >= _TOO_BRIGHT:
            factor = 1 / _LUMENS_OF_WATT
            self._add_note(
                "Lights are taken as Blender's watts, of which it wrote 683 lumens each", ""
            )
        elif median_irradiance > _TOO_BRIGHT:
            factor = _TARGET_IRRADIANCE / median_irradiance
            stops_words = f", which are {-math.log2(factor):.1f} stops"
            self._add_note(
                f"Lights in candela and lux are exposed by 1/{1 / factor:.4g}", stops_words
            )
        if self.is_blender:
            self.daylight = replace(self.daylight, zenith=_NIGHT, horizon=_NIGHT, ground=_NIGHT)
            self._add_note("The sky is black, as the file has lights of its own", "")
        self._scale_lights(factor)

    def _add_note(self, words: str, ending: str) -> None:
        """Add a note of these words and their ending."""
        self.notes[f"{words}{ending}."] = None

    def _brightest_intensity(self) -> float:
        """Return the greatest channel of the lamps and of the sun."""
        lamps = [max(light.intensity) for light in self.lights]
        return max([*lamps, max(self.daylight.sun)])

    def _irradiance(self, points_m: Array) -> Array:
        """Return the irradiance (N,) at points (N, 3) of a surface that would face all lights."""
        irradiance = np.full(len(points_m), max(self.daylight.sun) if self._sun_count else 0.0)
        # A lamp inside an object counts as if it were at a least distance.
        least_square_m2 = 1e-4 * max(float(np.sum(np.ptp(points_m, axis=0) ** 2)), 1e-4)
        for light in self.lights:
            distance_squared = np.sum((points_m - np.array(light.position_m)) ** 2, axis=1)
            irradiance += max(light.intensity) / np.maximum(distance_squared, least_square_m2)
        return irradiance

    def _scale_lights(self, factor: float) -> None:
        """Multiply the intensities of the lamps and of the sun by a factor."""
        scaled = [
            replace(light, intensity=_scale_color(light.intensity, factor)) for light in self.lights
        ]
        self.lights = scaled
        if self._sun_count:
            self.daylight = replace(self.daylight, sun=_scale_color(self.daylight.sun, factor))


def _scale_color(color: Color, factor: float) -> Color:
    red, green, blue = (factor * value for value in color)
    return red, green, blue


def _light_direction(world: Array) -> tuple[float, float, float] | None:
    """Return the direction of a light, which is its node's -z; None if that has no length."""
    length = float(np.linalg.norm(world[:3, 2]))
    if not 1e-12 < length < 1e12:
        return None
    x, y, z = map(float, -world[:3, 2] / length)
    return x, y, z


def _move_lamp(lamp: PointLight, world: Array) -> PointLight:
    """Return a lamp moved with its node to `world` (4, 4)."""
    x, y, z = map(float, np.clip(np.nan_to_num(world[:3, 3]), -_FAR_MOST_M, _FAR_MOST_M))
    axis = None if lamp.direction is None else _light_direction(world) or lamp.direction
    return replace(lamp, position_m=(x, y, z), direction=axis)


def _read_intensity(light: Record) -> Color:
    """Return the intensity of a light in red, green and blue."""
    intensity = light.number("intensity", 1.0, least=0.0)
    red, green, blue = (max(v, 0.0) * intensity for v in light.row("color", (1, 1, 1)))
    return red, green, blue
