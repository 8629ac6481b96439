"""Let Python processes with this folder first on PYTHONPATH stand in for macOS."""

from support.macos_standin import install

install()
