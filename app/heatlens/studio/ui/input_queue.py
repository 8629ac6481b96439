"""Queue the user's input, and give ImGui in each frame as much as it can interpret correctly.

ImGui sees a frame as one moment: it does not know which of two keys came first, and a click counts
at the position of the pointer in the previous frame. Therefore a movement, a click, a turn of the
wheel and a key with other modifiers each start a new frame. Successive movements become one, and so
do turns of the wheel. Different keys share a frame if none of them opens anything; so does text for
a field. After any other input a key waits until nothing opens or closes any more, so that it
reaches the box that the previous key opened.

While input waits, the window runs frames without drawing them (`InputQueue.has_waiting`). If much
input waits, Escape and closing go first: earlier input is dropped, except up to the last save.
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
_SETTLED_FRAMES = 2  # frames without a change before a newly opened box receives keys
_NOWHERE = -3.4028234663852886e38  # ImGui's position of a pointer outside the window

OpensBox = Callable[[imgui.Key, int], bool]


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
    """The pointer is at this position now; None if it has left the window."""

    position: tuple[float, float] | None


@dataclass(frozen=True)
class Button:
    """A button of the mouse went down or up."""

    number: int
    is_down: bool
    mods: int = 0


@dataclass(frozen=True)
class Wheel:
    """The wheel was turned by a number of notches."""

    across: float
    down: float


@dataclass(frozen=True)
class Focus:
    """The window has the keyboard now, or has lost it."""

    has_keyboard: bool


InputEvent = Press | Release | Motion | Button | Wheel | Focus


@dataclass
class _Frame:
    """The input given to one frame of ImGui."""

    presses: list[imgui.Key] = field(default_factory=list)
    mods: int | None = None  # modifiers of the presses
    is_text: bool = False
    is_closed: bool = False  # takes no more input


# This queue knows which inputs may share a frame, and the frames between are run without being
# drawn. ImGui's own queue, `config_input_trickle_event_queue`, uses a frame for every key press and
# three for each typed letter, and each frame would be drawn: on a busy machine, typed text would
# appear for minutes after the last key. A click in one frame with its movement would not reach a
# tab.
class InputQueue:
    """The user's input in order, until a frame takes it."""

    def __init__(self, opens: OpensBox) -> None:
        """Create it; `opens` returns True if a key with modifiers may open a box."""
        imgui.get_io().config_input_trickle_event_queue = False  # replaced by this queue
        self._opens = opens
        self._events: deque[InputEvent] = deque()
        self._delayed_releases: list[Release] = []  # for keys that went down in the previous frame
        self._state: object = None
        self._unchanged_frames = _SETTLED_FRAMES  # frames since something opened or closed
        self.typed_keys: list[imgui.Key] = []  # keys that went down in this frame, in their order

    @property
    def has_waiting(self) -> bool:
        """True while input waits for a later frame."""
        return bool(self._events or self._delayed_releases)

    @property
    def has_waiting_save(self) -> bool:
        """True while a save waits, before which the window must not close."""
        return self._count_up_to_save() > 0

    def add(self, event: InputEvent) -> None:
        """Queue an input; successive movements become one, and so do turns of the wheel."""
        last_event = self._events[-1] if self._events else None
        if isinstance(event, Press) and len(self._events) > _MANY:
            if event.key == _K.escape:
                self._drop_after(0)
            elif (event.key, event.mods) == _QUIT:
                self.drop_after_save()
        if isinstance(event, Motion) and isinstance(last_event, Motion):
            self._events[-1] = event
        elif isinstance(event, Wheel) and isinstance(last_event, Wheel):
            self._events[-1] = Wheel(last_event.across + event.across, last_event.down + event.down)
        else:
            self._events.append(event)

    def add_text(self, text: str) -> None:
        """Queue a character, as the text of the key just pressed if that can type one."""
        last_event = self._events[-1] if self._events else None
        if isinstance(last_event, Press) and not last_event.text and _may_type(last_event.key):
            last_event.text = text
        else:
            self._events.append(Press(None, text=text))

    def drop_after_save(self) -> None:
        """Drop the input after the last save, since the window is to be closed."""
        self._drop_after(self._count_up_to_save())

    def _count_up_to_save(self) -> int:
        """Return how many inputs wait up to and including the last save."""
        save_numbers = (
            number
            for number, event in enumerate(self._events, 1)
            if isinstance(event, Press) and (event.key, event.mods) in (_SAVE, _SAVE_AS)
        )
        return max(save_numbers, default=0)

    # Releases stay even if the presses before them are dropped: a key or button whose release is
    # lost would be held forever. The last position of the pointer stays too, because the next click
    # counts there.
    def _drop_after(self, kept_count: int) -> None:
        """Drop all but the first `kept_count` inputs, but leave no key or button down."""
        events = list(self._events)
        releases = dict.fromkeys(event for event in events[kept_count:] if _must_be_kept(event))
        motions = [event for event in events[kept_count:] if isinstance(event, Motion)]
        self._events = deque((*events[:kept_count], *releases, *motions[-1:]))

    def hand_out(self) -> None:
        """Give ImGui the input of the frame that begins now, and store which keys it has."""
        self._note_changes()
        frame, delayed = _Frame(), self._delayed_releases
        self._delayed_releases = []
        for release in delayed:
            _send_release(release)
        released = {release.key for release in delayed}
        while (
            self._events
            and not frame.is_closed
            and self._fits_frame(frame, self._events[0], released)
        ):
            self._send_event(frame, self._events.popleft())
        self.typed_keys = frame.presses

    def _note_changes(self) -> None:
        """Note whether something has opened or closed in the last frame."""
        context, io = imgui.get_current_context(), imgui.get_io()
        state = len(context.open_popup_stack), context.active_id, io.want_text_input
        self._unchanged_frames = self._unchanged_frames + 1 if state == self._state else 0
        self._state = state

    def _fits_frame(self, frame: _Frame, event: InputEvent, released: set[imgui.Key]) -> bool:
        """Return True if an input can join others in the same frame."""
        is_empty = not (frame.presses or frame.is_text)
        match event:
            case Press():
                return self._press_fits(frame, event, released)
            case Release() if event.key in _MODIFIERS:
                return is_empty
            case Release():
                return True
            case _:
                return is_empty

    # A key waits until the box that the previous key opens has the keyboard: typed quickly, it
    # would reach the picture instead of the box. ImGui does not report when a box has the keyboard,
    # so keys wait until nothing has changed for some frames. Keys that open nothing share a frame,
    # in their order, which ImGui does not keep; see `InputQueue.typed_keys`.
    def _press_fits(self, frame: _Frame, press: Press, released: set[imgui.Key]) -> bool:
        """Return True if a press can join a frame in which the keys `released` went up."""
        if self._unchanged_frames < _SETTLED_FRAMES:
            return False
        if press.key in _MODIFIERS or self._is_text(press):
            return not frame.presses
        is_again = press.key in released or press.key in frame.presses
        if is_again or frame.is_text or frame.mods not in (None, press.mods):
            return False
        return not frame.presses or not self._may_open_box(press)

    def _is_text(self, press: Press) -> bool:
        """Return True if a press is text for a field."""
        return press.key is None or bool(press.text and imgui.get_io().want_text_input)

    def _may_open_box(self, press: Press) -> bool:
        """Return True if a press may open a box, so that no other key may follow in its frame."""
        return press.key is None or self._opens(press.key, press.mods)

    def _send_event(self, frame: _Frame, event: InputEvent) -> None:
        """Send an input to ImGui, and note it in the frame."""
        io = imgui.get_io()
        match event:
            case Press():
                self._send_press(frame, event)
            case Release() if event.key in frame.presses:
                self._delayed_releases.append(event)
            case Release():
                _send_release(event)
            case Motion():
                io.add_mouse_pos_event(*(event.position or (_NOWHERE, _NOWHERE)))
                frame.is_closed = True
            case Button():
                _send_modifiers(event.mods)
                io.add_mouse_button_event(event.number, event.is_down)
                frame.is_closed = True
            case Wheel():
                io.add_mouse_wheel_event(event.across, event.down)
                frame.is_closed = True
            case Focus():
                io.add_focus_event(event.has_keyboard)
                frame.is_closed = True

    def _send_press(self, frame: _Frame, press: Press) -> None:
        """Send a key, or its text to a text field; a key that may open a box ends the frame."""
        io = imgui.get_io()
        if self._is_text(press):
            if io.want_text_input:
                io.add_input_characters_utf8(press.text)
                frame.is_text = True
            return
        assert press.key is not None
        _send_modifiers(press.mods)
        io.add_key_event(press.key, True)
        if press.key not in _MODIFIERS:
            frame.presses.append(press.key)
            frame.mods = press.mods
            frame.is_closed = self._may_open_box(press)
            self._unchanged_frames = 0 if frame.is_closed else self._unchanged_frames


def _may_type(key: imgui.Key | None) -> bool:
    """Return True if a key can type a character: one unknown to ImGui, or a printable one."""
    if key is None or key == _K.space:
        return True
    return _K._0 <= key <= _K.z or _K.apostrophe <= key <= _K.grave_accent or _is_keypad(key)


def _is_keypad(key: imgui.Key) -> bool:
    return _K.keypad0 <= key <= _K.oem102 and key != _K.keypad_enter


def _must_be_kept(event: InputEvent) -> bool:
    """Return True for a release or a change of the keyboard focus, which must not be dropped."""
    return isinstance(event, Release | Focus) or (isinstance(event, Button) and not event.is_down)


def _send_release(release: Release) -> None:
    _send_modifiers(release.mods)
    imgui.get_io().add_key_event(release.key, False)


def _send_modifiers(mods: int) -> None:
    """Tell ImGui which modifiers are held; it ignores unchanged ones."""
    for mod in _MODS:
        imgui.get_io().add_key_event(mod, bool(mods & int(mod)))
