"""Depth of field by tracing rays through the lens, the truth for the other methods.

Cook, Porter and Carpenter 1984, "Distributed ray tracing". The light at the end of a ray is that of
`SceneRaster`; only the way to it differs.
"""

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from heatlens.core.model.lens.pupil import Pupil
from heatlens.media.scene.scene_view import SceneView
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.program import ComputeProgram, groups_for
from heatlens.render.gpu.resources import Buffer, Image, Texture
from heatlens.render.gpu.shader_constants import RAY_GROUP
from heatlens.render.gpu.textures import OpeningTextures, TexturePool
from heatlens.render.scene_gpu.accumulation import SIDES_LAYERS
from heatlens.render.scene_gpu.bvh import (
    NODE,
    MeshTrees,
    build_instance_tree,
    build_mesh_trees,
    refit_tree,
)
from heatlens.render.scene_gpu.raster import SceneRaster
from heatlens.render.scene_gpu.scene_buffers import SceneBuffers
from heatlens.render.scene_gpu.scene_records import INSTANCE

_SHADER = "scene_gpu/ray_trace.comp.glsl"
_DEFINES = ("HOLES", "MAPS", "COLORS", "BUMPS", "PLACEMENTS")  # variants of the shader
_RAYS_PER_STEP = 2**17  # some tenths of a second on a processor, so that the window responds
_INSTANCE_TREE_BYTES = 8  # `InstanceTree` of lib/bvh.lib.glsl


class RayTracer:
    """Traces rays, and keeps their sum so far, so that more rays cost only the new ones."""

    def __init__(self, ctx: Device, raster: SceneRaster) -> None:
        self._ctx = ctx
        self._raster = raster
        self._defines: dict[str, int] = {}
        self._program = ComputeProgram(ctx, _SHADER)
        self._pool = TexturePool(ctx)
        self._openings = OpeningTextures(ctx)
        self._trees: SceneTrees | None = None
        self._key: object = None  # identifies scene, view, lens, size and seed of the sum
        self._count = 0  # rays of each pixel in the sum

    def steps(
        self,
        view: SceneView,
        pupil: Pupil,
        rays: int,
        out: Texture,
        key: object,
        seed: int = 0,
        pixel_side_px: float = 1.0,
    ) -> Iterator[str]:
        """Render the mean of `rays` rays a pixel through `pupil` into `out`.

        `out` is RGBA float32 of the view's size, and holds the mean so far after each step. The
        caller passes equal keys only for an equal scene, view and lens; the sum for an equal key is
        continued. If `rays` is less than the rays in the sum, the sum starts again. A seed is 0
        to 2^31 - 1; pictures of different seeds are independent. `pixel_side_px` is the side of the
        square that a pixel sees, 0 for a point.
        """
        request_key = (key, view.size, seed)
        if self._key != request_key or self._count > rays:
            self._key, self._count = request_key, 0
            self._fit_trees()
        self._fit_program(self._raster.buffers.defines, pupil)
        opening = self._openings.of(pupil.aperture)
        uniforms = self._uniforms(view, pupil) | {"seed": seed, "pixel_side_px": pixel_side_px}
        for count in range(min(self._count + 1, rays), rays + 1):
            for row in range(0, view.size[1], _band_rows(view.size[0])):
                self._add(out, opening, uniforms | {"rays": count, "band_start": row})
                yield "rays"
            self._count = count

    def _fit_trees(self) -> None:
        """Fit the trees to the poses at which the rasterizer has placed its scene.

        They are built first if the scene is another one.
        """
        buffers = self._raster.buffers
        if self._trees is None or self._trees.buffers is not buffers:
            if self._trees is not None:
                self._trees.release()
            self._trees = SceneTrees(self._ctx, buffers)
        self._trees.place(self._raster.frame)

    def _fit_program(self, scene_defines: dict[str, int], pupil: Pupil) -> None:
        """Build the program with only those features that scene and lens use."""
        defines = {name: value for name, value in scene_defines.items() if name in _DEFINES}
        defines |= {name: 1 for name, is_on in pupil.switches.items() if is_on}
        if defines != self._defines:
            program = ComputeProgram(self._ctx, _SHADER, defines)
            self._program.release()
            self._program, self._defines = program, defines

    def _uniforms(self, view: SceneView, pupil: Pupil) -> dict[str, object]:
        """Return the uniforms of ray_trace.comp.glsl for the camera, the lens and the light."""
        world_from_camera = np.linalg.inv(view.world_to_camera)
        colors = {} if pupil.is_plain else {"axial_dioptres": pupil.axial_dioptres}
        return (
            self._raster.shading_uniforms()
            | pupil.uniforms(view.size)
            | colors
            | view.focus_offset.uniforms(1.0)
            | {
                "world_from_camera": tuple(world_from_camera.T.ravel().tolist()),
                "focal_px": view.focal_px,
                "focus_dioptres": 1.0 / view.focus_m,
                "depths_m": (view.near_m, view.far_m),
                "lens_middle_m": view.offset_m,
                "pixel_middle_px": view.jitter_px,
            }
        )

    def _add(self, out: Texture, opening: dict[str, Texture], uniforms: dict[str, object]) -> None:
        """Add one ray to each pixel of a band that has fewer than `rays` rays so far.

        `opening` are the textures of the lens, and `uniforms` say which band and how many rays.
        """
        assert self._trees is not None
        rows = min(_band_rows(out.width), out.height)
        images: dict[str, Image] = {
            "sum_img": self._pool.texture("sum", out.size, 4),
            "mean_img": out,
        }
        if "SHAPED" in self._defines:
            images["sides_img"] = self._pool.array("sides", out.size, SIDES_LAYERS, 4)
        self._program.dispatch(
            (groups_for(out.width, RAY_GROUP), groups_for(rows, RAY_GROUP)),
            textures={
                **self._raster.buffers.textures,
                "shadow_tx": self._raster.shadow_map,
                **opening,
            },
            images=images,
            buffers=self._trees.storage,
            uniforms=uniforms | {"top_root": self._trees.root, "is_first": self._count == 0},
        )

    def release(self) -> None:
        """Release what is on the GPU, except what belongs to the rasterizer."""
        if self._trees is not None:
            self._trees.release()
        self._program.release()
        self._openings.release()
        self._pool.release()


def _band_rows(width: int) -> int:
    """Return how many rows of a picture of this width a step traces, whole workgroups."""
    return max(_RAYS_PER_STEP // (width * RAY_GROUP), 1) * RAY_GROUP


class SceneTrees:
    """The trees of a scene on the GPU, as lib/bvh.lib.glsl reads them.

    buffers   the buffers of the scene
    root      number of the root of the tree over the instances; the nodes of the meshes' trees
              come before it
    """

    def __init__(self, ctx: Device, buffers: SceneBuffers) -> None:
        trees = build_mesh_trees(buffers.scene.meshes)
        self.buffers, self.root, self._roots = buffers, len(trees.nodes), trees.roots
        self._trees = trees if buffers.scene.deforms else None  # for fitting to other shapes
        instances = len(buffers.scene.instances)
        self._triangles = ctx.buffer(trees.triangles.tobytes() or bytes(16))
        self._nodes = ctx.buffer(self._with_instance_nodes(trees, instances).tobytes())
        self._instance_trees = ctx.buffer(reserve=_INSTANCE_TREE_BYTES * instances)

    def _with_instance_nodes(self, trees: MeshTrees, instances: int) -> NDArray[np.void]:
        """Return the nodes with space after them for a tree over the instances.

        With one instance in each leaf, it has one node less than twice as many.
        """
        return np.concatenate([trees.nodes, np.zeros(2 * instances - 1, NODE)])

    @property
    def storage(self) -> dict[str, Buffer]:
        """The blocks of lib/scene.lib.glsl and lib/bvh.lib.glsl."""
        tree_blocks = {
            "vertices_block": self.buffers.vertices,
            "triangles_block": self._triangles,
            "nodes_block": self._nodes,
            "instance_trees_block": self._instance_trees,
        }
        return self.buffers.storage | self.buffers.vertex_storage | tree_blocks

    def place(self, frame: float) -> None:
        """Move the trees to the instances on the GPU, and fit them to their shapes at a frame."""
        if self._trees is not None:
            for mesh_index, mesh in self.buffers.scene.shapes_at(frame).items():
                nodes = refit_tree(self._trees, mesh_index, mesh)
                start = int(self._roots[mesh_index]) * NODE.itemsize
                self._nodes.write(nodes.tobytes(), offset=start)
        instances = np.frombuffer(self.buffers.instances.read(), INSTANCE)
        meshes = instances["numbers"][:, 1]
        to_world = instances["to_world"].transpose(0, 2, 1).astype(np.float64)
        tree = build_instance_tree(self.buffers.boxes_m[meshes], to_world)
        nodes = tree.nodes.copy()
        # children are numbered among the nodes of all trees
        nodes["first"][nodes["count"] < 0] += self.root
        self._nodes.write(nodes.tobytes(), offset=self.root * NODE.itemsize)
        # for each leaf, its instance and the root of that mesh's tree
        instance_trees = np.stack([tree.order, self._roots[meshes[tree.order]]], axis=1)
        self._instance_trees.write(instance_trees.astype(np.int32).tobytes())

    def release(self) -> None:
        """Release the buffers that do not belong to the scene."""
        for buffer in (self._triangles, self._nodes, self._instance_trees):
            buffer.release()
