"""Small glTF files whose meshes and pictures are compressed."""

import base64

import DracoPy
import meshopt
import numpy as np

from support.gltf_files import SQUARE, SQUARE_CORNERS, SQUARE_UVS, GltfWriter

DRACO = "KHR_draco_mesh_compression"
UP = np.tile([0.0, 0.0, 1.0], (4, 1))
# 4 x 4 pixels of (201, 0, 0, 255), in the KTX 2 that Basis Universal 2.1 writes.
RED_KTX2 = base64.b64decode(
    "q0tUWCAyMLsNChoKAAAAAAEAAAAEAAAABAAAAAAAAAAAAAAAAQAAAAEAAAABAAAAaAAAACwAAACUAAAAJAAAALgAAAAA"
    "AAAAgQAAAAAAAAA5AQAAAAAAAAEAAAAAAAAAAAAAAAAAAAAsAAAAAAAAAAIAKACjAQIAAwMAAAgAAAAAAAAAAAA/AAAA"
    "AAAAAAAA/////x8AAABLVFh3cml0ZXIAQmFzaXMgVW5pdmVyc2FsIDIuMTAAAAEAAQApAAAABQAAACsAAAAAAAAAAAAA"
    "AAAAAAABAAAAAAAAAAAAAAABwAQAAAAAAAAiApgBAAAAAABA2gkAJgAAAAAAABACwASAAAAAAAAiBqyqqqoCAMFEAAAA"
    "AAAA8l8tAJgAAAAAAABACAATAAIAAAAAiAHABAAAAAAAAAIIAAA="
)


def draco_square(data=None, has_plain_data=False):
    """Return a glTF square compressed by Draco; `data` replaces its compressed bytes."""
    packed = DracoPy.encode(
        SQUARE.astype(float),
        faces=SQUARE_CORNERS.reshape(-1, 3).astype(np.uint32),
        tex_coord=SQUARE_UVS.astype(float),
        normals=UP,
        quantization_bits=14,
    )
    numbers = {
        name: part["unique_id"]
        for part in DracoPy.decode(packed).attributes
        for kind, name in ((0, "POSITION"), (1, "NORMAL"), (3, "TEXCOORD_0"))
        if part["attribute_type"] == kind
    }
    writer = GltfWriter()
    attributes = {"NORMAL": UP.astype(np.float32), "TEXCOORD_0": SQUARE_UVS}
    mesh = writer.mesh(SQUARE, SQUARE_CORNERS, attributes)
    if not has_plain_data:
        for accessor in writer.json["accessors"]:
            del accessor["bufferView"]
    extension = {"bufferView": writer.view(packed if data is None else data), "attributes": numbers}
    writer.json["meshes"][mesh]["primitives"][0]["extensions"] = {DRACO: extension}
    writer.json["extensionsUsed"] = [DRACO]
    writer.node(mesh=mesh)
    return writer


def meshopt_square(name="EXT_meshopt_compression", **changes):
    """Return a glTF square whose buffer views are compressed by meshoptimizer."""
    writer = GltfWriter()
    mesh = writer.mesh()
    writer.more_buffers.append({"byteLength": 1000})
    for view, values, mode in ((0, SQUARE, "ATTRIBUTES"), (1, SQUARE_CORNERS, "TRIANGLES")):
        data = meshopt.encode_gltf_buffer(values, mode)
        extension = {"buffer": 0, "byteOffset": len(writer.data), "byteLength": len(data)}
        extension |= {"mode": mode, "count": len(values), "byteStride": values[0].nbytes}
        writer.data += data + bytes(-len(data) % 4)
        record = writer.json["bufferViews"][view]
        record["extensions"] = {name: extension | changes}
        record["buffer"] = 1
    writer.node(mesh=mesh)
    return writer


def square_with_ktx2(data):
    """Return a glTF square with a KTX 2 texture of the bytes `data`."""
    writer = GltfWriter()
    image = writer.add("images", bufferView=writer.view(data), mimeType="image/ktx2")
    basis = {"KHR_texture_basisu": {"source": image}}
    info = {"index": writer.add("textures", extensions=basis)}
    material = writer.add("materials", pbrMetallicRoughness={"baseColorTexture": info})
    writer.node(mesh=writer.mesh(attributes={"TEXCOORD_0": SQUARE_UVS}, material=material))
    return writer
