"""Let Python processes with this folder first on PYTHONPATH stand in for Windows."""

from support.windows_standin import install

install()
