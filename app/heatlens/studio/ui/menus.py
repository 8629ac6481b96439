"""Lay out the menus: the order of their items, the groups, and the keys.

One line for each item: its name, then its keys, then `repeats` (it runs repeatedly while the key is
held) or `alone` (keys typed after it wait, since it may move the keyboard focus). A line is drawn
between groups at "-", and a name that ends in "*" stands for all names with that beginning. Names
and keys of the overlays are those of their records.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass

from heatlens.core.model.view import overlays

_MENUS = """
File
  Open...                               Ctrl+O
  Open reference...                     Ctrl+Shift+O
  Add a picture behind...
  Open the demo
  Start screen...
  -
  Open shot...
  Save shot                             Ctrl+S
  Save shot as...                       Ctrl+Shift+S
  Reload                                Ctrl+R
  -
  Save picture...                       Ctrl+Shift+E
  Import camera...
  Import grade...
  Import framing lines...
  Export...                             Ctrl+E
  Pull sheet...
  Copy picture                          Ctrl+C
  -
  Share with a tablet...
  -
  Quit                                  Ctrl+Q
Edit
  Undo                                  Ctrl+Z          repeats
  Redo                                  Ctrl+Shift+Z    repeats
Lens
  Focus nearer                          [               repeats
  Focus farther                         ]               repeats
  Open 1/3 stop                         Shift+[         repeats
  Close 1/3 stop                        Shift+]         repeats
  -
  Focus at infinity
  Focus on the other surface here       Y
  Reset lens
  Keep the size of a mark               S
  -
  Keep this look                        Shift+L
  Back to the lens before               Backspace
  Look 1                                Ctrl+1
  Look 2                                Ctrl+2
  Look 3                                Ctrl+3
  Look 4                                Ctrl+4
  Look 5                                Ctrl+5
  Look 6                                Ctrl+6
  Look 7                                Ctrl+7
  Look 8                                Ctrl+8
  Look 9                                Ctrl+9
  -
  Next quality                          Q
  Next bokeh                            B
Play
  Play or stop                          Space
  Play backwards                        Shift+Space
  Next frame                            Right           repeats
  Previous frame                        Left            repeats
  First frame                           Home
  Last frame                            End
  -
  Next shot                             Ctrl+Right
  Previous shot                         Ctrl+Left
  -
  Next key                              Down
  Previous key                          Up
  -
  Set in point                          I
  Set out point                         O
  Clear in and out                      Shift+I
  Render frames ahead
  -
  Clear rendered frames
  Rendered frames...
Animate
  Set key                               K
  Delete keys                           Delete
  -
  Set mark here                         M
  Pull focus...                         Shift+M
  Reverse the pull
  Record a pull                         Shift+R
  Hold the focus from here              H
  -
  Auto key                              A
  Select all keys                       Ctrl+Shift+A
  Copy keys                             Ctrl+Shift+C
  Paste keys                            Ctrl+Shift+V
  Move keys later                       Ctrl+Shift+Right   repeats
  Move keys earlier                     Ctrl+Shift+Left    repeats
  -
  Interpolate *
  -
  Show curve                            Shift+C
  Set camera key
  Camera follows the focal length
  Focal length follows the camera
View
  Depth of field                        D
  -
  Fit                                   F
  1:1                                   1
  Zoom in                               +               repeats
  Zoom out                              -               repeats
  -
  Pixel grid                            G
  Values in pixels                      Shift+G
  Ruler                                 N
  Loupe                                 Shift+D
  -
  Brighter                              Ctrl+Up         repeats
  Darker                                Ctrl+Down       repeats
  Reset exposure and gamma              Ctrl+0
  Grade of the shot
  -
  Metres or feet                        U
  Larger interface                      Ctrl++
  Smaller interface                     Ctrl+-
  Interface as large as usual
  Light theme
  -
  Focus peaking                         Shift+P
  (overlays)
  -
  Matte *
  -
  Safe areas
  Thirds
  Centre cross
  -
  Frame selected
Compare
  Wipe                                  W
  Flip to B                             X
  Difference                            E
  Grid of looks                         Shift+W
  -
  More gain                             .
  Less gain                             ,
  -
  B is the reference                    R
  -
  Compare with *
Window
  Picture alone                         Tab             alone
  Full screen                           F11             alone
  Second window with the picture        F12             alone
  Names of looks in the second window
  -
  Lens
  Display
  Plate
  Scene
  Export
  Marks
  Plan
  Looks
  Reel
  Guides
  Timeline
  Speed                                 T
  -
  Reset layout
Help
  Find a command...                     Ctrl+Shift+P
  Go to the menus                       F10             alone
  Keys                                  ?               alone
"""


@dataclass(frozen=True)
class Item:
    """An item of a menu; `is_first` has a line drawn above it."""

    menu: str
    name: str
    shortcut: str = ""
    repeats: bool = False
    is_alone: bool = False
    is_first: bool = False


def _lines() -> Iterator[str]:
    for line in _MENUS.strip().splitlines():
        if line.strip() == "(overlays)":
            yield from (f"  {overlay.words}  {overlay.key}" for overlay in overlays.OVERLAYS)
        else:
            yield line


def items() -> tuple[Item, ...]:
    """Return the items of all menus, in their order."""
    rows, menu, is_first = [], "", False
    for line in _lines():
        words = re.split(r"\s{2,}", line.strip())
        if not line.startswith(" "):
            menu = line
        elif words != ["-"]:
            name, shortcut, how = (*words, "", "")[:3]
            rows.append(Item(menu, name, shortcut, how == "repeats", how == "alone", is_first))
        is_first = words == ["-"]
    return tuple(rows)


MENUS = tuple(dict.fromkeys(item.menu for item in items()))
