"""Scenes moved away from the origin with their camera, and scaled as a whole, for probes."""

from __future__ import annotations

from aliascope.placement import moved, scaled

__all__ = ["moved", "scaled"]
