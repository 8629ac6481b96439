"""Let hatchling put the compiled shaders into wheel and sdist, see `pyproject.toml`."""

import shutil
import sys
import tempfile
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


class CompileShaders(BuildHookInterface[Any]):
    """Compiles all shaders, unless they lie here compiled, as in an sdist.

    Without the compiler the package is made without them; who draws by wgpu needs it then.
    """

    PLUGIN_NAME = "custom"
    _folder: Path | None = None

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Add the archive to the files of the package that is built."""
        if version == "editable":
            return
        root = Path(self.root)
        sys.path.insert(0, str(root / "app"))
        from heatlens.fronts.doctor.compiled_shaders import packed_shaders
        from heatlens.render.gpu.wgpu.spirv import COMPILER, PACKED, has_compiler

        if (root / "shaders" / PACKED).is_file():
            return
        if not has_compiler():
            self.app.display_warning(f"There is no {COMPILER}: no shader is compiled for wgpu.")
            return
        self._folder = Path(tempfile.mkdtemp(prefix="heatlens_packing_"))
        (self._folder / PACKED).write_bytes(packed_shaders())
        parent = "heatlens/shaders" if self.target_name == "wheel" else "shaders"
        build_data["force_include"][str(self._folder / PACKED)] = f"{parent}/{PACKED}"

    def finalize(self, version: str, build_data: dict[str, Any], artifact_path: str) -> None:
        """Delete the archive, which lies in the package now."""
        if self._folder is not None:
            shutil.rmtree(self._folder)
            self._folder = None
