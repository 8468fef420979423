"""The commands that set renderers side by side: compare and agree."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from aliascope import logs
from aliascope.cli.shared import (
    ClusterAddress,
    Json,
    Size,
    TlsCa,
    TlsCert,
    TlsKey,
    app,
    begin_log,
    cluster_of,
    command_said,
    print_json,
    say_notes,
    size_of,
)
from aliascope.draws import UNMOVED, text_of
from aliascope.errors import InvalidInput
from aliascope.native.samplers import ARRANGEMENTS


@app.command(epilog="Example: aliascope compare edge discs -r embree -r povray --profile quick -o results")
def compare(
    scenes: Annotated[
        list[str] | None, typer.Argument(metavar="[SCENE...]", help="Names, patterns, files (TOML, glTF).")
    ] = None,
    renderer: Annotated[list[str] | None, typer.Option("-r", help="Renderer; may stand several times.")] = None,
    mode: Annotated[
        list[str] | None, typer.Option("-m", help="Mode, or a pattern of the profile's; may stand several times.")
    ] = None,
    profile: Annotated[
        str, typer.Option(help="quick (3 seeds, or 3 places of the film for modes without) or full (16 seeds).")
    ] = "quick",
    out: Annotated[Path, typer.Option("-o", metavar="DIR")] = Path("aliascope-results"),
    processes: Annotated[
        int, typer.Option("-j", min=1, max=64, help="Jobs side by side; more than 1 inflates their times.")
    ] = 1,
    dimensions: Annotated[
        list[str] | None,
        typer.Option(metavar="|".join(ARRANGEMENTS), help="Of modes that do not say; may stand several times."),
    ] = None,
    size: Size = None,
    time_limit: Annotated[float, typer.Option(min=0.1, help="Seconds that one job may take.")] = 120.0,
    dry_run: Annotated[bool, typer.Option("--dry-run", help="Say what would be rendered, and end.")] = False,
    cluster: ClusterAddress = None,
    tls_ca: TlsCa = None,
    tls_cert: TlsCert = None,
    tls_key: TlsKey = None,
    explain: Annotated[
        bool, typer.Option("--explain", help="Say what would move where, and how much of it, and end.")
    ] = False,
    resume: Annotated[bool, typer.Option("--resume", help="Go on in a folder that must be there already.")] = False,
    as_json: Json = False,
) -> None:
    """Render scenes with all renderers and modes, measure them, and write a report.

    Each picture is a timed run of its own, one at a time. Pictures that the folder already has are not rendered again.
    Samplers of plugins: --plugin or --trust-plugin FILE, then uniform:sampler=NAME.
    """
    from aliascope.studies import selection

    if resume and not (out / "results.sqlite").is_file():
        raise InvalidInput(f"{out}: has no results to resume; leave --resume out to begin")
    say_notes(scenes or [])
    plan = selection.plan_of(scenes or [], renderer or [], mode or [], profile, size_of(size), dimensions or [])
    elsewhere = cluster_of(cluster, tls_ca, tls_cert, tls_key, plan)
    if explain:
        _explain(plan, out, time_limit, elsewhere, as_json)
        return
    if dry_run:
        _dry_run(plan, as_json)
        return
    from aliascope.folder_lock import locked
    from aliascope.pipeline import Options
    from aliascope.studies import compare as study
    from aliascope.studies.progress import progress_bar

    begin_log(out)
    with locked(out), progress_bar() as progress:
        options = Options(processes, time_limit)
        result = study.compare(plan, out, options, command_said(), progress, logs.warn, cluster=elsewhere)
    summary = study.summary(result, plan)
    if as_json:
        print_json(summary)
    else:
        for line in study.summary_lines(result, plan):
            typer.echo(line)
    if summary["failed"]:
        raise typer.Exit(4)


@app.command(epilog="Example: aliascope agree spheres edge -r embree -r povray -o agreement")
def agree(
    scenes: Annotated[
        list[str] | None, typer.Argument(metavar="[SCENE...]", help="Names, patterns, files (TOML, glTF).")
    ] = None,
    renderer: Annotated[list[str] | None, typer.Option("-r", help="Renderer; may stand several times.")] = None,
    size: Annotated[str, typer.Option("--size", metavar="WxH", help="Pixels of the pictures.")] = "64x48",
    samples: Annotated[
        int,
        typer.Option(min=2, max=4096, help="Of a pixel in each picture of POV-Ray; the others take 8 times as many."),
    ] = 32,
    replicates: Annotated[int, typer.Option(min=4, max=1024, help="Pictures of each renderer, other seeds each.")] = 16,
    seed: Annotated[int, typer.Option(min=0, max=2**19, help="Of the random numbers.")] = 0,
    processes: Annotated[int, typer.Option("-j", min=1, max=64, help="Pictures side by side.")] = 8,
    time_limit: Annotated[float, typer.Option(min=0.1, help="Seconds that one picture may take.")] = 600.0,
    out: Annotated[Path | None, typer.Option("-o", metavar="DIR", help="report.html and results.json there.")] = None,
    as_json: Json = False,
) -> None:
    """Test whether the renderers' converged pictures of each scene agree: pixels, blocks, whole pictures, known flaws.

    Ends with exit code 1 where two differ by more than their standard errors, what is known of their output, and
    chance in all tests of the run. It says what it would have found: the least gain, offset, shift and blur.
    """
    from aliascope.studies import agree as study
    from aliascope.studies import agree_text
    from aliascope.studies.progress import progress_bar

    say_notes(scenes or [])
    pixels = size_of(size)
    assert pixels is not None
    asked = study.Asked(
        tuple(scenes or ()), tuple(renderer or ()), pixels, samples, replicates, seed, processes, time_limit
    )
    with progress_bar() as tell:
        answer = study.answer(asked, tell)
    page = None
    if out is not None:
        from aliascope.studies.agree_page import write

        page = write(out, answer)
    if as_json:
        print_json(agree_text.document(answer))
    else:
        for line in agree_text.lines(answer):
            typer.echo(line)
        if page is not None:
            typer.echo(str(page))
    if not answer.holds:
        raise typer.Exit(1)


def _explain(plan: Any, folder: Path, time_limit: float, elsewhere: Any, as_json: bool) -> None:
    from aliascope.pipeline import Options
    from aliascope.studies import explain

    unable: dict[str, str] = {}
    if elsewhere is not None:
        with elsewhere as there:
            unable = there.without_worker()
    told = explain.document(plan, folder, Options(time_limit=time_limit), unable)
    if as_json:
        print_json(told)
    else:
        for line in explain.lines(told):
            typer.echo(line)


def _dry_run(plan: Any, as_json: bool) -> None:
    from aliascope.studies import compare as study

    if as_json:
        shown = ("scene", "renderer", "mode", "seed", "shift")
        jobs = [{name: getattr(job, name) for name in shown} for job in plan.jobs]
        print_json({"jobs": jobs, "skipped": dict(plan.skipped), "empty": study.empty_cells(plan)})
    else:
        _dry_run_lines(plan)
    study.check_drawn(plan)


def _dry_run_lines(plan: Any) -> None:
    from aliascope.studies import compare as study

    for job in sorted(plan.jobs, key=lambda job: (job.scene, job.renderer, job.mode, job.seed, job.shift)):
        place = "" if job.shift == UNMOVED else f"  film moved by {text_of(job.shift)}"
        typer.echo(f"{job.scene}  {job.renderer}  {job.mode}  seed {job.seed}{place}")
    typer.echo(study.counted(len(plan.jobs)))
    for name, reason in plan.skipped.items():
        typer.echo(f"skipped {name}: {reason}")
    for line in study.empty_lines(plan):
        typer.echo(line)
