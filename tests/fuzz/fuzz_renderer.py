"""The files that make other programs renderers."""

from __future__ import annotations

import fuzzing

with fuzzing.counted(__name__):
    from aliascope.errors import AliascopeError
    from aliascope.renderers import external_file


def one_input(data: bytes) -> None:
    path = fuzzing.written("r.toml", data)
    try:
        file = external_file.read(path)
    except AliascopeError as error:
        fuzzing.refused(error, path.name)
        return
    assert file.forms
    for name in file.forms:
        assert file.command_of(name)


if __name__ == "__main__":
    fuzzing.main(one_input)
