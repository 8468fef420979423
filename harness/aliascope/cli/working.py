"""The command that works for others: a worker of a cluster."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from aliascope.cli.shared import TlsCa, TlsCert, TlsKey, app


@app.command(epilog="Example: aliascope worker tcp://boss:8786 -j 4")
def worker(
    scheduler: Annotated[str, typer.Argument(metavar="tcp://HOST:PORT", help="Where `dask scheduler` runs.")],
    count: Annotated[
        int, typer.Option("-j", min=1, max=1024, help="Workers: jobs side by side; more than 1 inflates their times.")
    ] = 1,
    renderer: Annotated[
        list[str] | None, typer.Option("-r", metavar="F.toml", help="A renderer of yours, which the plans have too.")
    ] = None,
    without: Annotated[list[str] | None, typer.Option("--without", help="A renderer that gets no jobs here.")] = None,
    memory: Annotated[
        str, typer.Option("--memory", help="Of each worker for data on their way, as 2GB; past it, it starts anew.")
    ] = "auto",
    scratch: Annotated[
        Path | None, typer.Option("--scratch", metavar="DIR", help="For files of dask; else the temporary folder.")
    ] = None,
    tls_ca: TlsCa = None,
    tls_cert: TlsCert = None,
    tls_key: TlsKey = None,
) -> None:
    """Render here what `aliascope compare --cluster` and `aliascope knobs --cluster` ask for, until Ctrl-C.

    The scheduler is told which renderers there are and in which versions, so that nothing else comes. Whoever can reach
    the scheduler can run any program here: use it in a network that you trust, or with TLS.
    """
    from aliascope import renderers
    from aliascope.cluster.address import Tls
    from aliascope.cluster.server import serve

    for path in renderer or []:
        renderers.add(path)
    serve(
        scheduler,
        count,
        Tls(tls_ca, tls_cert, tls_key),
        lambda text: typer.echo(text, err=True),
        without or (),
        memory,
        scratch,
    )
