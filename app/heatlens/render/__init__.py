"""Render: a shot and a frame in, a picture out, on the GPU.

`frame_renderer.py` is the only renderer; `defocus` has the passes of the blur, `gpu` the device.
`source` is what stands before the lens: plates, a scene or a stream.
No code here knows of a window, of commands, or of where a picture goes.
"""
