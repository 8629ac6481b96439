"""Stages with cameras, for tests of reading them."""

from pxr import Usd, UsdGeom

SUFFIXES = (".usda", ".usd", ".usdc")


def stage_with(path, *prims: str) -> Usd.Stage:
    stage = Usd.Stage.CreateNew(str(path))
    for prim in prims:
        UsdGeom.Camera.Define(stage, prim)
    return stage


def bomb(levels: int = 8, width: int = 8) -> str:
    """Write prims that each refer to `width` of the level below: `width ** levels` in all."""
    rows = ["#usda 1.0", 'def Xform "L0"\n{\ndef Camera "C"\n{\n}\n}']
    for level in range(1, levels + 1):
        refers = f"(\nreferences = </L{level - 1}>\n)\n{{\n}}"
        inner = [f'def "R{i}" {refers}' for i in range(width)]
        rows.append(f'def Xform "L{level}"\n{{\n' + "\n".join(inner) + "\n}")
    return "\n".join(rows)
