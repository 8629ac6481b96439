"""Media: all that is read and written: plates, scenes, documents, cameras, colour.

A file becomes values of `core` here, or arrays of colour and depth, and values become files.
What strangers send is refused here in one sentence. `live` is what runs: renderers and lenses.
No code here knows how a picture is blurred, drawn or shown, nor who asks for it.
"""
