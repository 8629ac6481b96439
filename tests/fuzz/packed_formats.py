"""Compressed parts of glTF files for the fuzzers, which damage the bytes that C libraries unpack.

A file is such a part alone, and is read as a part of a glTF file whose JSON is whole; damage to
whole files seldom gets behind the JSON.
"""

import struct
from pathlib import Path

import DracoPy
import meshopt
import numpy as np

from heatlens.media.scene.gltf.compressed import KTX2_HEAD
from support.compressed_files import DRACO, RED_KTX2, square_with_ktx2
from support.gltf_files import GltfWriter

_SIDE = 6
_CODINGS = {"sequential": 0, "edgebreaker": 5, "edgebreaker_slow": 10}  # and their levels
_KINDS = {0: ("POSITION", 3), 1: ("NORMAL", 3), 2: ("COLOR_0", 4), 3: ("TEXCOORD_0", 2)}
_MESHOPT = "EXT_meshopt_compression"
# First bytes of blocks of UASTC in eight of its modes; all are valid.
_MODES = (0, 1, 2, 3, 5, 6, 9, 23)
# Mode, filter, and bytes of a vertex, of a view that meshoptimizer packed.
_VIEWS = {
    "positions": ("ATTRIBUTES", "NONE", 12),
    "exponents": ("ATTRIBUTES", "EXPONENTIAL", 12),
    "normals": ("ATTRIBUTES", "OCTAHEDRAL", 4),
    "turns": ("ATTRIBUTES", "QUATERNION", 8),
    "triangles": ("TRIANGLES", "NONE", 4),
    "indices": ("INDICES", "NONE", 4),
}


def write_parts_alone(folder: Path) -> list[Path]:
    """Write meshes of Draco in its codings, views of meshoptimizer, and pictures."""
    parts = {f"{name}.drc": _draco(name) for name in _CODINGS}
    parts |= {f"{name}.meshopt": _view(name) for name in _VIEWS}
    parts |= {"etc1s.ktx2": RED_KTX2, "uastc.ktx2": _uastc()}
    for name, data in parts.items():
        (folder / name).write_bytes(data)
    return [folder / name for name in parts]


def as_gltf(path: Path) -> Path:
    """Write a glTF file that holds the compressed part `path`, beside it. Return its path."""
    make = {
        ".drc": _with_mesh,
        ".meshopt": _with_view,
        ".ktx2": lambda _, data: square_with_ktx2(data),
    }
    writer = make[path.suffix](path.stem, path.read_bytes())
    return writer.write(path.with_name("packed.glb"))


def _grid() -> tuple[np.ndarray, np.ndarray]:
    """Return positions (V, 3) and triangles (T, 3) of a curved sheet."""
    rows, columns = np.divmod(np.arange(_SIDE * _SIDE), _SIDE)
    places = np.stack([columns, rows, np.sin(columns) + 0.1 * rows * rows], axis=1)
    corner = np.flatnonzero((rows < _SIDE - 1) & (columns < _SIDE - 1))
    quads = np.stack([corner, corner + 1, corner + _SIDE + 1, corner + _SIDE], axis=1)
    return places.astype(np.float32), quads[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3).astype(np.uint32)


def _draco(name: str) -> bytes:
    places, triangles = _grid()
    normals = places / np.maximum(np.linalg.norm(places, axis=1, keepdims=True), 1e-3)
    return DracoPy.encode(
        places.astype(float),
        faces=triangles,
        compression_level=_CODINGS[name],
        preserve_order=name == "sequential",
        colors=np.tile(np.uint8([9, 90, 200, 255]), (len(places), 1)),
        tex_coord=places[:, :2].astype(float),
        normals=normals.astype(float),
        normal_quantization_bits=8,
    )


def _with_mesh(stem: str, data: bytes) -> GltfWriter:
    undamaged = _draco(stem)
    numbers = {
        _KINDS[part["attribute_type"]]: part["unique_id"]
        for part in DracoPy.decode(undamaged).attributes
    }
    writer, count = GltfWriter(), _SIDE * _SIDE
    attributes = {
        name: writer.add("accessors", componentType=5126, count=count, type=f"VEC{width}")
        for name, width in numbers
    }
    extension = {
        "bufferView": writer.view(data),
        "attributes": {n: i for (n, _), i in numbers.items()},
    }
    primitive = {"attributes": attributes, "extensions": {DRACO: extension}}
    writer.node(mesh=writer.add("meshes", primitives=[primitive]))
    return writer


def _view(name: str) -> bytes:
    places, triangles = _grid()
    mode, kind, stride = _VIEWS[name]
    if mode != "ATTRIBUTES":
        return meshopt.encode_gltf_buffer(triangles.reshape(-1), mode)
    fours = np.column_stack([places, np.ones(len(places), np.float32)])
    units = (fours / np.linalg.norm(fours, axis=1, keepdims=True)).astype(np.float32)
    filtered = {
        "NONE": lambda: places,
        "EXPONENTIAL": lambda: meshopt.encode_filter_exp(places, 15),
        "OCTAHEDRAL": lambda: meshopt.encode_filter_oct(units, stride, 8),
        "QUATERNION": lambda: meshopt.encode_filter_quat(units, stride, 12),
    }
    return meshopt.encode_gltf_buffer(filtered[kind](), mode)


def _with_view(stem: str, data: bytes) -> GltfWriter:
    """Return a glTF sheet with one compressed buffer view; `turns` are instance rotations."""
    places, triangles = _grid()
    writer, count = GltfWriter(), len(places)
    normals = np.tile(np.int8([0, 0, 127]), (count, 1))
    mesh = writer.mesh(places, triangles.reshape(-1), {"NORMAL": normals})
    turns = writer.accessor(np.tile(np.int16([0, 0, 0, 32767]), (count, 1)), normalized=True)
    instancing = {"EXT_mesh_gpu_instancing": {"attributes": {"ROTATION": turns}}}
    writer.node(mesh=mesh, extensions=instancing)
    writer.json["accessors"][0]["normalized"] = True
    mode, kind, stride = _VIEWS[stem]
    number = {"normals": 0, "turns": 3}.get(stem, 1 if mode == "ATTRIBUTES" else 2)
    extension = {"buffer": 0, "byteOffset": len(writer.data), "byteLength": len(data), "mode": mode}
    extension |= {"count": count if mode == "ATTRIBUTES" else triangles.size, "byteStride": stride}
    record = writer.json["bufferViews"][number]
    record |= {"byteStride": stride} if mode == "ATTRIBUTES" else {}
    record["extensions"] = {_MESHOPT: extension | {"filter": kind}}
    writer.data += data + bytes(-len(data) % 4)
    return writer


def _uastc() -> bytes:
    """Return a picture of 32 x 4 pixels in UASTC, whose header is that of KTX 2."""
    blocks = b"".join(bytes([mode, 0x37, 0x5A, 0x91, 0xFF]) + bytes(11) for mode in _MODES)
    kind = struct.pack("<IHHHHBBBB4B8B", 44, 0, 0, 2, 40, 166, 1, 2, 0, 3, 3, 0, 0, 16, *bytes(7))
    kind += struct.pack("<HBBIII", 0, 127, 3, 0, 0, 0xFFFFFFFF)
    start = len(KTX2_HEAD) + 36 + 32 + 24
    head = struct.pack("<9I", 0, 1, 4 * len(_MODES), 4, 0, 0, 1, 1, 0)
    places = struct.pack("<4I2Q", start, len(kind), 0, 0, 0, 0)
    level = struct.pack("<3Q", start + len(kind) + 4, len(blocks), len(blocks))
    return KTX2_HEAD + head + places + level + kind + bytes(4) + blocks
