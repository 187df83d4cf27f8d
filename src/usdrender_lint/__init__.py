"""Lint the render spec of an OpenUSD stage."""

__version__ = "0.1.0"
