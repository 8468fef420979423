"""The probes, a module for each part of the map; each has `probes()`, which lists its own."""
