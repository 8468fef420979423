"""The C libraries, wrapped with cffi in API mode. Each is loaded only when it is used."""
