"""The foreground of the built-in scene: a railing with plants, a table, a branch."""

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
    turned_x,
    turned_y,
    turned_z,
)
from demo_street.street import AMBER, WARM
from demo_street.street_set import DemoSet
from heatlens.media.scene.scene import Array, Mesh, PointLight

_TABLE_M = (0.78, -2.15)  # x, z
_TOP_M = 0.76
_RAIL_X_M = -0.92
_RAIL_M = 0.98


def build_cafe(stage: DemoSet) -> None:
    """Add the railing on the left, the table on the right and the leaves above."""
    rng = np.random.default_rng(3)
    _railing(stage, rng)
    _table(stage)
    _leaves_above(stage, rng)


def _railing(stage: DemoSet, rng: np.random.Generator) -> None:
    iron = stage.paint((0.025, 0.03, 0.03), 0.35, 0.7, name="iron")
    posts = [placed(box(0.022, _RAIL_M, 0.022), moved(0, 0, z)) for z in np.arange(-4.4, -1.1, 0.2)]
    rails = [tube([(0, y, -4.5), (0, y, -1.0)], 0.022, 6) for y in (0.12, _RAIL_M)]
    place = moved(_RAIL_X_M, 0, 0)
    stage.put("railing", stage.mesh(joined([*posts, *rails]), iron), place)
    trough = stage.paint((0.12, 0.055, 0.03), 0.7, name="wood")
    stage.put("plants", stage.mesh(box(0.2, 0.18, 1.1), trough), place @ moved(0, 0.86, -2.3))
    green = stage.paint((0.05, 0.12, 0.04), 0.5, name="leaf")
    plant = stage.mesh(_bush(rng, 70, (0.2, 0.22, 1.1)), green)
    stage.put("plants", plant, place @ moved(0, 1.08, -2.3))
    winding = [_around_rail(float(t)) for t in np.linspace(0, 1, 26)]
    beads = joined(placed(sphere(0.008, 4, 2), moved(*point)) for point in winding)
    stage.put("fairy lights", stage.mesh(beads, stage.lamp(AMBER, 60.0)), place)


def _around_rail(share: float) -> Point:
    """Return a point of the string of lights that winds around the upper rail."""
    angle = share * 40.0
    return 0.035 * np.cos(angle), _RAIL_M + 0.035 * np.sin(angle), -1.2 - 3.2 * share


def _bush(rng: np.random.Generator, leaves: int, size_m: Point) -> Mesh:
    """Return leaves of two faces, folded in the middle, spread through a box around the origin."""
    places = (rng.random((leaves, 3)) - 0.5) * size_m
    turns = rng.uniform(-np.pi, np.pi, (leaves, 2))
    sizes = rng.uniform(0.7, 1.3, leaves)
    return joined(
        placed(
            _leaf(),
            moved(*map(float, place))
            @ turned_y(float(turn))
            @ turned_x(float(0.3 * focus_offset))
            @ scaled(size, size, size),
        )
        for place, (turn, focus_offset), size in zip(places, turns, sizes, strict=True)
    )


def _leaf() -> Mesh:
    base, tip = (0.0, 0.0, 0.0), (0.0, 0.02, 0.12)
    left, right, middle = (-0.032, 0.022, 0.055), (0.032, 0.022, 0.055), (0.0, 0.005, 0.06)
    # A half folds from its side to the middle: `quads` splits from the first corner to the third.
    halves = [(left, base, middle, tip), (right, tip, middle, base)]
    return quads(np.array(half) for half in halves)


def _table(stage: DemoSet) -> None:
    x, z = _TABLE_M
    place = moved(x, 0, z)
    wood = stage.paint((0.16, 0.08, 0.04), 0.35, name="wood")
    iron = stage.paint((0.03, 0.03, 0.03), 0.4, 0.7, name="iron")
    top = [(0.0, 0.73), (0.34, 0.73), (0.35, 0.745), (0.34, _TOP_M), (0.0, _TOP_M)]
    foot = [(0.22, 0.0), (0.2, 0.03), (0.03, 0.06), (0.03, 0.73)]
    stage.put("table", stage.mesh(lathe(top, 28, smooth=False), wood), place)
    stage.put("table", stage.mesh(lathe(foot, 12, smooth=False), iron), place)
    _lantern(stage, place @ moved(-0.1, _TOP_M, 0.05), iron)
    china = stage.paint((0.75, 0.72, 0.66), 0.25, name="china")
    cup = [
        (0.0, 0.004),
        (0.07, 0.008),
        (0.075, 0.014),
        (0.028, 0.012),
        (0.04, 0.05),
        (0.044, 0.075),
    ]
    inside = [(0.04, 0.072), (0.034, 0.03), (0.0, 0.025)]
    stage.put(
        "table", stage.mesh(lathe([*cup, *inside], 16), china), place @ moved(0.12, _TOP_M, 0)
    )


def _lantern(stage: DemoSet, place: Array, iron: int) -> None:
    """Add a candle between four bars, which lights the table and people who pass."""
    bars = [placed(box(0.012, 0.2, 0.012), moved(x, 0.02, z)) for x, z in _corners(0.055)]
    roof = placed(lathe([(0.09, 0.0), (0.03, 0.05), (0.0, 0.07)], 4), moved(0, 0.22, 0))
    frame = joined([box(0.13, 0.02, 0.13), *bars, placed(roof, turned_y(np.pi / 4))])
    stage.put("lantern", stage.mesh(frame, iron), place)
    wax = stage.mesh(lathe([(0.028, 0.02), (0.028, 0.1), (0.0, 0.1)], 10), stage.lamp(WARM, 1.2))
    flame = stage.mesh(lathe([(0.0, 0.1), (0.011, 0.12), (0.0, 0.16)], 8), stage.lamp(WARM, 90.0))
    stage.put("lantern", wax, place)
    stage.put("lantern", flame, place)
    x, y, z = (float(value) for value in (place @ moved(0, 0.22, 0))[:3, 3])
    stage.lights.append(PointLight((x, y, z), (0.75, 0.4, 0.15)))


def _corners(half_m: float) -> list[tuple[float, float]]:
    return [(x, z) for x in (-half_m, half_m) for z in (-half_m, half_m)]


def _leaves_above(stage: DemoSet, rng: np.random.Generator) -> None:
    """Add a branch with a few bulbs that hangs into the upper left corner."""
    green = stage.paint((0.045, 0.09, 0.035), 0.55, name="leaf")
    place = moved(-0.62, 1.5, -1.5) @ turned_z(-0.35)
    stage.put("branch", stage.mesh(_bush(rng, 60, (0.55, 0.14, 0.4)), green), place)
    bulbs = rng.uniform(-0.5, 0.5, (7, 3)) * (0.55, 0.12, 0.35)
    beads = joined(placed(sphere(0.013, 6, 4), moved(*map(float, bulb))) for bulb in bulbs)
    stage.put("branch", stage.mesh(beads, stage.lamp(AMBER, 60.0)), place)
