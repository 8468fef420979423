"""Specs of modes, as renderers read them: with specs of samplers, filters and estimators within. The first byte says
whose."""

from __future__ import annotations

import fuzzing

with fuzzing.counted(__name__):
    from aliascope import specs
    from aliascope.errors import AliascopeError
    from aliascope.renderers import BUILT_IN, mode_of

RENDERERS = tuple(BUILT_IN[name] for name in sorted(BUILT_IN))


def one_input(data: bytes) -> None:
    renderer = RENDERERS[data[0] % len(RENDERERS) if data else 0]
    text = data[1:].decode("utf-8", errors="replace")
    try:
        mode = mode_of(renderer, text)
    except AliascopeError as error:
        fuzzing.refused(error)
        return
    assert mode_of(renderer, mode.text).text == mode.text
    assert mode_of(renderer, specs.spelled_out(mode)).text == mode.text
    assert specs.settings(mode)
    assert specs.label(mode)


if __name__ == "__main__":
    fuzzing.main(one_input)
