"""The command line. Each command says what it does with an example; errors are one line and an exit code."""

from __future__ import annotations

import json
import shlex
import signal
import sys
from pathlib import Path
from typing import Annotated, Any

import typer

from aliascope.errors import AliascopeError, InvalidInput, NotWritable, near_misses

app = typer.Typer(
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    context_settings={"help_option_names": ["-h", "--help"]},
)

Json = Annotated[bool, typer.Option("--json", help="One JSON document on standard output, and nothing else there.")]
Size = Annotated[
    str | None,
    typer.Option("--size", metavar="WxH", help="Pixels; keeps the vertical extent, the horizontal follows the aspect."),
]
Seed = Annotated[int, typer.Option("--seed", min=0, max=2**64 - 1, help="Of the random numbers.")]


def _version(wanted: bool) -> None:
    if wanted:
        from aliascope.places import own_version

        typer.echo(f"aliascope {own_version()}")
        raise typer.Exit


@app.callback()
def _root(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version.")
    ] = False,
    plugin: Annotated[
        list[str] | None,
        typer.Option(metavar="F.so", help="A sampler of yours; before or after the command, any number of times."),
    ] = None,
) -> None:
    """Measures how well renderers antialias, and what that costs."""
    if plugin:
        from aliascope.native.samplers import load_plugin

        for path in plugin:
            load_plugin(path)


def _size(text: str | None) -> tuple[int, int] | None:
    if text is None:
        return None
    from aliascope.model import LARGEST_AREA, LARGEST_SIDE

    width, cross, height = text.partition("x")
    if not (cross and width.isdecimal() and height.isdecimal()):
        raise InvalidInput(f'--size "{text}" is not of the form WxH, such as 128x96')
    size = int(width), int(height)
    if not all(1 <= side <= LARGEST_SIDE for side in size) or size[0] * size[1] > LARGEST_AREA:
        raise InvalidInput(f"--size {text}: a side has 1 to {LARGEST_SIDE} pixels, a picture at most {LARGEST_AREA}")
    return size


def _print_json(document: Any) -> None:
    typer.echo(json.dumps(document, allow_nan=False))


# --- points -----------------------------------------------------------------------------------------------------------


@app.command(epilog="Example: aliascope points sobol:scramble=owen -n 64 --spectrum -o spectrum.svg")
def points(
    sampler: Annotated[
        str, typer.Argument(metavar="SAMPLER|FILE", help="Spec; see aliascope list samplers. Or a .csv or .npy file.")
    ],
    n: Annotated[int | None, typer.Option("-n", min=1, max=2**53, help="How many points.")] = None,
    d: Annotated[int | None, typer.Option("-d", min=1, max=65536, help="Dimensions of the pattern, 2.")] = None,
    seed: Seed = 0,
    pixel: Annotated[str, typer.Option(metavar="X,Y", help="Of which pixel.")] = "0,0",
    first: Annotated[int, typer.Option(min=0, max=2**53, help="Index of the first point.")] = 0,
    weights: Annotated[bool, typer.Option("--weights", help="A last column with the weight of each point.")] = False,
    statistics: Annotated[
        bool, typer.Option("--statistics", help="Minimum distance, Voronoi areas, t of a net instead.")
    ] = False,
    spectrum: Annotated[
        bool, typer.Option("--spectrum", help="Radial mean power and anisotropy, in dB, by frequency instead.")
    ] = False,
    dimensions: Annotated[
        str | None, typer.Option(metavar="A,B", help="Which; for statistics and spectrum 0,1 if not said.")
    ] = None,
    realisations: Annotated[
        int | None,
        typer.Option(min=1, max=10000, help="Seeds to average: 1, of a spectrum 10 if the pattern is randomised."),
    ] = None,
    cut_off: Annotated[
        int | None, typer.Option(min=1, max=2048, help="Largest frequency of the spectrum; about 4 sqrt(n).")
    ] = None,
    base: Annotated[int | None, typer.Option(min=2, max=1 << 20, help="Of the net whose t is a statistic, 2.")] = None,
    out: Annotated[
        Path | None,
        typer.Option("-o", metavar="FILE", help="A .csv, .npy (the spectrum in two dimensions), .svg or .png instead."),
    ] = None,
    as_json: Json = False,
) -> None:
    """Print the points of a sampling pattern: CSV, no header, 17 significant digits. Or their statistics, or spectrum.

    With -o a .svg or .png is a drawing: of the first two dimensions, a third as colour, or of the spectrum.
    """
    from aliascope.studies import points as study
    from aliascope.studies.point_source import open_source

    asked = study.Asked(weights, statistics, spectrum, dimensions, realisations, cut_off, base, out)
    asked.check()
    source = open_source(sampler, n, d, seed, _pixel(pixel), first)
    signal.signal(signal.SIGPIPE, signal.SIG_DFL)  # a reader that has enough, as `| head`, ends us without a word
    found = study.answer(asked, source)
    if out is not None:
        found.write(out)
    if as_json:
        _print_json(found.document())
    elif out is None:
        for text in found.texts():
            sys.stdout.write(text)


def _pixel(text: str) -> tuple[int, int]:
    try:
        x, y = (int(part) for part in text.split(","))
    except ValueError:
        raise InvalidInput(f'--pixel "{text}" is not of the form X,Y') from None
    if not all(-(2**31) <= value < 2**31 for value in (x, y)):
        raise InvalidInput(f"--pixel {text}: coordinates have 32 bits")
    return x, y


# --- list -------------------------------------------------------------------------------------------------------------


@app.command("list", epilog="Example: aliascope list modes")
def list_(
    what: Annotated[str, typer.Argument(metavar="scenes|renderers|modes|samplers|filters|metrics")],
    as_json: Json = False,
) -> None:
    """List what there is: scenes, renderers, modes, samplers, filters or metrics."""
    from aliascope.studies.lists import LISTS

    if what not in LISTS:
        raise InvalidInput(f'cannot list "{what}"{near_misses(what, LISTS)}')
    entries = LISTS[what]()
    if as_json:
        _print_json({what: entries})
        return
    for entry in entries:
        typer.echo("  ".join(str(value) for value in entry.values() if isinstance(value, str)))
        for key in entry.get("keys", []):
            typer.echo(f"    {key}")


@app.command(epilog="Example: aliascope doctor")
def doctor(as_json: Json = False) -> None:
    """Say what is installed, and measure where each renderer has its pixels and whether its output is linear.

    Ends with 1 where a renderer's pictures cannot be compared.
    """
    from aliascope.studies.doctor import examine, lines_of

    document = examine()
    if as_json:
        _print_json(document)
    else:
        for line in lines_of(document):
            typer.echo(line)
    if not all(entry.get("holds", True) for entry in document["renderers"]):
        raise typer.Exit(1)


# --- render, error, reference -----------------------------------------------------------------------------------------


@app.command(epilog="Example: aliascope render edge -r embree -m uniform:n=64 -o edge.exr")
def render(
    scene: Annotated[str, typer.Argument(help="Name of a scene, or the path of a TOML file.")],
    renderer: Annotated[str, typer.Option("-r", help="embree, povray or osmesa.")],
    mode: Annotated[str, typer.Option("-m", help="Spec of a mode; see aliascope list modes.")],
    out: Annotated[Path, typer.Option("-o", metavar="OUT.exr")],
    seed: Seed = 0,
    size: Size = None,
    threads: Annotated[int, typer.Option(min=1, max=256)] = 1,
    as_json: Json = False,
) -> None:
    """Render one scene with one renderer and mode, and say what it cost."""
    from aliascope.studies.single import render_file

    summary = render_file(scene, renderer, mode, out, seed, _size(size), threads)
    if as_json:
        _print_json(summary)
    else:
        typer.echo(
            f"{out}: {summary['width']} x {summary['height']}, {summary['samples_per_pixel']:g} samples a pixel, "
            f"{summary['cpu_seconds']:.3g} s of CPU time"
        )


@app.command(
    epilog="Example: aliascope error picture.exr reference/edge/128x96-box.exr --metric rmse,max --map map.png"
)
def error(
    image: Annotated[Path, typer.Argument(help="Any picture that OpenImageIO reads.")],
    reference: Annotated[Path, typer.Argument(help="Of the same size and channels.")],
    metric: Annotated[str | None, typer.Option(metavar="M,M...", help="Which; all of them if not said.")] = None,
    map_: Annotated[
        Path | None,
        typer.Option("--map", metavar="OUT.png|OUT.exr", help="Draw the signed error, or keep it as an EXR."),
    ] = None,
    map_scale: Annotated[
        float | None, typer.Option(metavar="S", help="The drawing goes from -S to S; to the largest if not said.")
    ] = None,
    colour_space: Annotated[
        str | None, typer.Option(metavar="srgb|linear", help="What IMAGE's values are; sRGB is decoded.")
    ] = None,
    reference_colour_space: Annotated[
        str | None, typer.Option(metavar="srgb|linear", help="What REFERENCE's values are.")
    ] = None,
    as_json: Json = False,
) -> None:
    """Measure a picture against a reference, on linear values."""
    from aliascope import metrics
    from aliascope.studies import error_maps

    wanted = metrics.chosen(metric)
    error_maps.check_map(map_, map_scale)
    pair = error_maps.open_pair(image, reference, colour_space, reference_colour_space)
    measured = metrics.measure(pair[0].pixels, pair[1].pixels, wanted)
    scale = error_maps.write_map(map_, *pair, map_scale) if map_ is not None else None
    if as_json:
        details = {key: value for each in measured.values() for key, value in each.details.items()}
        if scale is not None:
            details["map-scale"] = scale
        _print_json(
            {
                "metrics": {name: each.value for name, each in measured.items()},
                "details": details,
                "image": pair[0].document(),
                "reference": pair[1].document(),
            }
        )
        return
    for opened in pair:
        if opened.colour_space == error_maps.SRGB:
            typer.echo(f"{opened.stored.path}: {opened.stored.format}, decoded from sRGB")
    for name, each in measured.items():
        value = "none" if each.value is None else f"{each.value:.6g}"
        extra = "  ".join(f"{key} {value}" for key, value in each.details.items())
        typer.echo(f"{name:<14}{value:>14}  {extra}".rstrip())
    if map_ is not None:
        typer.echo(str(map_) if scale is None else f"{map_}: from {-scale:.3g} (blue) to {scale:.3g} (red)")


@app.command(epilog="Example: aliascope reference edge --verify")
def reference(
    scenes: Annotated[list[str], typer.Argument(metavar="SCENE...")],
    verify: Annotated[bool, typer.Option("--verify", help="Make them again and compare; change nothing.")] = False,
    size: Size = None,
    filter_: Annotated[str, typer.Option("--filter", metavar="SPEC", help="See aliascope list filters.")] = "box",
    samples: Annotated[
        int | None, typer.Option(min=1, max=1 << 24, help="Of a pixel in each of 32 pictures, where it is converged.")
    ] = None,
    out: Annotated[Path | None, typer.Option("-o", metavar="DIR", help="Instead of reference/.")] = None,
    as_json: Json = False,
) -> None:
    """Make the references of scenes, or check those that are there: exact if possible, else converged."""
    from aliascope import places
    from aliascope.studies import single

    folder = out or places.REFERENCES
    work = single.verify_reference if verify else single.make_reference
    results = [work(scene, folder, _size(size), filter_, samples) for scene in scenes]
    if as_json:
        _print_json({"references": results})
    else:
        for result in results:
            typer.echo(result["text"])
    if not all(result["holds"] for result in results):
        raise typer.Exit(1)


# --- compare ----------------------------------------------------------------------------------------------------------


@app.command(epilog="Example: aliascope compare edge discs -r embree -r povray --profile quick -o results")
def compare(
    scenes: Annotated[
        list[str] | None, typer.Argument(metavar="[SCENE...]", help="Names, patterns, TOML files.")
    ] = None,
    renderer: Annotated[list[str] | None, typer.Option("-r", help="Renderer; may stand several times.")] = None,
    mode: Annotated[
        list[str] | None, typer.Option("-m", help="Mode, or a pattern of the profile's; may stand several times.")
    ] = None,
    profile: Annotated[str, typer.Option(help="quick or full.")] = "quick",
    out: Annotated[Path, typer.Option("-o", metavar="DIR")] = Path("aliascope-results"),
    processes: Annotated[
        int, typer.Option("-j", min=1, max=64, help="Jobs side by side; more than 1 inflates their times.")
    ] = 1,
    size: Size = None,
    time_limit: Annotated[float, typer.Option(min=0.1, help="Seconds that one job may take.")] = 120.0,
    dry_run: Annotated[bool, typer.Option("--dry-run", help="Say what would be rendered, and end.")] = False,
    resume: Annotated[bool, typer.Option("--resume", help="Go on in a folder that must be there already.")] = False,
    as_json: Json = False,
) -> None:
    """Render scenes with all renderers and modes, measure them, and write a report.

    Pictures that the folder already has are not rendered again.
    """
    from aliascope.studies import selection

    if resume and not (out / "results.sqlite").is_file():
        raise InvalidInput(f"{out}: has no results to resume; leave --resume out to begin")
    plan = selection.plan_of(scenes or [], renderer or [], mode or [], profile, _size(size))
    if dry_run:
        _dry_run(plan, as_json)
        return
    from aliascope.pipeline import Options
    from aliascope.studies import compare as study
    from aliascope.studies.progress import progress_bar

    command = shlex.join(["aliascope", *sys.argv[1:]])
    with progress_bar() as progress:
        result = study.compare(
            plan, out, Options(processes, time_limit), command, progress, lambda text: typer.echo(text, err=True)
        )
    summary = study.summary(result, plan)
    if as_json:
        _print_json(summary)
    else:
        for line in study.summary_lines(result, plan):
            typer.echo(line)
    if summary["failed"]:
        raise typer.Exit(4)


def _dry_run(plan: Any, as_json: bool) -> None:
    if as_json:
        jobs = [{"scene": j.scene, "renderer": j.renderer, "mode": j.mode, "seed": j.seed} for j in plan.jobs]
        _print_json({"jobs": jobs, "skipped": dict(plan.skipped)})
        return
    for job in sorted(plan.jobs, key=lambda job: (job.scene, job.renderer, job.mode, job.seed)):
        typer.echo(f"{job.scene}  {job.renderer}  {job.mode}  seed {job.seed}")
    typer.echo(f"{len(plan.jobs)} pictures")
    for name, reason in plan.skipped.items():
        typer.echo(f"skipped {name}: {reason}")


# --- plugin -----------------------------------------------------------------------------------------------------------

plugins = typer.Typer(no_args_is_help=True, rich_markup_mode=None)
app.add_typer(
    plugins,
    name="plugin",
    help="Samplers of yours: shared objects that any command takes with --plugin.",
    epilog="Example: aliascope plugin check ./mine.so",
)


@plugins.command(epilog="Example: aliascope plugin check ./kronecker.so --spec kronecker:shift=0.25")
def check(
    file: Annotated[Path, typer.Argument(metavar="F.so", help="A shared object; csrc/plugins/ has an example.")],
    spec: Annotated[
        str | None, typer.Option(metavar="SPEC", help="Which configuration, name:key=value; its defaults if not said.")
    ] = None,
    time_limit: Annotated[float, typer.Option(min=0.1, max=86400.0, help="Seconds that one check may take.")] = 20.0,
    as_json: Json = False,
) -> None:
    """Check that a plugin's sampler keeps to the contracts of plugin.h.

    Each check runs in a process of its own. Ends with 1 where one fails, with 2 where the file is no plugin.
    """
    from aliascope.studies import plugin_check

    outcomes = []
    for outcome in plugin_check.check(file, spec, time_limit):
        outcomes.append(outcome)
        if not as_json:
            typer.echo(plugin_check.line_of(outcome))
    document = plugin_check.document(file, outcomes)
    if as_json:
        _print_json(document)
    else:
        typer.echo(plugin_check.last_line(file, outcomes))
    if not document["holds"]:
        raise typer.Exit(1)


# --- errors -----------------------------------------------------------------------------------------------------------


def _plugins_first(words: list[str]) -> list[str]:
    """The command line with each --plugin F.so before the command, where the option is declared."""
    first: list[str] = []
    rest: list[str] = []
    while words:
        word, *words = words
        if word == "--":
            return [*first, *rest, word, *words]
        if word == "--plugin" and words:
            first += [word, words.pop(0)]
        else:
            (first if word.startswith("--plugin=") else rest).append(word)
    return [*first, *rest]


def main() -> None:
    """Runs a command; ends with the exit code of the error's class, 2 for a command line that can't be read."""
    try:
        app(_plugins_first(sys.argv[1:]))
    except AliascopeError as problem:
        sys.exit(_complain(str(problem), problem.exit_code))
    except OSError as problem:
        sys.exit(_complain(str(problem), NotWritable.exit_code))


def _complain(message: str, code: int) -> int:
    print(f"aliascope: {' '.join(message.split())}", file=sys.stderr)
    return code


if __name__ == "__main__":
    main()
