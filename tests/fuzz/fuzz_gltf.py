"""Scenes in glTF. The first byte says of what: the bytes of a .glb, the text of a .gltf, or the JSON and, after a NUL,
the buffer of a .glb whose headers are right."""

from __future__ import annotations

import struct

import fuzzing

with fuzzing.counted(__name__):
    from aliascope import scene_io
    from aliascope.errors import AliascopeError
    from aliascope.gltf import document


def chunked(data: bytes) -> bytes:
    text, _, buffer = data.partition(b"\0")
    text += b" " * (-len(text) % 4)
    buffer += b"\0" * (-len(buffer) % 4)
    chunks = struct.pack("<II", len(text), document.JSON_CHUNK) + text
    chunks += struct.pack("<II", len(buffer), document.BINARY_CHUNK) + buffer
    return struct.pack("<III", document.MAGIC, 2, 12 + len(chunks)) + chunks


def one_input(data: bytes) -> None:
    kind, rest = data[:1], data[1:]
    if kind == b"g":
        path = fuzzing.written("s.glb", rest)
    elif kind == b"j":
        path = fuzzing.written("s.gltf", rest)
    else:
        path = fuzzing.written("s.glb", chunked(rest))
    try:
        file = scene_io.load_file(path)
    except AliascopeError as error:
        fuzzing.refused(error, path.name)
        return
    scene_io.describe(file)
    for note in file.notes:
        assert len(note.splitlines()) == 1, note


if __name__ == "__main__":
    fuzzing.main(one_input)
