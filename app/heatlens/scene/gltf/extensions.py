"""The glTF extensions that are read, and unread ones that a file may still require."""

from heatlens.scene.gltf.json_values import Record

READ_EXTENSIONS = frozenset(
    {
        *("KHR_lights_punctual", "KHR_materials_emissive_strength", "KHR_mesh_quantization"),
        *("KHR_texture_transform", "EXT_texture_webp", "EXT_mesh_gpu_instancing"),
        *("KHR_materials_unlit", "KHR_materials_pbrSpecularGlossiness"),
        *("KHR_materials_transmission", "KHR_draco_mesh_compression", "KHR_texture_basisu"),
        *("EXT_meshopt_compression", "KHR_meshopt_compression"),
        *("KHR_animation_pointer", "KHR_node_visibility"),
    }
)
# A file may require these: they affect only gloss, or nothing visible.
_HARMLESS = ("KHR_materials_", "KHR_xmp")


def check_required(root: Record) -> None:
    """Raise InputError that names an extension which the file requires but is not read."""
    required = root.at("extensionsRequired").items() if root.has("extensionsRequired") else []
    for name in (item.text() for item in required):
        if name not in READ_EXTENSIONS and not name.startswith(_HARMLESS):
            root.refuse(
                f"it needs {name[:60]}, which heatlens does not support; export it without that"
            )
