"""Define the generator type of all work that is done in steps."""

from collections.abc import Generator
from typing import TypeVar

Result = TypeVar("Result")

# Yields the name of each pass once its work is issued to the GPU, and returns the result. A window
# can handle input between two steps.
Steps = Generator[str, None, Result]
