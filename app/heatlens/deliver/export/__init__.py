"""Export a shot to files, frame by frame; exports can be resumed, and files are never partial."""
