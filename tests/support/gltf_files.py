"""A writer of small glTF files, which a test puts together piece by piece."""

import base64
import io
import json
import struct

import numpy as np
from PIL import Image

_CODES = {"i1": 5120, "u1": 5121, "i2": 5122, "u2": 5123, "u4": 5125, "f4": 5126}
_KINDS = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}

SQUARE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], np.float32)
SQUARE_UVS = np.array([[0, 1], [1, 1], [1, 0], [0, 0]], np.float32)
SQUARE_CORNERS = np.array([0, 1, 2, 0, 2, 3], np.uint16)


class GltfWriter:
    """A glTF file in the making: its JSON as a dict, and the bytes of its buffer."""

    def __init__(self):
        self.json = {"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": []}]}
        self.data = bytearray()
        self.more_buffers = []  # without bytes in the file

    def add(self, name, /, **record):
        """Append an object to a list of the file; return its index."""
        records = self.json.setdefault(name, [])
        records.append(record)
        return len(records) - 1

    def view(self, data, **fields):
        """Add a buffer view of these bytes."""
        self.data += b"\0" * (-len(self.data) % 4)
        start = len(self.data)
        self.data += bytes(data)
        return self.add("bufferViews", buffer=0, byteOffset=start, byteLength=len(data), **fields)

    def accessor(self, values, **fields):
        """Add an accessor of an array (count,) or (count, width)."""
        values = np.asarray(values)
        rows = values.reshape(len(values), -1)
        return self.add(
            "accessors",
            bufferView=self.view(values.tobytes()),
            componentType=_CODES[values.dtype.str[1:]],
            count=len(values),
            type=_KINDS[rows.shape[1]],
            **fields,
        )

    def mesh(self, positions=SQUARE, corners=SQUARE_CORNERS, attributes=(), **primitive):
        """Add a mesh of one primitive; without `corners` it has no indices."""
        accessors = {name: self.accessor(values) for name, values in dict(attributes).items()}
        primitive["attributes"] = {"POSITION": self.accessor(positions), **accessors}
        if corners is not None:
            primitive["indices"] = self.accessor(corners)
        return self.add("meshes", primitives=[primitive])

    def node(self, is_root=True, **record):
        """Add a node, as a root of the scene unless it is a child of another node."""
        index = self.add("nodes", **record)
        if is_root:
            self.json["scenes"][0]["nodes"].append(index)
        return index

    def light(self, **record):
        """Add a light of KHR_lights_punctual; return what a node needs to carry it."""
        extension = self.json.setdefault("extensions", {}).setdefault("KHR_lights_punctual", {})
        lights = extension.setdefault("lights", [])
        lights.append(record)
        return {"extensions": {"KHR_lights_punctual": {"light": len(lights) - 1}}}

    def animate(self, node, path, times, values, kind="LINEAR"):
        """Add an animation of one channel."""
        times = self.accessor(np.array(times, np.float32))
        values = self.accessor(np.array(values, np.float32))
        sampler = {"input": times, "output": values, "interpolation": kind}
        channel = {"sampler": 0, "target": {"node": node, "path": path}}
        self.add("animations", samplers=[sampler], channels=[channel])

    def picture(self, pixels, kind="PNG"):
        """Add a texture of these pixels (H, W, 3 or 4)."""
        image = self.add(
            "images", bufferView=self.view(encoded(pixels, kind)), mimeType="image/png"
        )
        return self.add("textures", source=image)

    def glb(self):
        """Return the bytes of a .glb."""
        data = bytes(self.data) + b"\0" * (-len(self.data) % 4)
        buffers = [{"byteLength": len(self.data)}, *self.more_buffers] if data else []
        text = json.dumps({**self.json, "buffers": buffers}).encode()
        text += b" " * (-len(text) % 4)
        chunks = struct.pack("<II", len(text), 0x4E4F534A) + text
        if data:
            chunks += struct.pack("<II", len(data), 0x004E4942) + data
        return b"glTF" + struct.pack("<II", 2, 12 + len(chunks)) + chunks

    def gltf(self, uri=None):
        """Return the bytes of a .gltf whose buffer is at `uri`, or within it."""
        uri = uri or "data:application/octet-stream;base64," + base64.b64encode(self.data).decode()
        buffers = [{"byteLength": len(self.data), "uri": uri}]
        return json.dumps({**self.json, "buffers": buffers}).encode()

    def write(self, path):
        """Write the file at `path`, of the kind that it ends in."""
        path.write_bytes(self.glb() if path.suffix == ".glb" else self.gltf())
        return path


def encoded(pixels, kind="PNG"):
    """Return the bytes of a picture."""
    stream = io.BytesIO()
    Image.fromarray(np.asarray(pixels, np.uint8)).save(stream, kind)
    return stream.getvalue()


def figure_scene():
    """Return a glass square with two bones, a morph target and two animations."""
    writer = GltfWriter()
    picture = {"index": writer.picture([[[200, 100, 50, 128]]])}
    shine = {"baseColorTexture": picture, "metallicRoughnessTexture": {**picture, "texCoord": 1}}
    glass = {"KHR_materials_transmission": {"transmissionFactor": 0.5}}
    material = writer.add(
        "materials", pbrMetallicRoughness=shine, alphaMode="BLEND", extensions=glass
    )
    weights = np.tile(np.float32([0.5, 0.5, 0, 0]), (4, 1))
    bones = np.tile(np.uint8([0, 1, 0, 0]), (4, 1))
    uvs = {"TEXCOORD_0": SQUARE_UVS, "TEXCOORD_1": SQUARE_UVS / 2}
    attributes = {"JOINTS_0": bones, "WEIGHTS_0": weights, **uvs}
    mesh = writer.mesh(attributes=attributes, material=material)
    shape = {"POSITION": writer.accessor(SQUARE[::-1].copy())}
    writer.json["meshes"][mesh]["primitives"][0]["targets"] = [shape]
    joints = [writer.node(), writer.node(translation=[0, 1, 0])]
    data = np.tile(np.eye(4, dtype=np.float32), (2, 1, 1)).tobytes()
    matrices = writer.add(
        "accessors", bufferView=writer.view(data), componentType=5126, count=2, type="MAT4"
    )
    writer.add("skins", joints=joints, inverseBindMatrices=matrices)
    node = writer.node(mesh=mesh, skin=0)
    writer.animate(joints[1], "translation", [0, 1], [[0, 1, 0], [1, 1, 0]])
    writer.animate(node, "weights", [0, 1], [0, 1])
    lines = writer.mesh(SQUARE, None, mode=2)
    writer.node(mesh=lines, **writer.light(type="spot", intensity=5e4))
    return writer


def square_scene():
    """Return one square of one node."""
    writer = GltfWriter()
    writer.node(mesh=writer.mesh())
    return writer
