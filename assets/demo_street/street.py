"""The street of the built-in scene: houses, lamps and strings of bulbs, far behind the people."""

import numpy as np

from demo_street.shapes import (
    Point,
    box,
    joined,
    lathe,
    moved,
    placed,
    quads,
    scaled,
    sphere,
    tube,
    turned_y,
)
from demo_street.street_set import DemoSet
from heatlens.media.scene.scene import Array, Color, Mesh, PointLight

WARM: Color = (1.0, 0.62, 0.28)
AMBER: Color = (1.0, 0.46, 0.13)
_SIDE_M = 5.6  # from the middle of the street to the houses
_LAMP_M = 3.1  # height of a lamp
_LAMP_ROWS = tuple(-9.0 - 6.5 * i for i in range(7))
_HOUSES = 7
_END_M = -64.0
_WINDOW_M = (0.95, 1.35)


def build_street(stage: DemoSet) -> None:
    """Add pavements, houses and lights."""
    rng = np.random.default_rng(7)
    _pavements(stage)
    _houses(stage, rng)
    _lamps(stage)
    _garlands(stage)
    _traffic(stage)
    _signs(stage)


def _pavements(stage: DemoSet) -> None:
    """Add the pavements; the road between them is the wet ground of make.py."""
    stone = stage.paint((0.09, 0.085, 0.08), 0.45, name="kerb")
    kerb = stage.mesh(box(1.6, 0.12, 72.0), stone)
    stage.put("ground", kerb, moved(-4.8, 0, -42), moved(4.8, 0, -42))


def _houses(stage: DemoSet, rng: np.random.Generator) -> None:
    """Add two rows of houses and one across the end, some of their windows lit."""
    walls = [(0.10, 0.085, 0.08), (0.075, 0.08, 0.1), (0.12, 0.09, 0.07)]
    paints = [stage.paint(color, 0.85, name="wall") for color in walls]
    blocks = [stage.mesh(box(8.6, 1.0, 8.0), paint) for paint in paints]
    frames: list[Array] = []
    for i in range(_HOUSES):
        for side in (-1.0, 1.0):
            height = float(rng.uniform(6.5, 11.5))
            front = moved(side * _SIDE_M, 0, -8.0 - 8.6 * i) @ turned_y(-side * np.pi / 2)
            stage.put(
                "houses", int(rng.choice(blocks)), front @ moved(0, 0, -4) @ scaled(1, height, 1)
            )
            frames += _windows(front, 4, height)
    end = moved(0, 0, _END_M)
    stage.put("houses", blocks[1], end @ moved(0, 0, -4) @ scaled(2.4, 9.0, 1))
    _light_windows(stage, frames + _windows(end, 8, 9.0), rng)


def _windows(front: Array, across: int, height_m: float) -> list[Array]:
    """Return (4, 4) to the middle of each window of a house with this front."""
    floors = int((height_m - 1.0) // 2.7)
    pitch = 8.0 / 4
    return [
        front @ moved((i - (across - 1) / 2) * pitch, 2.0 + 2.7 * floor, 0.03)
        for i in range(across)
        for floor in range(floors)
    ]


def _light_windows(stage: DemoSet, places: list[Array], rng: np.random.Generator) -> None:
    """Light some windows in one of three colours and leave the others dark."""
    dark = stage.paint((0.02, 0.025, 0.035), 0.15, name="glass")
    lit = [(WARM, 1.3), ((1.0, 0.72, 0.42), 0.7), ((0.45, 0.7, 1.0), 0.6)]
    paints = [dark, *(stage.lamp(color, radiance) for color, radiance in lit)]
    kinds = rng.choice(4, len(places), p=(0.52, 0.24, 0.16, 0.08))
    x, y = _WINDOW_M[0] / 2, _WINDOW_M[1] / 2
    pane = quads([np.array([(-x, -y, 0), (x, -y, 0), (x, y, 0), (-x, y, 0)])])
    for kind, paint in enumerate(paints):
        panes = [placed(pane, place) for place, k in zip(places, kinds, strict=True) if k == kind]
        stage.put("windows", stage.mesh(joined(panes), paint), np.eye(4))


def _lamps(stage: DemoSet) -> None:
    """Add a row of lamps on each kerb; the first ones light what stands around them."""
    iron = stage.paint((0.03, 0.035, 0.035), 0.4, 0.6, name="iron")
    profile = [(0.14, 0.0), (0.12, 0.25), (0.05, 0.35), (0.04, 2.9), (0.13, 2.96), (0.0, 2.97)]
    post = stage.mesh(lathe(profile, 6, smooth=False), iron)
    globe = stage.mesh(sphere(0.1, 6, 4), stage.lamp(WARM, 50.0))
    for z in _LAMP_ROWS:
        for x in (-4.2, 4.2):
            stage.put("street lamps", post, moved(x, 0.12, z))
            stage.put("street lamps", globe, moved(x, 0.12 + _LAMP_M, z))
            if z > -24:
                stage.lights.append(PointLight((x, _LAMP_M, z), (13.0, 7.6, 3.4)))


def _garlands(stage: DemoSet) -> None:
    """Add strings of bulbs across the street, from lamp to lamp, and along the houses."""
    wire = stage.paint((0.02, 0.02, 0.02), 0.8, name="wire")
    strings = [
        (stage.mesh(_string_wire(), wire), stage.mesh(_bulbs(0, 2), stage.lamp(AMBER, 60.0))),
        (-1, stage.mesh(_bulbs(1, 4), stage.lamp((1.0, 0.16, 0.09), 60.0))),
        (-1, stage.mesh(_bulbs(3, 4), stage.lamp((0.16, 0.55, 1.0), 55.0))),
    ]
    places = [
        moved(0, 3.05, z) @ turned_y(slant) @ scaled(1.0 / np.cos(slant), 1, 1)
        for z, slant in zip(np.linspace(-12.5, -48.0, 9), (0.5, -0.45, 0.4) * 3, strict=True)
    ]
    for thread, bulbs in strings:
        for mesh in (thread, bulbs):
            if mesh >= 0:
                stage.put("garlands", mesh, *places)


def _sag(x: float) -> Point:
    """Return a point of a string that is 8.4 m wide and hangs 0.7 m down."""
    return x, 0.7 * ((x / 4.2) ** 2 - 1.0), 0.0


def _string_wire() -> Mesh:
    return tube([_sag(float(x)) for x in np.linspace(-4.2, 4.2, 9)], 0.006, 3)


def _bulbs(first: int, every: int) -> Mesh:
    bulb = sphere(0.028, 4, 2)
    places = np.linspace(-3.9, 3.9, 16)[first::every]
    return joined(placed(bulb, moved(*_sag(float(x))) @ moved(0, -0.05, 0)) for x in places)


def _traffic(stage: DemoSet) -> None:
    """Add cars far down the street, and the lights that stop them."""
    lamp = sphere(0.07, 6, 4)
    pair = joined(placed(lamp, moved(x, 0.65, 0)) for x in (-0.6, 0.6))
    white = stage.mesh(pair, stage.lamp((1.0, 0.9, 0.75), 200.0))
    red = stage.mesh(pair, stage.lamp((1.0, 0.05, 0.03), 90.0))
    stage.put("cars", white, moved(-1.9, 0, -44), moved(-2.1, 0, -57))
    stage.put("cars", red, moved(1.5, 0, -36), moved(1.9, 0, -50))
    signal = stage.mesh(sphere(0.11, 6, 4), stage.lamp((0.1, 1.0, 0.45), 75.0))
    stage.put("traffic lights", signal, moved(-3.3, 2.5, -40), moved(3.3, 2.5, -40))


def _signs(stage: DemoSet) -> None:
    """Add shop fronts and neon signs, which a lens blurs to soft rectangles."""
    glow = [
        ((1.0, 0.2, 0.45), 2.6, -1.0, -15.5),
        ((0.2, 0.85, 0.9), 2.4, 1.0, -21.0),
        ((1.0, 0.45, 0.1), 2.8, 1.0, -12.5),
        ((0.55, 0.3, 1.0), 3.0, -1.0, -29.0),
    ]
    for color, radiance, side, z in glow:
        sign = stage.mesh(box(0.08, 1.5, 0.5), stage.lamp(color, radiance))
        stage.put("signs", sign, moved(side * (_SIDE_M - 0.6), 2.6, z))
    shop = stage.mesh(_shop_front(), stage.lamp((1.0, 0.66, 0.32), 0.9))
    places = [(-1.0, -11.0), (1.0, -16.5), (-1.0, -24.0), (1.0, -31.0)]
    stage.put("shops", shop, *(moved(side * _SIDE_M, 0.5, z) for side, z in places))


def _shop_front() -> Mesh:
    """Add four panes with dark frames between them."""
    return joined(placed(box(0.05, 1.6, 0.72), moved(0, 0, 0.85 * i)) for i in (-2, -1, 0, 1))
