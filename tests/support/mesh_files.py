"""One small mesh in each format of meshes."""

import struct

import numpy as np

OBJ = """mtllib a.mtl
v 0 0 0
v 2 0 0
v 2 3 0
v 0 3 0
vt 0 0
vt 1 0
vt 1 1
vt 0 1
usemtl red
f 1/1 2/2 3/3
usemtl blue
f 1/1 3/3 4/4
"""
MTL = """newmtl red
Kd 1 0.25 0
Ns 100
map_Kd pic.png
newmtl blue
Kd 0 0.5 1
Ke 3 2 1
d 0.25
"""
PLY = (
    b"""ply
format binary_little_endian 1.0
element vertex 4
property float x
property float y
property float z
property uchar red
property uchar green
property uchar blue
element face 2
property list uchar int vertex_indices
end_header
"""
    + b"".join(
        struct.pack("<fffBBB", x, y, 5, 255, 0, 255) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))
    )
    + struct.pack("<BiiiBiii", 3, 0, 1, 2, 3, 0, 2, 3)
)
STL = bytes(80) + struct.pack("<I", 1) + struct.pack("<12fH", *(0, 0, 1), *range(9), 0)
PIXELS = np.array([[[1, 2, 3], [4, 5, 6]]], np.uint8)
