"""Where a scheduler is, and how the way to it is closed to others."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from aliascope.errors import InvalidInput, NotAvailable


@dataclass(frozen=True)
class Tls:
    """The files of TLS: the authority's certificate, the own one, and its key. Without, dask's configuration holds."""

    authority: Path | None = None
    certificate: Path | None = None
    key: Path | None = None

    def security(self, distributed: Any) -> Any:
        """As dask takes it; None for what its configuration says."""
        if self.authority is None:
            return None
        certificate, key = str(self.certificate), str(self.key)
        ends = {
            f"tls_{end}_{what}": path
            for end in ("client", "worker")
            for what, path in (("cert", certificate), ("key", key))
        }
        return distributed.Security(tls_ca_file=str(self.authority), require_encryption=True, **ends)


def checked(address: str, tls: Tls) -> str:
    """The address. Raises InvalidInput for one that can't be read, for TLS with a part missing, and for files that are
    not there."""
    found = re.fullmatch(r"(tcp|tls)://(\[[0-9a-fA-F:.%]+\]|[\w.-]+):(\d{1,5})", address)
    if not found or not 0 < int(found[3]) < 65536:
        raise InvalidInput(f'"{address}" is no address of a scheduler: it is of the form tcp://HOST:8786, or tls://')
    files = {"--tls-ca": tls.authority, "--tls-cert": tls.certificate, "--tls-key": tls.key}
    given = {name: path for name, path in files.items() if path is not None}
    if given and len(given) < len(files):
        raise InvalidInput(f"{', '.join(given)} without {', '.join(set(files) - set(given))}: TLS takes all three")
    if given and found[1] != "tls":
        raise InvalidInput(f"{address} is not encrypted, whatever --tls-ca says: write tls://")
    for name, path in given.items():
        if not path.is_file():
            raise InvalidInput(f"{name} {path}: there is no such file")
    return address


def distributed() -> Any:
    """dask.distributed, which takes half a second to load. Raises NotAvailable."""
    try:
        import distributed as loaded
    except ImportError as error:
        raise NotAvailable(
            f"dask.distributed cannot be loaded ({error}); install it with: pip install 'aliascope[cluster]'"
        ) from error
    return loaded
