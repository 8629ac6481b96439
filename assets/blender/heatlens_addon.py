"""heatlens in Blender: plates for it, a live picture in it, and its lens and picture back.

An extension for Blender 4.2 and later, which `heatlens addon build` packs. The panel is in the
sidebar of the 3D view (N), on the tab "heatlens". Three things, each of which works alone:

Render plate   renders the frame or the range without depth of field, with depth, as multilayer
               OpenEXR; writes the lens of the camera beside it; opens both in heatlens
Live           sends what the camera sees in the viewport, or passes of Cycles that get finer, to a
               heatlens that listens, with the lens
Follow         watches the shot that heatlens saves, gives its focus, f-stop, focal length and keys
               to the camera, and shows the blurred picture as the image "heatlens"

One unit of Blender counts as a metre in what heatlens is sent, as Cycles counts it for its lens
whatever the unit scale of the scene says, so that the picture of heatlens is that of Cycles.
"""

import functools
import json
import math
import os
import socket
import struct
import tempfile
import time
from pathlib import Path

import bpy
from bpy.props import BoolProperty, IntProperty, PointerProperty, StringProperty

from .program import INSTALL, NOT_FOUND, HEATLENS_OT_install, opened_window, ran, started

# What heatlens takes.
SQUEEZE_LEAST, SQUEEZE_MOST = 1.0, 2.0
BLADES_MOST = 16
SKY_M = 1e10  # what Cycles writes where nothing is hit
LIVE_SAMPLES = (1, 4, 16, 64)  # of the passes of Cycles, each of them a whole picture
LIVE_IMAGE, LENS_IMAGE = "Blender", "heatlens.lens"
WATCH_S, WATCH_BUSY_S = 0.5, 0.1  # between two looks at the shot, and while heatlens is at work
PICTURE = "heatlens"  # the image, and the node group that shows it
SHOT_SUFFIX = ".heatlens.json"


# ---- the lens of a camera ------------------------------------------------------------------------


class NoCameraError(Exception):
    """The scene has no camera that heatlens could take; a sentence for the user."""


def camera_of(scene):
    """Return the camera of the scene. Raises NoCameraError where there is none with a lens."""
    camera = scene.camera
    if camera is None or camera.type != "CAMERA":
        raise NoCameraError("This scene has no camera: add one and make it the active camera.")
    if camera.data.type != "PERSP":
        raise NoCameraError(
            f"The camera {camera.name} is not a perspective camera, so it has no lens to blur with."
        )
    return camera


def sensor_mm(data, render):
    """Return width and height of the part of the sensor that the picture shows."""
    across = render.resolution_x * render.pixel_aspect_x
    down = render.resolution_y * render.pixel_aspect_y
    fits_width = data.sensor_fit == "HORIZONTAL" or (data.sensor_fit == "AUTO" and across >= down)
    side = data.sensor_height if data.sensor_fit == "VERTICAL" else data.sensor_width
    return (side, side * down / across) if fits_width else (side * across / down, side)


def focus_distance(camera, depsgraph):
    """Return the distance in focus along the camera's axis, in units of Blender."""
    dof = camera.data.dof
    target = dof.focus_object
    if target is None:
        return dof.focus_distance
    place = target.evaluated_get(depsgraph).matrix_world
    bones = getattr(target.pose, "bones", {})
    if dof.focus_subtarget in bones:
        place = place @ bones[dof.focus_subtarget].matrix
    eye = camera.evaluated_get(depsgraph).matrix_world
    return abs(eye.col[2].xyz.normalized().dot(eye.translation - place.translation))


def opening_of(dof):
    """Return the opening as heatlens reads it.

    Both programs have corners on the circle and turn them anticlockwise. At rotation 0 Blender has
    the middle of a blade at the right, and heatlens a corner on top.
    """
    blades = dof.aperture_blades if dof.aperture_blades <= BLADES_MOST else 0
    turn = dof.aperture_rotation + math.pi / blades - math.pi / 2 if blades else 0.0
    return {
        "blades": blades,
        "blade_rotation_deg": math.degrees(math.remainder(turn, 2 * math.pi / max(blades, 1))),
        "squeeze": min(max(dof.aperture_ratio, SQUEEZE_LEAST), SQUEEZE_MOST),
    }


def left_out(dof):
    """Return in sentences what of the opening heatlens cannot hold; "" where it holds all."""
    squeeze, said = opening_of(dof)["squeeze"], []
    if not math.isclose(squeeze, dof.aperture_ratio, rel_tol=1e-6):
        said.append(
            f"heatlens has no lens of the ratio {dof.aperture_ratio:.3g}, only from "
            f"{SQUEEZE_LEAST:g} to {SQUEEZE_MOST:g}: {squeeze:g} was taken."
        )
    if dof.aperture_blades > BLADES_MOST:
        said.append(f"{dof.aperture_blades} blades were taken for a round opening.")
    return " ".join(said)


def sample_of(scene, depsgraph):
    """Return one frame of a camera as heatlens reads it: mm, metres, world to camera."""
    camera = camera_of(scene)
    data = camera.evaluated_get(depsgraph).data
    width, height = sensor_mm(data, scene.render)
    place = camera.evaluated_get(depsgraph).matrix_world.normalized()
    return {
        "frame": scene.frame_current,
        "focal_length_mm": data.lens,
        "f_stop": data.dof.aperture_fstop,
        "focus_distance_m": focus_distance(camera, depsgraph),
        "sensor_width_mm": width,
        "sensor_height_mm": height,
        **opening_of(data.dof),
        "world_to_camera": [list(row) for row in place.inverted()],
    }


def camera_file(scene, frames):
    """Return the content of a camera file of heatlens, in JSON, over `frames`."""
    before, samples = scene.frame_current, []
    for frame in frames:
        scene.frame_set(frame)
        samples.append(sample_of(scene, bpy.context.evaluated_depsgraph_get()))
    scene.frame_set(before)
    return {
        "heatlens_camera": 1,
        "name": camera_of(scene).name,
        "frames_per_second": scene.render.fps / scene.render.fps_base,
        "up_axis": "z",
        "lens_model": "renderer",
        "samples": samples,
    }


# ---- settings for a plate, and back --------------------------------------------------------------


class PlateSettings:
    """What a plate needs of a scene; `restore` puts back all that was changed."""

    def __init__(self, scene, view_layer, path, samples=None, hidden=()):
        wanted = plate_settings(scene, view_layer, path, samples)
        wanted += [(thing, "visible_camera", False) for thing in hidden]  # shadows of it stay
        self._before = [(owner, name, getattr(owner, name)) for owner, name, _ in wanted]
        _set_all(wanted)

    def restore(self):
        """Put everything back as it was."""
        _set_all(self._before)


def _set_all(values):
    """Set properties in an order that counts: a kind of media decides which formats there are."""
    for owner, name, value in values:
        setattr(owner, name, value)


def plate_settings(scene, view_layer, path, samples):
    """Return owner, name and value of each setting of a plate."""
    render, image = scene.render, scene.render.image_settings
    # From Blender 5.0 on the kind of media comes before the format.
    media = [(image, "media_type", "MULTI_LAYER_IMAGE")] if hasattr(image, "media_type") else []
    is_cycles = render.engine == "CYCLES"
    is_denoised = is_cycles and samples is None and scene.heatlens.denoise
    return [
        *media,
        (image, "file_format", "OPEN_EXR_MULTILAYER"),
        (image, "color_depth", "32"),  # 16 bits are too few for depth
        (image, "exr_codec", "ZIP"),
        (camera_of(scene).data.dof, "use_dof", False),
        (view_layer, "use_pass_z", True),
        (view_layer, "use_pass_combined", True),
        (render, "use_compositing", False),
        (render, "use_sequencer", False),
        (render, "use_file_extension", True),
        (render, "use_overwrite", True),
        (render, "filepath", path),
        *([(scene.cycles, "samples", samples)] if is_cycles and samples is not None else []),
        *([(scene.cycles, "use_denoising", True)] if is_denoised else []),
    ]


def plate_folder(scene):
    """Return the folder of the plates. Raises OSError where a file never saved has none."""
    folder = scene.heatlens.folder
    if folder.startswith("//") and not bpy.data.filepath:
        raise OSError("Save the file of Blender first, or give a folder by its full path.")
    return Path(bpy.path.abspath(folder)).absolute()


def plate_name(scene):
    """Return the name of the plate: that of the file, the scene and the camera."""
    stem = Path(bpy.data.filepath).stem or "untitled"
    words = (stem, scene.name, camera_of(scene).name)
    return "_".join("".join(c if c.isalnum() else "-" for c in word) for word in words)


def behind_name(scene):
    """Return the name of the plate without the foreground."""
    return f"{plate_name(scene)}_behind"


def shot_path(scene):
    """Return the path of the shot that heatlens and Blender share."""
    return plate_folder(scene) / f"{plate_name(scene)}{SHOT_SUFFIX}"


# ---- render plate --------------------------------------------------------------------------------


class HEATLENS_OT_render_plate(bpy.types.Operator):
    """Render without depth of field, with depth, and open the plate in heatlens with its lens"""

    bl_idname = "heatlens.render_plate"
    bl_label = "Render Plate"

    animation: BoolProperty(name="Range", description="Render the frames of the scene, not one")

    @classmethod
    def poll(cls, context):
        """Return whether no plate is being rendered."""
        return _PLATE.settings is None

    def invoke(self, context, event):
        """Render in the render window, and go on when it is done."""
        return self._begin(context, "INVOKE_DEFAULT")

    def execute(self, context):
        """Render at once, as without a window."""
        return self._begin(context, "EXEC_DEFAULT")

    def _begin(self, context, how):
        scene = context.scene
        try:
            _PLATE.begin(scene, context.view_layer, self.animation, how)
        except (NoCameraError, OSError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        if left := left_out(camera_of(scene).data.dof):
            self.report({"WARNING"}, left)
        try:
            _PLATE.render_passes()
        except RuntimeError as error:
            _PLATE.give_up()
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        return {"FINISHED"}


class PlateRender:
    """A plate that is being rendered: its settings, and what happens when it is done.

    Where the scene names a foreground, a second pass without it shows what is behind.
    """

    def __init__(self):
        self.settings = None
        self._scene = self._view_layer = self._how = ""
        self._frames = range(0)
        self._passes = []  # names of the passes that are still to be rendered

    def begin(self, scene, view_layer, animation, how):
        """Write the lens, and note the passes."""
        first = scene.frame_start if animation else scene.frame_current
        last = scene.frame_end if animation else scene.frame_current
        self._scene, self._frames = scene.name, range(first, last + 1)
        self._view_layer, self._how = view_layer.name, how
        plate_folder(scene).mkdir(parents=True, exist_ok=True)
        lens = json.dumps(camera_file(scene, self._frames), indent=1)
        (plate_folder(scene) / f"{plate_name(scene)}.camera.json").write_text(lens)
        self._passes = [plate_name(scene)]
        if scene.heatlens.foreground is not None:
            self._passes.append(behind_name(scene))

    def render_passes(self):
        """Render all passes, or in the window of Blender the next one: its end begins another."""
        while self._passes:
            self._render_pass(self._passes.pop(0))
            if self._how == "INVOKE_DEFAULT":
                return

    def _render_pass(self, name):
        """Set the scene up, wait for the end of the rendering, and begin it."""
        scene = bpy.data.scenes[self._scene]
        is_range = len(self._frames) > 1
        number = "####" if is_range else f"{self._frames[0]:04d}"
        path = str(plate_folder(scene) / f"{name}.{number}")
        hidden = scene.heatlens.foreground.all_objects if name != plate_name(scene) else ()
        layer = scene.view_layers[self._view_layer]
        self.settings = PlateSettings(scene, layer, path, hidden=tuple(hidden))
        bpy.app.handlers.render_complete.append(self._completed)
        bpy.app.handlers.render_cancel.append(self._cancelled)
        bpy.ops.render.render(self._how, animation=is_range, write_still=not is_range)

    def give_up(self):
        """Put the scene back where no rendering has begun."""
        self._passes = []
        if self.settings is not None:
            self._stop_waiting()
            self._finish(is_whole=False)

    def _completed(self, scene, _=None):
        self._end(is_whole=True)

    def _cancelled(self, scene, _=None):
        self._passes = []
        self._end(is_whole=False)

    def _end(self, is_whole):
        """Leave the thread of the renderer, which must not change the scene."""
        self._stop_waiting()
        if bpy.app.background:
            self._finish(is_whole)
        else:
            bpy.app.timers.register(lambda: self._finish(is_whole), first_interval=0.1)

    def _stop_waiting(self):
        bpy.app.handlers.render_complete.remove(self._completed)
        bpy.app.handlers.render_cancel.remove(self._cancelled)

    def _finish(self, is_whole):
        self.settings.restore()
        self.settings = None
        if self._passes:
            if self._how == "INVOKE_DEFAULT":
                self.render_passes()
        elif is_whole:
            open_plate(bpy.data.scenes[self._scene], self._frames)


def open_plate(scene, frames):
    """Make the shot of a plate, unless it is there already, and open it in heatlens."""
    folder, name, shot = plate_folder(scene), plate_name(scene), shot_path(scene)
    number = "####" if len(frames) > 1 else f"{frames[0]:04d}"
    plate, lens = folder / f"{name}.{number}.exr", folder / f"{name}.camera.json"
    try:
        if scene.heatlens.new_shot or not shot.exists():
            words = ["--frames", f"{frames[0]}-{frames[-1]}"] if len(frames) > 1 else []
            if scene.heatlens.foreground is not None:
                words += ["--behind", folder / f"{behind_name(scene)}.{number}.exr"]
            ran("shot", "new", plate, "--camera", lens, "-o", shot, "--overwrite", *words)
            _FOLLOW.know(shot)
        if scene.heatlens.open_window and not bpy.app.background:
            opened_window("view", shot)
        said = f"{shot.name}: save it in heatlens, and the camera here follows."
        _FOLLOW.message = f"{said} {left_out(camera_of(scene).data.dof)}".strip()
    except OSError:
        _FOLLOW.message = NOT_FOUND
    except RuntimeError as error:
        _FOLLOW.message = str(error)


_PLATE = PlateRender()


# ---- bring the lens and the picture back ---------------------------------------------------------


class Follower:
    """Watches the shot of the scene; what heatlens saves goes to the camera."""

    def __init__(self):
        self.message = ""
        self._known = {}  # path of a shot -> when it was written, as it was taken over last
        self._process = None
        self._script = None
        self._picture = BlurredPicture()

    @property
    def is_busy(self):
        """Return whether heatlens is at work on a saved shot."""
        return self._process is not None or self._picture.is_busy

    def know(self, shot):
        """Note a shot as it is now: its lens is that of Blender, so there is nothing to take."""
        self._known[str(shot)] = shot.stat().st_mtime_ns

    def poll(self, scene):
        """Take a step: notice a saved shot, or take over what heatlens has made of it."""
        if message := self._picture.poll():
            self.message = message
        if self._process is not None:
            if self._process.poll() is not None:
                self._take(scene)
            return
        if not scene.heatlens.follow:
            return
        try:
            shot = shot_path(scene)
            written = shot.stat().st_mtime_ns
        except (OSError, NoCameraError):
            return
        if self._known.setdefault(str(shot), written) != written:
            self._known[str(shot)] = written
            self.ask(scene, shot)
            if scene.heatlens.picture_back:
                self._picture.ask(scene, shot)

    def ask(self, scene, shot):
        """Have heatlens write the lens of the shot as a script for Blender."""
        handle, script = tempfile.mkstemp(suffix=".py", prefix="heatlens_")
        os.close(handle)
        words = ["camera", shot, "-o", script]
        try:
            entries = json.loads(Path(shot).read_text(encoding="utf-8"))
            if "frames" not in entries and not entries.get("keys"):
                words += ["--frames", f"{scene.frame_current}-{scene.frame_current}"]
            self._process, self._script = started(*words), Path(script)
        except FileNotFoundError:
            self.message = NOT_FOUND
        except (OSError, ValueError) as error:
            self.message = f"{shot} cannot be read: {error}"

    def _take(self, scene):
        """Run the script, which sets the lens and its keys."""
        said, code = self._process.stdout.read().strip(), self._process.returncode
        text = self._script.read_text(encoding="utf-8")
        self._script.unlink(missing_ok=True)
        self._process = self._script = None
        if code != 0:
            self.message = said.splitlines()[-1] if said else "heatlens could not write its lens."
            return
        apply_lens(scene, text)
        self.message = f"The lens of {camera_of(scene).name} is that of heatlens."


def apply_lens(scene, script):
    """Run a camera script of heatlens on the camera of `scene`, whose units count as metres.

    The range of frames and the scale of units stay what they are.
    """
    units = scene.unit_settings
    before = scene.frame_start, scene.frame_end, units.scale_length
    units.scale_length = 1.0
    try:
        with bpy.context.temp_override(scene=scene):
            exec(compile(script, "heatlens camera", "exec"), {"__name__": "heatlens"})
    finally:
        scene.frame_start, scene.frame_end, units.scale_length = before
    windows = bpy.context.window_manager.windows
    if windows:
        with bpy.context.temp_override(window=windows[0]):
            bpy.ops.ed.undo_push(message="Lens from heatlens")


class BlurredPicture:
    """The frame of the shot as heatlens renders it, in the image "heatlens"."""

    def __init__(self):
        self._process = None
        self._file = None

    @property
    def is_busy(self):
        """Return whether heatlens renders."""
        return self._process is not None

    def ask(self, scene, shot):
        """Begin to render; an older picture that is still being rendered is given up."""
        if self._process is not None:
            self._process.terminate()
        self._file = Path(shot).with_name(f"{plate_name(scene)}.blurred.exr")
        try:
            self._process = started(*picture_words(scene, shot), "-o", self._file)
        except (OSError, ValueError):  # the lens is asked for with the same words, and tells
            self._process = None

    def poll(self):
        """Take the picture over if it is done. Return what went wrong, or ""."""
        if self._process is None or self._process.poll() is None:
            return ""
        process, self._process = self._process, None
        said = process.stdout.read().strip()
        if process.returncode != 0:
            return said.splitlines()[-1] if said else "heatlens could not render its picture."
        show_picture(self._file)
        return ""


def picture_words(scene, shot):
    """Return the words of heatlens that render one frame of a shot.

    It is the frame of the timeline, or that of the plate where there is only one. A shot that
    names no quality is rendered as heatlens shows it, and not as carefully as it would be exported.
    """
    entries = json.loads(Path(shot).read_text(encoding="utf-8"))
    number = entries["source"].split(".")[-2]
    frame = int(number) if number.isdigit() else scene.frame_current
    is_named = "quality" in entries.get("defocus", {})
    return ["export", shot, "--frames", frame, *([] if is_named else ["--quality", "film"])]


def show_picture(file):
    """Read a file into the image "heatlens", which whoever uses it then shows."""
    image = bpy.data.images.get(PICTURE)
    if image is None:
        image = bpy.data.images.load(str(file))
        image.name = PICTURE
    image.filepath = str(file)
    image.reload()
    group = bpy.data.node_groups.get(PICTURE)
    for node in group.nodes if group is not None else ():
        if node.bl_idname == "CompositorNodeImage":
            node.image = image


def picture_group():
    """Return the node group of the compositor that shows the picture; make it if it is missing."""
    group = bpy.data.node_groups.get(PICTURE)
    if group is not None:
        return group
    group = bpy.data.node_groups.new(PICTURE, "CompositorNodeTree")
    group.interface.new_socket("Image", in_out="OUTPUT", socket_type="NodeSocketColor")
    source, result = (group.nodes.new(kind) for kind in ("CompositorNodeImage", "NodeGroupOutput"))
    source.image = bpy.data.images.get(PICTURE)
    result.location.x = 300
    group.links.new(source.outputs[0], result.inputs[0])
    return group


def compositor_of(scene):
    """Return the nodes of the scene's compositor and the input of its result; make a missing one.

    From Blender 5.0 on the compositor is a node group, before it belonged to the scene.
    """
    if hasattr(scene, "compositing_node_group"):
        tree = scene.compositing_node_group
        if tree is None:
            tree = bpy.data.node_groups.new("Compositing", "CompositorNodeTree")
            tree.interface.new_socket("Image", in_out="OUTPUT", socket_type="NodeSocketColor")
            scene.compositing_node_group = tree
        kind = "NodeGroupOutput"
    else:
        if not scene.use_nodes:
            scene.use_nodes = True
            scene.node_tree.nodes.clear()
        tree, kind = scene.node_tree, "CompositorNodeComposite"
    results = [node for node in tree.nodes if node.bl_idname == kind]
    return tree, (results[0] if results else tree.nodes.new(kind)).inputs[0]


class HEATLENS_OT_show_in_compositor(bpy.types.Operator):
    """Add a node with the picture of heatlens to the compositor; what is linked there stays"""

    bl_idname = "heatlens.show_in_compositor"
    bl_label = "Picture in the Compositor"

    def execute(self, context):
        """Add the node, and make it the result where there is none yet."""
        tree, result = compositor_of(context.scene)
        node = tree.nodes.new("CompositorNodeGroup")
        node.node_tree, node.location.x = picture_group(), -300
        if not result.is_linked:
            tree.links.new(node.outputs[0], result)
        return {"FINISHED"}


_FOLLOW = Follower()


def watch():
    """Look after the shot of the scene in the window; Blender calls this again and again."""
    INSTALL.poll()
    if bpy.context.scene is not None:
        _FOLLOW.poll(bpy.context.scene)
    return WATCH_BUSY_S if _FOLLOW.is_busy else WATCH_S


# ---- live: the protocol of the viewer tev --------------------------------------------------------


def packet(operation, *fields):
    """Return a packet: its length, the operation, and little-endian fields."""
    body = bytes([operation]) + b"".join(_field(value) for value in fields)
    return struct.pack("<I", 4 + len(body)) + body


def _field(value):
    if isinstance(value, bool):
        return bytes([value])
    if isinstance(value, str):
        return value.encode() + b"\0"
    return value if isinstance(value, bytes) else struct.pack("<i", value)


def created(name, width, height, channels):
    """Return the packet that begins an image."""
    return packet(4, True, name, width, height, len(channels), *channels)


def updated(name, pixels, channels):
    """Return the packet that sends all pixels, (H, W, C) float32 with row 0 on top."""
    height, width, count = pixels.shape
    offsets = struct.pack(f"<{count}q", *range(count))
    strides = struct.pack(f"<{count}q", *[count] * count)
    head = (False, name, count, *channels, 0, 0, width, height, offsets, strides)
    return packet(6, *head, pixels.astype("<f4").tobytes())


def asked(path, is_first):
    """Return the packet that has a picture file read for the first time, or again."""
    return packet(7, True, str(path), "") if is_first else packet(1, False, str(path))


def lens_packets(sample):
    """Return the lens of a frame as the image of one pixel that heatlens takes it from."""
    import numpy as np

    names = ("focal_length_mm", "sensor_width_mm", "f_stop", "focus_distance_m")
    values = np.array([[[sample[name] for name in names]]], np.float32)
    return created(LENS_IMAGE, 1, 1, names) + updated(LENS_IMAGE, values, names)


class Sender:
    """A connection to a heatlens that listens; the next packet after a loss opens another."""

    def __init__(self):
        self._socket = None
        self._size = None

    def send(self, address, data):
        """Send packets. Raises OSError where nobody listens."""
        if self._socket is None:
            self._socket = socket.create_connection(address, timeout=5.0)
        try:
            self._socket.sendall(data)
        except OSError:
            self.close()
            raise

    def send_picture(self, address, pixels, sample):
        """Send (H, W, 4) float32, R, G, B and Z, and the lens."""
        height, width, _ = pixels.shape
        data = b""
        if self._socket is None or self._size != (width, height):
            data = created(LIVE_IMAGE, width, height, "RGBZ")
        self.send(address, lens_packets(sample) + data + updated(LIVE_IMAGE, pixels, "RGBZ"))
        self._size = width, height

    def close(self):
        """End the connection."""
        if self._socket is not None:
            self._socket.close()
        self._socket = self._size = None


def address_of(scene):
    """Return where heatlens listens."""
    return "127.0.0.1", scene.heatlens.port


@functools.cache
def live_folder():
    """Return a folder that nobody else can write to. It stays, as heatlens may read it again."""
    return Path(tempfile.mkdtemp(prefix="heatlens_"))


class HEATLENS_OT_live_cycles(bpy.types.Operator):
    """Render passes without depth of field that get finer, and send each; Blender waits for them"""

    bl_idname = "heatlens.live_cycles"
    bl_label = "Send Passes of the Renderer"

    def execute(self, context):
        """Render each pass into one file, which heatlens is asked to read again."""
        scene, sender = context.scene, Sender()
        path = live_folder() / "live.exr"
        try:
            sample = sample_of(scene, context.evaluated_depsgraph_get())
            is_progressive = scene.render.engine == "CYCLES"
            for number, samples in enumerate(LIVE_SAMPLES if is_progressive else (None,)):
                self._render(context, path, samples)
                data = lens_packets(sample) + asked(path, number == 0)
                sender.send(address_of(scene), data)
        except (NoCameraError, OSError) as error:
            self.report({"ERROR"}, f"{error} (start heatlens with: heatlens view --listen)")
            return {"CANCELLED"}
        finally:
            sender.close()
        return {"FINISHED"}

    def _render(self, context, path, samples):
        """Render into a file beside, which takes the place of the last one when it is whole."""
        beside = path.with_name(f"{path.stem}_next.exr")
        settings = PlateSettings(context.scene, context.view_layer, str(beside), samples)
        try:
            bpy.ops.render.render(write_still=True)
        finally:
            settings.restore()
        os.replace(beside, path)


class HEATLENS_OT_live_viewport(bpy.types.Operator):
    """Send what the camera sees in this viewport to a heatlens that listens, as it changes"""

    bl_idname = "heatlens.live_viewport"
    bl_label = "Send the Viewport"

    def invoke(self, context, event):
        """Begin to send; started again, it stops."""
        if _VIEWPORT.is_on:
            _VIEWPORT.stop()
            return {"FINISHED"}
        try:
            camera_of(context.scene)
            _VIEWPORT.start(context)
        except (NoCameraError, OSError) as error:
            self.report({"ERROR"}, f"{error} (start heatlens with: heatlens view --listen)")
            return {"CANCELLED"}
        return {"FINISHED"}


class ViewportSender:
    """Draws the scene through its camera off the screen, and sends it where something changed."""

    EVERY_S = 0.1

    def __init__(self):
        self.is_on = False
        self._changed = True
        self._own_until_s = 0.0  # what changes until then has been changed by the drawing itself
        self._sender = Sender()
        self._offscreen = None
        self._space = self._region = None

    def start(self, context):
        """Draw as this 3D view does, from now on."""
        self._space, self._region = context.space_data, context.region
        self._sender.send(address_of(context.scene), b"")
        self.is_on = self._changed = True
        bpy.app.handlers.depsgraph_update_post.append(self._note)
        bpy.app.handlers.frame_change_post.append(self._note)
        bpy.app.timers.register(self._step)

    def stop(self):
        """Send nothing any more."""
        self.is_on = False
        for handlers in (
            bpy.app.handlers.depsgraph_update_post,
            bpy.app.handlers.frame_change_post,
        ):
            if self._note in handlers:
                handlers.remove(self._note)
        self._sender.close()
        if self._offscreen is not None:
            self._offscreen.free()
        self._offscreen = None

    def _note(self, *_):
        if time.monotonic() > self._own_until_s:
            self._changed = True

    def _step(self):
        """Send one picture where something has changed; Blender calls this while it is on."""
        if not self.is_on:
            return None
        if self._changed:
            self._changed = False
            try:
                self._send(bpy.context.scene)
            except (NoCameraError, OSError, ReferenceError) as error:
                _FOLLOW.message = f"The viewport is not sent any more: {error}"
                self.stop()
                return None
        return self.EVERY_S

    def _send(self, scene):
        depsgraph = bpy.context.evaluated_depsgraph_get()
        pixels = self._drawn(scene, depsgraph)
        self._sender.send_picture(address_of(scene), pixels, sample_of(scene, depsgraph))

    def _drawn(self, scene, depsgraph):
        """Return (H, W, 4) float32: scene-linear R, G, B, and Z in units of Blender."""
        import gpu
        import numpy as np

        scale = scene.render.resolution_percentage / 100
        width = max(1, round(scene.render.resolution_x * scale))
        height = max(1, round(scene.render.resolution_y * scale))
        if self._offscreen is None or (self._offscreen.width, self._offscreen.height) != (
            width,
            height,
        ):
            self._offscreen = gpu.types.GPUOffScreen(width, height, format="RGBA32F")
        camera = camera_of(scene).evaluated_get(depsgraph)
        projection = camera.calc_matrix_camera(depsgraph, x=width, y=height)
        dof, overlays = camera_of(scene).data.dof, self._space.overlay
        before = dof.use_dof, overlays.show_overlays
        overlays.show_overlays = False
        if dof.use_dof:  # Blender tells of this as of a change by hand, a moment later
            dof.use_dof, self._own_until_s = False, time.monotonic() + 2 * self.EVERY_S
        try:
            with self._offscreen.bind():
                frame = gpu.state.active_framebuffer_get()
                self._offscreen.draw_view3d(
                    scene,
                    bpy.context.view_layer,
                    self._space,
                    self._region,
                    camera.matrix_world.normalized().inverted(),
                    projection,
                    do_color_management=False,
                )
                color = frame.read_color(0, 0, width, height, 4, 0, "FLOAT")
                depth = frame.read_depth(0, 0, width, height)
        finally:
            overlays.show_overlays = before[1]
            if before[0]:
                dof.use_dof, self._own_until_s = True, time.monotonic() + 2 * self.EVERY_S
        pixels = np.array(color, np.float32).reshape(height, width, 4)
        depth = np.array(depth, np.float64).reshape(height, width)
        pixels[..., 3] = planar_depth(depth, projection)
        return np.ascontiguousarray(pixels[::-1])


def planar_depth(depth, projection):
    """Return distances along the camera's axis from a depth buffer, 0 to 1; SKY_M for the sky.

    A projection takes z of the camera to (P22 z + P23) / -z, from -1 at the near clipping plane to
    1 at the far one.
    """
    import numpy as np

    z_ndc = 2.0 * np.asarray(depth, np.float64) - 1.0
    is_sky = z_ndc >= 1.0
    planar = projection[2][3] / np.where(is_sky, 1.0, z_ndc + projection[2][2])
    return np.where(is_sky, SKY_M, planar)


_VIEWPORT = ViewportSender()


# ---- panel, preferences, registration ------------------------------------------------------------


class HeatlensSettings(bpy.types.PropertyGroup):
    """What the panel keeps in the scene."""

    folder: StringProperty(
        name="Folder",
        description="Where plates, the lens and the shot are written",
        default="//heatlens",
        subtype="DIR_PATH",
    )
    new_shot: BoolProperty(
        name="Begin the Shot Anew",
        description="Overwrite the shot with the lens of Blender; else the shot's lens stays",
    )
    open_window: BoolProperty(
        name="Open heatlens", description="Open the plate when it is rendered", default=True
    )
    follow: BoolProperty(
        name="Follow heatlens",
        description="Give the camera the lens of the shot whenever heatlens saves it",
        default=True,
    )
    picture_back: BoolProperty(
        name="Bring the Picture Back",
        description='Render the shot whenever heatlens saves it, into the image "heatlens"',
        default=True,
    )
    foreground: PointerProperty(
        name="Foreground",
        description="A collection without which the plate is rendered once more, so that heatlens "
        "knows what is behind it",
        type=bpy.types.Collection,
    )
    denoise: BoolProperty(
        name="Denoise",
        description="Denoise the colour of the plate, whatever the scene says; depth has no noise",
    )
    port: IntProperty(
        name="Port", description="Where heatlens listens", default=14158, min=1, max=65535
    )


class HeatlensPreferences(bpy.types.AddonPreferences):
    """Where heatlens is, and what installs it."""

    bl_idname = __package__

    command: StringProperty(
        name="heatlens",
        description="The folder of heatlens or of its Python environment, or the command that "
        "starts it; empty: heatlens on the PATH",
    )

    package: StringProperty(
        name="Install From",
        description="What pip installs: a wheel of heatlens on this machine, or a name it knows",
        default="heatlens[desk]",
        subtype="FILE_PATH",
    )

    def draw(self, context):
        """Draw where heatlens is, and what installs it."""
        layout = self.layout
        layout.prop(self, "command")
        layout.prop(self, "package")
        layout.operator("heatlens.install")
        for line in _lines(INSTALL.message, letters=100) if INSTALL.message else ():
            layout.label(text=line)


class HEATLENS_PT_panel(bpy.types.Panel):
    """The tab in the sidebar of the 3D view"""

    bl_idname = "HEATLENS_PT_panel"
    bl_label = "heatlens"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "heatlens"

    def draw(self, context):
        """Draw the three parts, and what was said last."""
        layout, settings = self.layout, context.scene.heatlens
        layout.prop(settings, "folder")
        row = layout.row(align=True)
        row.operator("heatlens.render_plate", text="Frame").animation = False
        row.operator("heatlens.render_plate", text="Range").animation = True
        layout.prop(settings, "foreground")
        layout.prop(settings, "denoise")
        layout.prop(settings, "new_shot")
        layout.prop(settings, "open_window")
        layout.separator()
        layout.prop(settings, "port")
        text = "Stop Sending" if _VIEWPORT.is_on else "Send the Viewport"
        layout.operator("heatlens.live_viewport", text=text)
        layout.operator("heatlens.live_cycles")
        layout.separator()
        layout.prop(settings, "follow")
        layout.prop(settings, "picture_back")
        layout.operator("heatlens.show_in_compositor")
        if _FOLLOW.message:
            for line in _lines(_FOLLOW.message):
                layout.label(text=line)


def _lines(text, letters=40):
    """Cut a sentence into lines for a narrow panel."""
    lines = [""]
    for word in text.split():
        if len(lines[-1]) + len(word) > letters:
            lines.append("")
        lines[-1] = f"{lines[-1]} {word}".strip()
    return lines


CLASSES = (
    HeatlensSettings,
    HeatlensPreferences,
    HEATLENS_OT_render_plate,
    HEATLENS_OT_live_cycles,
    HEATLENS_OT_live_viewport,
    HEATLENS_OT_show_in_compositor,
    HEATLENS_OT_install,
    HEATLENS_PT_panel,
)


def register():
    """Add everything to Blender."""
    for one in CLASSES:
        bpy.utils.register_class(one)
    bpy.types.Scene.heatlens = PointerProperty(type=HeatlensSettings)
    bpy.app.timers.register(watch, persistent=True)


def unregister():
    """Take everything away again."""
    if bpy.app.timers.is_registered(watch):
        bpy.app.timers.unregister(watch)
    _VIEWPORT.stop()
    del bpy.types.Scene.heatlens
    for one in reversed(CLASSES):
        bpy.utils.unregister_class(one)
