"""Stages with cameras, for tests of reading them."""

from pxr import Usd, UsdGeom

SUFFIXES = (".usda", ".usd", ".usdc")


def write_camera_stage(path, *prims: str) -> Usd.Stage:
    stage = Usd.Stage.CreateNew(str(path))
    for prim in prims:
        UsdGeom.Camera.Define(stage, prim)
    return stage


def nested_references_stage(levels: int = 8, width: int = 8) -> str:
    """Return a USD stage whose nested references expand to `width ** levels` prims."""
    rows = ["#usda 1.0", 'def Xform "L0"\n{\ndef Camera "C"\n{\n}\n}']
    for level in range(1, levels + 1):
        reference = f"(\nreferences = </L{level - 1}>\n)\n{{\n}}"
        inner = [f'def "R{i}" {reference}' for i in range(width)]
        rows.append(f'def Xform "L{level}"\n{{\n' + "\n".join(inner) + "\n}")
    return "\n".join(rows)
