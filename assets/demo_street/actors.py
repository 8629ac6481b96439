"""The people of the built-in scene: limbs of round shapes, and a walk that ends where it began."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from demo_street.shapes import (
    joined,
    lathe,
    limb,
    moved,
    placed,
    scaled,
    sphere,
    turned_x,
    turned_y,
    turned_z,
)
from demo_street.street_set import DemoSet
from heatlens.media.scene.scene import Array, Color, Mesh

LOOP_FRAMES = 240
_THIGH_M = _SHIN_M = 0.43
_ANKLE_M = 0.08  # height above the ground
_SIDES = (("left", 1.0), ("right", -1.0))  # a person who looks along +z has the left hand at +x
_TURN_STEPS = 720


@dataclass(frozen=True)
class Walk:
    """A walk once around an ellipse on the ground in LOOP_FRAMES frames.

    centre_m   (x, z)
    reach_m    half axes along x and z
    side_frame frame at which the side nearest to +z is passed
    turns      1 turns left there, -1 right
    cycles     pairs of steps in one loop
    """

    centre_m: tuple[float, float]
    reach_m: tuple[float, float]
    side_frame: float
    turns: int
    cycles: int

    def place_at(self, frame: float) -> tuple[float, float]:
        """Return (x, z) in metres."""
        angle = self._angle(frame)
        x, z = self.centre_m
        return x + self.reach_m[0] * np.cos(angle), z + self.reach_m[1] * np.sin(angle)

    def heading_at(self, frame: float) -> float:
        """Return the heading in radians, from +z towards +x."""
        angle = self._angle(frame)
        x, z = -self.reach_m[0] * np.sin(angle), self.reach_m[1] * np.cos(angle)
        return float(np.arctan2(self.turns * x, self.turns * z))

    def stride_at(self, frame: float) -> float:
        """Return the phase of the walk cycle in radians; it follows the distance walked."""
        way = _way(*self.reach_m)
        angle = self.turns * self._angle(frame)
        whole, rest = np.divmod(angle, 2 * np.pi)
        share = np.interp(rest, np.linspace(0, 2 * np.pi, len(way)), way)
        return float(2 * np.pi * self.cycles * (whole + share))

    @property
    def step_m(self) -> float:
        """Length of one step."""
        return _way_m(*self.reach_m) / (2 * self.cycles)

    def _angle(self, frame: float) -> float:
        return np.pi / 2 + self.turns * 2 * np.pi * (frame - self.side_frame) / LOOP_FRAMES


@lru_cache
def _way(across_m: float, along_m: float) -> Array:
    """Return the share (n,) of an ellipse's length before each of n evenly spaced angles."""
    return np.asarray(_lengths(across_m, along_m) / _way_m(across_m, along_m))


@lru_cache
def _way_m(across_m: float, along_m: float) -> float:
    return float(_lengths(across_m, along_m)[-1])


def _lengths(across_m: float, along_m: float) -> Array:
    angles = np.linspace(0, 2 * np.pi, _TURN_STEPS + 1)
    corners = np.stack([across_m * np.cos(angles), along_m * np.sin(angles)], axis=1)
    pieces = np.linalg.norm(np.diff(corners, axis=0), axis=1)
    return np.concatenate([[0.0], np.cumsum(pieces)])


def joints_at(walk: Walk, frame: float) -> dict[str, Array]:
    """Return (4, 4) to the world for the body and each limb; the lower foot is on the ground."""
    stride = walk.stride_at(frame)
    swing = float(np.arcsin(walk.step_m / (2 * (_THIGH_M + _SHIN_M))))
    legs = {side: _leg_angles(stride + turn, swing) for side, turn in _phases()}
    hip_m = max(_reach_down_m(*angles) for angles in legs.values())
    x, z = walk.place_at(frame)
    body = moved(x, hip_m, z) @ turned_y(walk.heading_at(frame))
    joints = {"body": body @ turned_y(0.25 * swing * np.sin(stride)), "head": body}
    for side, sign in _SIDES:
        thigh, knee = legs[side]
        hip = body @ moved(0.095 * sign, 0, 0) @ turned_x(-thigh)
        joints[f"{side} thigh"] = hip
        joints[f"{side} shin"] = hip @ moved(0, -_THIGH_M, 0) @ turned_x(knee)
        arm = -0.9 * thigh  # opposite to the leg on its side
        shoulder = joints["body"] @ moved(0.205 * sign, 0.44, 0) @ turned_z(0.12 * sign)
        joints[f"{side} arm"] = shoulder @ turned_x(-arm)
        bend = 0.35 + 0.5 * max(arm, 0.0)
        joints[f"{side} forearm"] = shoulder @ turned_x(-arm) @ moved(0, -0.28, 0) @ turned_x(-bend)
    return joints


def _phases() -> tuple[tuple[str, float], ...]:
    return ("left", 0.0), ("right", np.pi)


def _leg_angles(stride: float, swing: float) -> tuple[float, float]:
    """Return the angles of thigh and knee in radians; the knee bends as the leg swings."""
    lifted = max(0.0, float(np.cos(stride + 0.35)))
    return swing * float(np.sin(stride)), 0.06 + 2.0 * swing * lifted**2


def _reach_down_m(thigh: float, knee: float) -> float:
    """Return the height of the hip above the ground under a foot."""
    return float(_THIGH_M * np.cos(thigh) + _SHIN_M * np.cos(thigh - knee)) + _ANKLE_M


@dataclass(frozen=True)
class Clothes:
    """The colours that tell people apart."""

    coat: Color
    trousers: Color
    scarf: Color
    hat: Color
    skin: Color
    is_brimmed: bool = False


def dress(stage: DemoSet, name: str, clothes: Clothes) -> list[str]:
    """Add a figure called `name`; return the joint that each of its instances follows."""
    joints: list[str] = []
    for color, roughness, parts in _wardrobe(clothes):
        material = stage.paint(color, roughness, name=name)
        for mesh, followed in parts:
            number = stage.mesh(mesh, material)
            stage.put(name, number, *(np.eye(4) for _ in followed))
            joints += followed
    return joints


def _wardrobe(clothes: Clothes) -> list[tuple[Color, float, list[tuple[Mesh, list[str]]]]]:
    """Return colour and roughness of each material with its meshes and their joints."""
    return [
        (
            clothes.coat,
            0.75,
            [
                (_coat(), ["body"]),
                (limb(0.062, 0.05, 0.28), ["left arm", "right arm"]),
                (limb(0.05, 0.042, 0.2), ["left forearm", "right forearm"]),
            ],
        ),
        (
            clothes.trousers,
            0.8,
            [
                (limb(0.085, 0.062, _THIGH_M), ["left thigh", "right thigh"]),
                (limb(0.06, 0.05, _SHIN_M - 0.03), ["left shin", "right shin"]),
            ],
        ),
        (clothes.scarf, 0.9, [(_scarf(), ["body"])]),
        (clothes.hat, 0.85, [(_hat(clothes.is_brimmed), ["head"])]),
        (clothes.skin, 0.55, [(_face(), ["head"]), (_hand(), ["left forearm", "right forearm"])]),
        ((0.02, 0.015, 0.012), 0.35, [(_shoe(), ["left shin", "right shin"])]),
    ]


def _coat() -> Mesh:
    profile = [(0.22, -0.36), (0.21, -0.2), (0.17, 0.08), (0.19, 0.3), (0.205, 0.42)]
    shoulders = [(0.17, 0.49), (0.1, 0.53), (0.06, 0.55)]
    return placed(lathe([*profile, *shoulders], 16), scaled(1.0, 1.0, 0.68))


def _scarf() -> Mesh:
    ring = lathe([(0.07, 0.49), (0.115, 0.5), (0.12, 0.545), (0.09, 0.58), (0.06, 0.57)], 12)
    end = placed(limb(0.045, 0.05, 0.26, 6), scaled(1.0, 1.0, 0.4))
    return joined([ring, placed(end, moved(0.06, 0.5, 0.125) @ turned_x(-0.12))])


def _face() -> Mesh:
    head = placed(sphere(0.105, 14, 10), moved(0, 0.69, 0) @ scaled(0.86, 1.2, 1.0))
    nose = placed(sphere(0.02, 6, 4), moved(0, 0.68, 0.105) @ scaled(0.8, 1.3, 1.0))
    return joined([head, nose])


def _hat(is_brimmed: bool) -> Mesh:
    if is_brimmed:
        brim = lathe([(0.1, 0.735), (0.19, 0.74), (0.19, 0.75), (0.1, 0.765)], 16)
        crown = lathe([(0.105, 0.74), (0.1, 0.83), (0.07, 0.86), (0.0, 0.855)], 16)
        return joined([brim, crown])
    beanie = lathe([(0.106, 0.72), (0.112, 0.76), (0.095, 0.82), (0.05, 0.855), (0.0, 0.86)], 14)
    return joined([beanie, placed(sphere(0.035, 8, 5), moved(0, 0.88, -0.01))])


def _hand() -> Mesh:
    return placed(sphere(0.042, 8, 5), moved(0, -0.25, 0) @ scaled(0.7, 1.3, 1.0))


def _shoe() -> Mesh:
    # the sole touches the ground when the leg is straight
    return placed(sphere(0.06, 8, 6), moved(0, -_SHIN_M - 0.03, 0.05) @ scaled(0.8, 0.83, 2.1))
