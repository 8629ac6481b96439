"""Arrange meshes, materials and lights of a scene as shaders read them."""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from heatlens.media.scene.material import MapPlace, Material
from heatlens.media.scene.scene import Mesh, PointLight, Scene
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.resources import Sampling, Texture, TextureArray
from heatlens.render.gpu.shader_constants import MATERIALS_ACROSS, MOST_LIGHTS
from heatlens.render.gpu.textures import new_texture, upload

MAPS = 5  # number of maps of a material
UNLIT, BLENDED = 1, 2  # flags of a material, the same as in lib/scene.lib.glsl
VERTEX = np.dtype([("position", "f4", 3), ("u", "f4"), ("normal", "f4", 3), ("v", "f4")])
BUMPY_VERTEX = np.dtype([*VERTEX.descr, ("tangent", "f4", 4)])
INSTANCE = np.dtype(  # matrices column by column, as in GLSL
    [("to_world", "f4", (4, 4)), ("to_object", "f4", (4, 4)), ("numbers", "u4", 4)]
)
_VEC4 = ("f4", 4)
_SIDE_MOST_PX = 2048  # largest side of a layer
_BYTES_MOST = 2**29  # memory of all layers together
_COMMAND_WORDS = 5  # count, instances, first index, base vertex, base instance
COMMAND_BYTES = 4 * _COMMAND_WORDS
_WHITE = np.full((1, 1, 4), 255, np.uint8)  # the only layer if the scene has no maps


def join_meshes(
    scene: Scene, has_bumps: bool
) -> tuple[npt.NDArray[np.void], npt.NDArray[np.uint32], npt.NDArray[np.int64]]:
    """Return all vertices, all triangles, and each mesh's first triangle with the total last."""
    first_vertex = np.cumsum([0] + [len(mesh.positions_m) for mesh in scene.meshes])
    first_triangle = np.cumsum([0] + [len(mesh.triangles) for mesh in scene.meshes])
    vertices = np.zeros(int(first_vertex[-1]), BUMPY_VERTEX if has_bumps else VERTEX)
    triangles = np.zeros((int(first_triangle[-1]), 3), np.uint32)
    for i, mesh in enumerate(scene.meshes):
        vertices[first_vertex[i] : first_vertex[i + 1]] = vertex_records(mesh, has_bumps)
        triangles[first_triangle[i] : first_triangle[i + 1]] = mesh.triangles + first_vertex[i]
    return vertices, triangles, first_triangle


def vertex_records(mesh: Mesh, has_bumps: bool) -> npt.NDArray[np.void]:
    """Return VERTEX of each vertex of a mesh, or BUMPY_VERTEX if `has_bumps`."""
    records = np.zeros(len(mesh.positions_m), BUMPY_VERTEX if has_bumps else VERTEX)
    records["position"], records["normal"] = mesh.positions_m, mesh.normals
    records["u"], records["v"] = mesh.uvs.T
    if has_bumps and mesh.tangents is not None:
        records["tangent"] = mesh.tangents
    return records


def colors_of(meshes: Sequence[Mesh]) -> bytes:
    """Return RGBA of all vertices as half floats; white and opaque for meshes without colors."""
    colors = np.ones((sum(len(mesh.positions_m) for mesh in meshes), 4), np.float16)
    first = 0
    for mesh in meshes:
        last = first + len(mesh.positions_m)
        if mesh.colors is not None:
            colors[first:last, : mesh.colors.shape[1]] = mesh.colors
        first = last
    return colors.tobytes()


def more_uvs_of(meshes: Sequence[Mesh]) -> bytes:
    """Return the second texture coordinates of all vertices; the first ones by default."""
    parts = [mesh.uvs if mesh.more_uvs is None else mesh.more_uvs for mesh in meshes]
    return np.concatenate(parts).astype(np.float32).tobytes()


def placements_of(materials: Sequence[Material]) -> bytes:
    """Return two vec4 for each map of each material, which say where the map lies on a surface.

    The first is a matrix (2, 2). The second has an offset u, v, the number of the set of texture
    coordinates, and how the map continues beyond its edges along u and v, as one number.
    """
    records = np.zeros((len(materials), MAPS, 8), np.float32)
    for record, material in zip(records, materials, strict=True):
        for row, place in zip(record, material.map_places or (MapPlace(),) * MAPS, strict=True):
            u, v = place.wraps
            row[:] = *np.ravel(place.matrix), *place.offset, place.coordinates, u + 4 * v
    return records.tobytes()


def draw_commands(
    meshes: npt.NDArray[np.int64],
    first_triangle: npt.NDArray[np.int64],
    is_drawn: npt.NDArray[np.bool_],
) -> npt.NDArray[np.uint32]:
    """Return the commands (M, 5) of indirect draws, one for each run of instances of one mesh.

    `meshes` is the mesh of each instance, sorted, and `is_drawn` whether it is drawn;
    `first_triangle` is that of each mesh.
    """
    drawn = np.flatnonzero(is_drawn)
    is_next = (np.diff(drawn, prepend=-2) == 1) & (np.diff(meshes[drawn], prepend=-1) == 0)
    starts = np.flatnonzero(~is_next)
    base_instance, count = drawn[starts], np.diff(starts, append=len(drawn))
    mesh = meshes[base_instance]
    commands = np.zeros((len(starts), _COMMAND_WORDS), np.uint32)
    # the words of a command, see _COMMAND_WORDS; the base vertex stays 0
    commands[:, 0] = 3 * (first_triangle[mesh + 1] - first_triangle[mesh])
    commands[:, 1], commands[:, 2], commands[:, 4] = count, 3 * first_triangle[mesh], base_instance
    return commands


# Of a buffer, Mesa's software driver reads number by number for each pixel of a draw, and of a
# texture all four at once.
def materials_of(ctx: Device, materials: Sequence[Material]) -> Texture:
    """Return five texels for each material, MATERIALS_ACROSS of them side by side.

    They are those of `Material` in lib/scene.lib.glsl, with -1 for a map that does not exist.
    """
    across = min(len(materials), MATERIALS_ACROSS)
    down = -(-len(materials) // MATERIALS_ACROSS)
    texels = np.zeros((down * across, 5, 4), np.float32)
    for texel, material in zip(texels, materials, strict=False):
        flags = UNLIT * (not material.is_lit) + BLENDED * material.is_blended
        maps = (material.base_color_map, material.metallic_roughness_map, material.emission_map)
        texel[:] = (
            (*material.base_color, material.base_alpha),
            (*material.emission, material.alpha_cutoff),
            (material.roughness, material.metallic, material.normal_scale, material.occlusion),
            [_layer_or_none(number) for number in (*maps, material.normal_map)],
            (_layer_or_none(material.occlusion_map), flags, 0, 0),
        )
    texture = new_texture(ctx, (5 * across, down), 4, label="materials")
    upload(texture, texels.reshape(down, 5 * across, 4))
    return texture


def _layer_or_none(number: int | None) -> int:
    """Return the layer of a map, -1 for none."""
    return -1 if number is None else number


# As for materials: a lamp took longer to read of a buffer than to compute.
def light_uniforms(lights: tuple[PointLight, ...]) -> dict[str, object]:
    """Return the uniforms of the brightest MOST_LIGHTS lights, three vec4 for each.

    The last number of each vec4 has the cosines of the inner and outer cone, and the kind: 0 for a
    light without direction, 1 or 2 for a cone, 2 with a smooth edge.
    """
    brightest = sorted(lights, key=lambda light: -max(light.intensity))[:MOST_LIGHTS]
    rows = np.zeros((MOST_LIGHTS, 3, 4), np.float32)
    for row, light in zip(rows, brightest, strict=False):
        inner, outer = light.cone_cosines
        row[:2] = (*light.position_m, inner), (*light.intensity, outer)
        if light.direction is not None:
            length = max(float(np.linalg.norm(light.direction)), 1e-12)
            row[2] = (*np.divide(light.direction, length), 1.0 + light.is_smooth)
    return {
        "light_count": len(brightest),
        "light_rows": tuple(tuple(map(float, vec4)) for vec4 in rows.reshape(-1, 4)),
    }


def maps_of(ctx: Device, images: Sequence[npt.NDArray[np.uint8]]) -> TextureArray:
    """Return `images` (H, W, 4) as layers of one texture, resampled to the same size.

    The texture is read bilinearly, repeated beyond its edges, and has no mipmaps.
    """
    images = images or [_WHITE]
    size = layer_size(images)
    layers = np.stack([_resample(image, size) for image in images])
    maps = ctx.texture_array((*size, len(images)), 4, layers.tobytes())
    maps.sampling = Sampling.LINEAR
    maps.repeats = True
    return maps


def _resample(image: npt.NDArray[np.uint8], size: tuple[int, int]) -> npt.NDArray[np.uint8]:
    """Return an image (H, W, 4) resampled to `size` (width, height)."""
    if image.shape[1::-1] == size:
        return image
    from PIL import Image

    channels = [Image.fromarray(np.ascontiguousarray(image[..., i])) for i in range(4)]
    # Channel by channel: Pillow would weight colors by alpha, which is not coverage here.
    resized = [channel.resize(size, Image.Resampling.BILINEAR) for channel in channels]
    return np.stack([np.asarray(channel) for channel in resized], axis=-1)


def layer_size(images: Sequence[npt.NDArray[np.uint8]]) -> tuple[int, int]:
    """Return the (width, height) of the largest image, halved until all layers fit into memory."""
    height = min(max(image.shape[0] for image in images), _SIDE_MOST_PX)
    width = min(max(image.shape[1] for image in images), _SIDE_MOST_PX)
    while 4 * width * height * len(images) > _BYTES_MOST:
        width, height = max(width // 2, 1), max(height // 2, 1)
    return width, height
