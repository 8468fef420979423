"""What the scripts of a report read, out of its page."""

from __future__ import annotations

import json
import re
import zlib
from typing import Any

from aliascope.report.encode import from_text


def shown(text: str) -> dict[str, Any]:
    """The document of a page."""
    found = re.search(r'id="data">([^<]*)</script>', text)
    assert found is not None
    values: dict[str, Any] = json.loads(zlib.decompress(from_text(found[1])))
    return values
