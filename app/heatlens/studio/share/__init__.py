"""Share a session with browsers: a server on a thread, and what the session's loop gives to it."""
