"""Queue the user's input, and give ImGui in each frame as much as it can interpret correctly.

ImGui sees a frame as one moment: it cannot tell which of two keys came first, and a click counts at
the position of the pointer in the previous frame. Therefore a movement, a click, a turn of the
wheel and a key with other modifiers each start a new frame. Successive movements become one, and so
do turns of the wheel. Different keys share a frame if none of them opens anything; so does text for
a field. After any other input a key waits until nothing opens or closes any more, so that it
reaches the box that the previous key opened.

While input waits, the window runs frames without drawing them (`InputQueue.waits`). If much input
waits, Escape and closing go first: earlier input is dropped, except up to the last save.
"""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field

from imgui_bundle import imgui

_K = imgui.Key
_MODS = (_K.mod_ctrl, _K.mod_shift, _K.mod_alt, _K.mod_super)
_MODIFIERS = frozenset(
    {
        *(_K.left_ctrl, _K.left_shift, _K.left_alt, _K.left_super),
        *(_K.right_ctrl, _K.right_shift, _K.right_alt, _K.right_super),
    }
)
_CTRL = int(_K.mod_ctrl)
_QUIT, _SAVE, _SAVE_AS = (_K.q, _CTRL), (_K.s, _CTRL), (_K.s, _CTRL | int(_K.mod_shift))
_MANY = 32  # number of waiting inputs from which Escape and closing go first
_SETTLED = 2  # frames without a change before a newly opened box receives keys
_NOWHERE = -3.4028234663852886e38  # ImGui's position of a pointer outside the window

Opens = Callable[[imgui.Key, int], bool]


@dataclass
class Press:
    """A key that went down, with its modifiers and the text that it types; no key: text alone."""

    key: imgui.Key | None
    mods: int = 0
    text: str = ""


@dataclass(frozen=True)
class Release:
    """A key that went up; `mods` are held from now on."""

    key: imgui.Key
    mods: int = 0


@dataclass(frozen=True)
class Motion:
    """The pointer is here now; it has left the window if `at` is None."""

    at: tuple[float, float] | None


@dataclass(frozen=True)
class Button:
    """A button of the mouse went down or up."""

    number: int
    is_down: bool
    mods: int = 0


@dataclass(frozen=True)
class Wheel:
    """The wheel was turned by so many notches."""

    across: float
    down: float


@dataclass(frozen=True)
class Focus:
    """The window has the keyboard now, or has lost it."""

    is_here: bool


Act = Press | Release | Motion | Button | Wheel | Focus


@dataclass
class _Frame:
    """The input given to one frame of ImGui."""

    presses: list[imgui.Key] = field(default_factory=list)
    mods: int | None = None  # modifiers of the presses
    is_text: bool = False
    is_closed: bool = False  # takes no more input


# ImGui has a queue of its own, `config_input_trickle_event_queue`. With it every key press took a
# frame, each typed letter three, and each frame was drawn: on a busy machine what was typed was
# worked off for minutes after the last key. A click that came in one frame with its movement did
# not reach a tab. This queue knows which inputs may share a frame, and the frames between are run
# without being drawn.
class InputQueue:
    """The user's input in order, until a frame takes it."""

    def __init__(self, opens: Opens) -> None:
        """Create it; `opens` tells whether a key with modifiers may open a box that takes keys."""
        imgui.get_io().config_input_trickle_event_queue = False  # replaced by this queue
        self._opens = opens
        self._acts: deque[Act] = deque()
        self._late: list[Release] = []  # for keys that went down in the previous frame
        self._state: object = None
        self._unchanged = _SETTLED  # frames since something opened or closed
        self.typed: list[imgui.Key] = []  # keys that went down in this frame, in their order

    @property
    def waits(self) -> bool:
        """True while input waits for a later frame."""
        return bool(self._acts or self._late)

    @property
    def saves(self) -> bool:
        """True while a save waits, before which the window must not close."""
        return self._behind_save() > 0

    def add(self, act: Act) -> None:
        """Queue an input; successive movements become one, and so do turns of the wheel."""
        last = self._acts[-1] if self._acts else None
        if isinstance(act, Press) and len(self._acts) > _MANY:
            if act.key == _K.escape:
                self._forget(0)
            elif (act.key, act.mods) == _QUIT:
                self.hurry()
        if isinstance(act, Motion) and isinstance(last, Motion):
            self._acts[-1] = act
        elif isinstance(act, Wheel) and isinstance(last, Wheel):
            self._acts[-1] = Wheel(last.across + act.across, last.down + act.down)
        else:
            self._acts.append(act)

    def add_text(self, text: str) -> None:
        """Queue a character, as the text of the key just pressed if that can type one."""
        last = self._acts[-1] if self._acts else None
        if isinstance(last, Press) and not last.text and _may_type(last.key):
            last.text = text
        else:
            self._acts.append(Press(None, text=text))

    def hurry(self) -> None:
        """Drop the input after the last save, since the window is to be closed."""
        self._forget(self._behind_save())

    def _behind_save(self) -> int:
        """Return how many inputs wait up to and including the last save."""
        saves = (
            number
            for number, act in enumerate(self._acts, 1)
            if isinstance(act, Press) and (act.key, act.mods) in (_SAVE, _SAVE_AS)
        )
        return max(saves, default=0)

    # Releases stay even if the presses before them are dropped: a key or button whose release is
    # lost would be held for ever. So does the last position of the pointer, at which the next click
    # counts.
    def _forget(self, kept: int) -> None:
        """Drop all but the first `kept` inputs, but leave no key or button down."""
        acts = list(self._acts)
        ends = dict.fromkeys(act for act in acts[kept:] if _is_end(act))
        motions = [act for act in acts[kept:] if isinstance(act, Motion)]
        self._acts = deque((*acts[:kept], *ends, *motions[-1:]))

    def hand_out(self) -> None:
        """Give ImGui the input of the frame that begins now."""
        self._look()
        frame, late = _Frame(), self._late
        self._late = []
        for release in late:
            _let_go(release)
        released = {release.key for release in late}
        while self._acts and not frame.is_closed and self._fits(frame, self._acts[0], released):
            self._give(frame, self._acts.popleft())
        self.typed = frame.presses

    def _look(self) -> None:
        """Note whether something has opened or closed in the last frame."""
        context, io = imgui.get_current_context(), imgui.get_io()
        state = len(context.open_popup_stack), context.active_id, io.want_text_input
        self._unchanged = self._unchanged + 1 if state == self._state else 0
        self._state = state

    def _fits(self, frame: _Frame, act: Act, released: set[imgui.Key]) -> bool:
        """Return True if an input can join others in the same frame."""
        is_empty = not (frame.presses or frame.is_text)
        match act:
            case Press():
                return self._press_fits(frame, act, released)
            case Release() if act.key in _MODIFIERS:
                return is_empty
            case Release():
                return True
            case _:
                return is_empty

    # A key must not overtake what the key before it opens: typed quickly, it reached the picture in
    # place of the box. How long a box takes to have the keyboard is not told, so keys wait until
    # nothing has changed for some frames. Keys that open nothing go together, in their order, which
    # ImGui does not keep; see `InputQueue.typed`.
    def _press_fits(self, frame: _Frame, act: Press, released: set[imgui.Key]) -> bool:
        if self._unchanged < _SETTLED:
            return False
        if act.key in _MODIFIERS or self._is_text(act):
            return not frame.presses
        is_again = act.key in released or act.key in frame.presses
        if is_again or frame.is_text or frame.mods not in (None, act.mods):
            return False
        return not frame.presses or not self._is_alone(act)

    def _is_text(self, act: Press) -> bool:
        return act.key is None or bool(act.text and imgui.get_io().want_text_input)

    def _is_alone(self, act: Press) -> bool:
        return act.key is None or self._opens(act.key, act.mods)

    def _give(self, frame: _Frame, act: Act) -> None:
        io = imgui.get_io()
        match act:
            case Press():
                self._press(frame, act)
            case Release() if act.key in frame.presses:
                self._late.append(act)
            case Release():
                _let_go(act)
            case Motion():
                io.add_mouse_pos_event(*(act.at or (_NOWHERE, _NOWHERE)))
                frame.is_closed = True
            case Button():
                _hold(act.mods)
                io.add_mouse_button_event(act.number, act.is_down)
                frame.is_closed = True
            case Wheel():
                io.add_mouse_wheel_event(act.across, act.down)
                frame.is_closed = True
            case Focus():
                io.add_focus_event(act.is_here)
                frame.is_closed = True

    def _press(self, frame: _Frame, act: Press) -> None:
        io = imgui.get_io()
        if self._is_text(act):
            if io.want_text_input:
                io.add_input_characters_utf8(act.text)
                frame.is_text = True
            return
        assert act.key is not None
        _hold(act.mods)
        io.add_key_event(act.key, True)
        if act.key not in _MODIFIERS:
            frame.presses.append(act.key)
            frame.mods = act.mods
            frame.is_closed = self._is_alone(act)
            self._unchanged = 0 if frame.is_closed else self._unchanged


def _may_type(key: imgui.Key | None) -> bool:
    """Return True if a key can type a character: one unknown to ImGui, or a printable one."""
    if key is None or key == _K.space:
        return True
    return _K._0 <= key <= _K.z or _K.apostrophe <= key <= _K.grave_accent or _is_pad(key)


def _is_pad(key: imgui.Key) -> bool:
    return _K.keypad0 <= key <= _K.oem102 and key != _K.keypad_enter


def _is_end(act: Act) -> bool:
    return isinstance(act, Release | Focus) or (isinstance(act, Button) and not act.is_down)


def _let_go(release: Release) -> None:
    _hold(release.mods)
    imgui.get_io().add_key_event(release.key, False)


def _hold(mods: int) -> None:
    """Tell ImGui which modifiers are held; it ignores unchanged ones."""
    for mod in _MODS:
        imgui.get_io().add_key_event(mod, bool(mods & int(mod)))
