"""Collect the materials, meshes and instances of the built-in scene."""

from dataclasses import dataclass, field, replace

from heatlens.media.scene.scene import Array, Color, Instance, Material, Mesh, PointLight


@dataclass
class DemoSet:
    """The things added to the demo so far; each new one gets the next number."""

    materials: list[Material] = field(default_factory=list)
    meshes: list[Mesh] = field(default_factory=list)
    instances: list[Instance] = field(default_factory=list)
    lights: list[PointLight] = field(default_factory=list)

    def paint(
        self, color: Color, roughness: float = 0.7, metallic: float = 0.0, name: str = ""
    ) -> int:
        """Add a material that does not shine; return its number."""
        return self.material(Material(name, color, roughness=roughness, metallic=metallic))

    def lamp(self, color: Color, radiance: float) -> int:
        """Add a material that emits its colour times `radiance`; return its number."""
        red, green, blue = (radiance * value for value in color)
        return self.material(Material("lamp", (0.0, 0.0, 0.0), emission=(red, green, blue)))

    def material(self, material: Material) -> int:
        """Add a material; return its number."""
        self.materials.append(material)
        return len(self.materials) - 1

    def mesh(self, mesh: Mesh, material: int) -> int:
        """Add a copy of a mesh with that material; return its number."""
        self.meshes.append(replace(mesh, material=material))
        return len(self.meshes) - 1

    def put(self, name: str, mesh: int, *to_world: Array) -> None:
        """Add an instance of a mesh at each of these places, all with one name."""
        self.instances += [Instance(name, mesh, matrix) for matrix in to_world]
