"""The uniforms of a view for the shaders that draw a scene."""

from heatlens.media.scene.scene import Array
from heatlens.media.scene.scene_view import SceneView


def columns(matrix: Array) -> tuple[float, ...]:
    """Return a matrix column by column, as GLSL expects it."""
    return tuple(map(float, matrix.T.ravel()))


def mesh_uniforms(view: SceneView) -> dict[str, object]:
    """Return the uniforms of scene_mesh.vert.glsl for a view."""
    return {"clip_from_world": columns(view.clip_from_world)}


def cover_uniforms(view: SceneView) -> dict[str, object]:
    """Return the uniforms of scene_cover and scene_depth for a view."""
    return (
        mesh_uniforms(view)
        | {"draw_number": -1 if view.sample is None else view.sample}
        | sample_uniforms(view)
    )


def sample_uniforms(view: SceneView) -> dict[str, object]:
    """Return the uniforms of lib/samples.lib.glsl for a view."""
    return {
        "samples_across": view.across,
        "first_row": view.first_row,
        "rows_above": view.rows_above,
    }


def eye_uniforms(view: SceneView) -> dict[str, object]:
    """Return the uniforms of scene_surface.frag.glsl for a view."""
    return {"eye_m": tuple(map(float, view.eye_m))}


def sky_uniforms(view: SceneView) -> dict[str, object]:
    """Return the uniforms of scene_sky.vert.glsl for a view."""
    return {"world_from_screen": columns(view.world_from_screen)}
