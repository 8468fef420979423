"""Writes sobol_directions.c from Joe and Kuo's new-joe-kuo-6 numbers as SciPy carries them.

Run: .venv/bin/python csrc/sampler/make_sobol_directions.py > csrc/sampler/sobol_directions.c
"""

from pathlib import Path

import numpy as np
import scipy

DIMENSIONS = 1024


def main() -> None:
    numbers = np.load(Path(scipy.__file__).parent / "stats" / "_sobol_direction_numbers.npz")
    polynomials, initial, first = [], [], 0
    for polynomial, values in zip(numbers["poly"][:DIMENSIONS], numbers["vinit"][:DIMENSIONS], strict=True):
        degree = int(polynomial).bit_length() - 1
        polynomials.append(f"{{{degree}, {(int(polynomial) >> 1) & ((1 << max(degree - 1, 0)) - 1)}, {first}}},")
        initial.extend(str(int(value)) for value in values[:degree])
        first += degree
    print("/* Generated: .venv/bin/python csrc/sampler/make_sobol_directions.py > csrc/sampler/sobol_directions.c")
    print(" * Joe and Kuo 2008, new-joe-kuo-6.21201, as in SciPy; their licence (3-clause BSD) is in LICENSE.")
    print(" */")
    print('#include "sobol_directions.h"\n\n/* clang-format off */')
    print("const asc_sobol_polynomial asc_sobol_polynomials[ASC_SOBOL_DIMENSIONS] = {")
    print(fold(polynomials))
    print("};\n\nconst uint32_t asc_sobol_initial[] = {")
    print(fold([value + "," for value in initial]))
    print("};")


def fold(words: list[str]) -> str:
    lines, line = [], ""
    for word in words:
        if len(line) + len(word) > 117:
            lines.append(line)
            line = ""
        line += (" " if line else "  ") + word
    return "\n".join([*lines, line])


if __name__ == "__main__":
    main()
