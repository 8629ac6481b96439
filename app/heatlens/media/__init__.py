"""Media: everything that is read and written: plates, scenes, documents, cameras and color.

A file becomes values of `core` or arrays of color and depth here, and values become files. A file
that cannot be used is refused here with one sentence. `live` holds what runs while the program
shows a picture: connections to renderers and lenses. No code here knows how a picture is blurred,
drawn or shown, nor who asks for it.
"""
