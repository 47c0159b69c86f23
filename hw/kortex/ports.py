"""Where an arm listens."""

from __future__ import annotations

TCP_PORT = 10000
UDP_PORT = 10001
