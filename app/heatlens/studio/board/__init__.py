"""The board that every front end drives a session with: its commands, requests and state."""
