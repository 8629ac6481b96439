"""Rendered frames of a shot, kept in memory and on disk, so that playing them renders nothing."""
