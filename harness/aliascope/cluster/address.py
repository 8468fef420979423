"""Where a scheduler is, and how the way to it is closed to others."""

from __future__ import annotations

import re
import ssl
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

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
    not there, or no certificates."""
    found = re.fullmatch(r"(tcp|tls)://(\[[0-9a-fA-F:.%]+\]|[\w.-]+):(\d{1,5})", address)
    if not found or not 0 < int(found[3]) < 65536:
        raise InvalidInput(f'"{address}" is no address of a scheduler: it is of the form tcp://HOST:8786, or tls://')
    files = {"--tls-ca": tls.authority, "--tls-cert": tls.certificate, "--tls-key": tls.key}
    given = {name: path for name, path in files.items() if path is not None}
    if given and len(given) < len(files):
        missing = [name for name in files if name not in given]
        raise InvalidInput(f"{', '.join(given)} without {', '.join(missing)}: TLS takes all three")
    if given and found[1] != "tls":
        raise InvalidInput(f"{address} is not encrypted, whatever --tls-ca says: write tls://")
    for name, path in given.items():
        if not path.is_file():
            raise InvalidInput(f"{name} {path}: there is no such file")
    if tls.authority is not None:
        _check_read(tls)
    return address


def _check_read(tls: Tls) -> None:
    """Raises InvalidInput where OpenSSL takes the files for something else."""
    context, what = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT), f"--tls-ca {tls.authority}"
    try:
        context.load_verify_locations(tls.authority)
        what = f"--tls-cert {tls.certificate} with --tls-key {tls.key}"
        assert tls.certificate is not None
        context.load_cert_chain(tls.certificate, tls.key, _no_phrase)
    except OSError as error:
        reason = error.reason if isinstance(error, ssl.SSLError) and error.reason else error.strerror or str(error)
        raise InvalidInput(f"{what}: no certificate in PEM, or not its key ({reason})") from error


def _no_phrase() -> str:
    """Without this OpenSSL would ask for it at the terminal, in each process."""
    raise InvalidInput("--tls-key: has a pass phrase; give a key without one: openssl pkey -in F.pem -out G.pem")


def security(address: str, tls: Tls, distributed: Any, role: Literal["client", "worker"]) -> Any:
    """As dask takes it. Raises InvalidInput for an encrypted address where there is nothing to show, neither given nor
    in dask's configuration: dask ends by a traceback then, or waits for long."""
    found = tls.security(distributed)
    if found is None and address.startswith("tls:"):
        try:
            context = distributed.Security().get_connection_args(role)["ssl_context"]
        except OSError as error:
            raise InvalidInput(f"the certificates of dask's configuration cannot be used: {error}") from error
        if context is None:
            raise InvalidInput(
                f"{address} asks for certificates: give --tls-ca, --tls-cert and --tls-key, or set them in dask's "
                "configuration (distributed.comm.tls)"
            )
    return found


async def reach(address: str, shown: Any, distributed: Any, role: Literal["client", "worker"], seconds: float) -> None:
    """A connection, and no more: a Client of dask that was never connected may take 40 s to end, and does it by a
    traceback, a Nanny says more than what is wrong. Raises OSError, TimeoutError, ValueError and RuntimeError."""
    arguments = (shown or distributed.Security()).get_connection_args(role)
    comm = await distributed.core.connect(address, timeout=seconds, **arguments)
    await comm.close()


def no_scheduler(address: str, error: BaseException) -> NotAvailable:
    """What to say where the way to the scheduler ended by this error, whose first cause says most."""
    reason, cause = str(error), error.__cause__
    while cause is not None:
        reason, cause = str(cause) or reason, cause.__cause__
    reason = " ".join(reason.split())[:200] or type(error).__name__
    told = f"no scheduler answers at {address} ({reason})"
    encrypted = " --protocol tls --tls-ca-file F --tls-cert F --tls-key F" if address.startswith("tls:") else ""
    advice = f"start one with `dask scheduler{encrypted}`, and on each machine `aliascope worker {address}`"
    if "refused" in reason:
        return NotAvailable(f"{told}: {advice}")
    if encrypted:
        advice = f"are these certificates of its authority, and has it TLS? If there is none, {advice}"
    else:
        advice = f"if it has TLS, write tls:// and give --tls-ca, --tls-cert and --tls-key; if there is none, {advice}"
    return NotAvailable(f"{told}: {advice}")


def distributed() -> Any:
    """dask.distributed, which takes half a second to load. Raises NotAvailable."""
    try:
        import distributed as loaded
    except ImportError as error:
        raise NotAvailable(
            f"dask.distributed cannot be loaded ({error}); install it with: pip install 'aliascope[cluster]'"
        ) from error
    return loaded
