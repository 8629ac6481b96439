"""Stages with cameras, for tests of reading them."""

from pxr import Usd, UsdGeom

SUFFIXES = (".usda", ".usd", ".usdc")


def stage_with(path, *prims: str) -> Usd.Stage:
    stage = Usd.Stage.CreateNew(str(path))
    for prim in prims:
        UsdGeom.Camera.Define(stage, prim)
    return stage
