"""Name a function of another module, so that a command loads only what it needs."""

from dataclasses import dataclass
from importlib import import_module
from typing import Any


@dataclass(frozen=True)
class OnUse:
    """A function or class of another module, which is imported when it is called."""

    module: str
    name: str

    @property
    def found(self) -> Any:
        """The function or class itself."""
        return getattr(import_module(f"heatlens.{self.module}"), self.name)

    def __call__(self, *args: Any) -> Any:
        return self.found(*args)
