"""Write the street as a .glb, with the walks keyed at every half frame."""

import io
import json
import struct
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt
from PIL import Image
from scipy.spatial.transform import Rotation

from demo_street.actors import LOOP_FRAMES, Walk, joints_at
from demo_street.street_set import DemoSet
from heatlens.core.model.curves.frames import FRAMES_PER_SECOND
from heatlens.media.scene.scene import Array, Material, Mesh, PointLight

Followed = tuple[Walk, str]  # a walk, and the joint that an instance follows
_CODES = {"float32": 5126, "uint32": 5125, "uint16": 5123}
_KINDS = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}
_KEY_EVERY = 0.5  # frames; straight lines between these are 4 mm off at most
_STRENGTH = "KHR_materials_emissive_strength"
_LIGHTS = "KHR_lights_punctual"
Entry = dict[str, Any]


@dataclass
class _File:
    """The lists of the file's JSON, and the bytes behind it."""

    lists: dict[str, list[Entry]] = field(default_factory=dict)
    data: bytearray = field(default_factory=bytearray)

    def add(self, name: str, /, **entry: Any) -> int:
        """Append an entry to a list; return its index."""
        self.lists.setdefault(name, []).append(entry)
        return len(self.lists[name]) - 1

    def view(self, data: bytes) -> int:
        """Add bytes; return the index of their view."""
        self.data += b"\0" * (-len(self.data) % 4)
        start = len(self.data)
        self.data += data
        return self.add("bufferViews", buffer=0, byteOffset=start, byteLength=len(data))

    def array(self, values: npt.NDArray[Any]) -> int:
        """Add numbers (N,) or (N, 1 to 4); return the index of their accessor."""
        rows = np.ascontiguousarray(values).reshape(len(values), -1)
        return self.add(
            "accessors",
            bufferView=self.view(rows.tobytes()),
            componentType=_CODES[rows.dtype.name],
            count=len(rows),
            type=_KINDS[rows.shape[1]],
            min=rows.min(axis=0).tolist(),
            max=rows.max(axis=0).tolist(),
        )

    def glb(self, **more: Any) -> bytes:
        """Return the whole file."""
        told = {**more, **self.lists, "buffers": [{"byteLength": len(self.data)}]}
        text = json.dumps(told, separators=(",", ":")).encode()
        chunks = [(b"JSON", text, b" "), (b"BIN\0", bytes(self.data), b"\0")]
        body = b""
        for kind, content, filler in chunks:
            content += filler * (-len(content) % 4)
            body += struct.pack("<I4s", len(content), kind) + content
        return b"glTF" + struct.pack("<II", 2, 12 + len(body)) + body


def glb_of(stage: DemoSet, ground: npt.NDArray[np.uint8], moving: Mapping[int, Followed]) -> bytes:
    """Return a scene as a .glb; `moving` has what the moving instances follow, by their number."""
    file = _File()
    file.add("images", bufferView=file.view(_png(ground)), mimeType="image/png")
    file.add("textures", source=0)
    for material in stage.materials:
        file.add("materials", **_material(material))
    for mesh in stage.meshes:
        _add_mesh(file, mesh)
    for number, instance in enumerate(stage.instances):
        place = {} if number in moving else {"matrix": instance.to_world.T.ravel().tolist()}
        file.add("nodes", name=instance.name, mesh=instance.mesh, **place)
    for number, light in enumerate(stage.lights):
        on_node = {_LIGHTS: {"light": number}}
        file.add("nodes", name="light", translation=light.position_m, extensions=on_node)
    _add_walks(file, moving)
    lights = [_light(light) for light in stage.lights]
    return file.glb(
        asset={"version": "2.0", "generator": "heatlens"},
        extensionsUsed=[_STRENGTH, _LIGHTS],
        extensions={_LIGHTS: {"lights": lights}},
        scene=0,
        scenes=[{"nodes": list(range(len(file.lists["nodes"])))}],
    )


def _light(light: PointLight) -> Entry:
    strength = max(light.intensity)
    color = [value / strength for value in light.intensity]
    return {"type": "point", "color": color, "intensity": strength}


def _png(pixels: npt.NDArray[np.uint8]) -> bytes:
    written = io.BytesIO()
    Image.fromarray(pixels).save(written, "PNG")
    return written.getvalue()


def _material(material: Material) -> Entry:
    shine: Entry = {
        "baseColorFactor": [*material.base_color, 1.0],
        "metallicFactor": material.metallic,
        "roughnessFactor": material.roughness,
    }
    if material.base_color_map is not None:
        shine["baseColorTexture"] = {"index": material.base_color_map}
    entry: Entry = {"name": material.name, "pbrMetallicRoughness": shine}
    if material.alpha_cutoff:
        entry |= {"alphaMode": "MASK", "alphaCutoff": material.alpha_cutoff}
    strength = max(material.emission)
    if strength:
        entry["emissiveFactor"] = [value / strength for value in material.emission]
        entry["extensions"] = {_STRENGTH: {"emissiveStrength": strength}}
    return entry


def _add_mesh(file: _File, mesh: Mesh) -> None:
    attributes = {"POSITION": file.array(mesh.positions_m), "NORMAL": file.array(mesh.normals)}
    if mesh.uvs.any():
        attributes["TEXCOORD_0"] = file.array(mesh.uvs)
    corners = file.array(mesh.triangles.reshape(-1).astype(np.uint16))
    primitive = {"attributes": attributes, "indices": corners, "material": mesh.material}
    file.add("meshes", primitives=[primitive])


def _add_walks(file: _File, moving: Mapping[int, Followed]) -> None:
    """Add one animation; instances that follow the same joint share its curves."""
    frames = np.arange(0, LOOP_FRAMES + 1, _KEY_EVERY)
    times = file.array((frames / FRAMES_PER_SECOND).astype(np.float32))
    samplers: list[Entry] = []
    first: dict[Followed, int] = {}
    for followed in dict.fromkeys(moving.values()):
        first[followed] = len(samplers)
        for values in _curves(followed, frames + 1.0):
            samplers.append({"input": times, "output": file.array(values.astype(np.float32))})
    channels = [
        {"sampler": first[followed] + i, "target": {"node": node, "path": path}}
        for node, followed in moving.items()
        for i, path in enumerate(("translation", "rotation"))
    ]
    file.add("animations", name="walks", samplers=samplers, channels=channels)


def _curves(followed: Followed, frames: Array) -> tuple[Array, Array]:
    """Return translations (F, 3) and quaternions (F, 4) of a joint."""
    walk, joint = followed
    places = np.stack([joints_at(walk, frame)[joint] for frame in frames])
    return places[:, :3, 3], _quaternions(places[:, :3, :3])


def _quaternions(turns: Array) -> Array:
    """Return unit quaternions (N, 4) as (x, y, z, w), each on the side of the one before it."""
    found = Rotation.from_matrix(turns).as_quat()
    flips = np.cumprod(np.where(np.sum(found[1:] * found[:-1], axis=1) < 0, -1.0, 1.0))
    found[1:] *= flips[:, None]
    return found
