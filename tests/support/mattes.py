"""Plates with Cryptomatte and channels of ids, as renderers write them."""

import json
from pathlib import Path

import numpy as np

from support.exr_files import write_file

HEIGHT, WIDTH = 24, 32
# Ids that Blender 5 gave to objects of these names.
HERO, CARD = 0x82CE30B4, 0xF16040D1
MANIFEST = json.dumps({"hero": f"{HERO:08x}", "card": f"{CARD:08x}"})


def as_float(thing: int) -> np.float32:
    return np.array([thing], np.uint32).view(np.float32)[0]


def matte_plate(path: Path, hero_m: float | None, coverage: float = 1.0, **header: str) -> Path:
    """Write a card at 6 m, in the right half, and a hero in the middle; None hides the hero."""
    z = np.full((HEIGHT, WIDTH), 9, "f4")
    z[:, 16:] = 6
    first, second = np.zeros((HEIGHT, WIDTH, 2), "f4"), np.zeros((HEIGHT, WIDTH, 2), "f4")
    first[:, 16:] = as_float(CARD), 1
    if hero_m is not None:
        inside = np.s_[8:16, 12:20]
        second[inside] = first[inside] * np.array([1, 1 - coverage], "f4")
        z[inside], first[inside] = hero_m, (as_float(HERO), coverage)
    ranks = dict(zip("RGBA", np.moveaxis(np.concatenate([first, second], -1), -1, 0), strict=True))
    layers = {f"Crypto00.{leaf}": np.ascontiguousarray(it) for leaf, it in ranks.items()}
    ids = (first[..., 0] == as_float(HERO)).astype("u4") * 7
    color = dict.fromkeys("RGB", np.full((HEIGHT, WIDTH), 0.5, "f4"))
    metadata = {"name": "Crypto", "hash": "MurmurHash3_32", "manifest": MANIFEST} | header
    attributes = {f"cryptomatte/abc1234/{key}": value for key, value in metadata.items()}
    others = {"Z": z, "objectId": ids, "mask.A": (ids / 14).astype("f4")}
    return write_file(path, color | layers | others, **attributes)
