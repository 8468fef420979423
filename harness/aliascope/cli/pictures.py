"""The commands about single pictures: render, error, reference."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from aliascope import draws
from aliascope.cli.shared import Json, Seed, Size, app, print_json, say_notes, shift_of, size_of
from aliascope.errors import InvalidInput
from aliascope.native.samplers import ARRANGEMENTS


@app.command(
    epilog="Example: aliascope render edge -r embree -m uniform:n=64 -o edge.exr; or "
    "aliascope render edge -r embree -m adaptive:method=whitted,n=72 -o edge.exr --counts counts.exr"
)
def render(
    scene: Annotated[str, typer.Argument(help="Name of a scene, or the path of its file (TOML, glTF).")],
    renderer: Annotated[str, typer.Option("-r", help="Name; see aliascope list renderers.")],
    mode: Annotated[str, typer.Option("-m", help="Spec of a mode; see aliascope list modes.")],
    out: Annotated[Path, typer.Option("-o", metavar="OUT.exr")],
    seed: Seed = 0,
    size: Size = None,
    threads: Annotated[int, typer.Option(min=1, max=256)] = 1,
    dimensions: Annotated[
        str | None,
        typer.Option(
            metavar="|".join(ARRANGEMENTS),
            help="How pixel, time, lens and lights go together, where the mode does not say: one pattern in all their "
            "dimensions; one each, shuffled against each other; one each, near in the pixel and far in the others.",
        ),
    ] = None,
    counts: Annotated[
        Path | None,
        typer.Option(metavar="COUNTS.exr", help="Of an adaptive mode: the samples of each pixel, in one channel."),
    ] = None,
    shift: Annotated[
        str | None,
        typer.Option(
            metavar="RIGHT,DOWN",
            help="Moves all that is seen on the film by so many pixels to the right and down, each from -16 to 16; "
            "the samples stay where they are in their pixels. For replicates of a mode without a seed.",
        ),
    ] = None,
    time_limit: Annotated[float, typer.Option(min=0.1, help="Seconds until the renderer gives up.")] = 600.0,
    as_json: Json = False,
) -> None:
    """Render one scene with one renderer and mode, and say what it cost."""
    from aliascope.studies.single import render_file

    say_notes([scene])
    summary = render_file(
        scene, renderer, mode, out, seed, size_of(size), threads, time_limit, counts, dimensions, shift_of(shift)
    )
    if as_json:
        print_json(summary)
    else:
        typer.echo(
            f"{out}: {summary['width']} x {summary['height']}, {_samples_of(summary)}, "
            f"{summary['cpu_seconds']:.3g} s of CPU time"
        )


def _samples_of(summary: dict[str, Any]) -> str:
    mean, counts = f"{summary['samples_per_pixel']:.4g} samples a pixel", summary["counts"]
    return f"{mean} ({counts['least']} to {counts['most']})" if counts else mean


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
    measured = metrics.measure(pair[0].pixels, pair[1].pixels, wanted, (str(image), str(reference)))
    scale = error_maps.write_map(map_, *pair, map_scale) if map_ is not None else None
    if as_json:
        details = {key: value for each in measured.values() for key, value in each.details.items()}
        if scale is not None:
            details["map-scale"] = scale
        print_json(
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


@app.command(epilog="Example: aliascope reference edge --verify; or aliascope reference spheres --shift 0.25,-0.4")
def reference(
    scenes: Annotated[list[str], typer.Argument(metavar="SCENE...", help="Names, patterns, files (TOML, glTF).")],
    verify: Annotated[bool, typer.Option("--verify", help="Make them again and compare; change nothing.")] = False,
    size: Size = None,
    filter_: Annotated[str, typer.Option("--filter", metavar="SPEC", help="See aliascope list filters.")] = "box",
    samples: Annotated[
        int | None, typer.Option(min=1, max=1 << 24, help="Of a pixel in each of 32 pictures, where it is converged.")
    ] = None,
    shift: Annotated[
        str | None,
        typer.Option(
            metavar="RIGHT,DOWN",
            help="Of the picture that is moved on the film by so many pixels, as render --shift makes it.",
        ),
    ] = None,
    all_draws: Annotated[
        bool,
        typer.Option(
            "--draws",
            help=f"Of all {draws.MOST} draws of modes without seeds: the picture in its place, and moved by "
            f"{' and '.join(draws.text_of(draws.shift_of(draw)) for draw in range(1, draws.MOST))}.",
        ),
    ] = False,
    out: Annotated[Path | None, typer.Option("-o", metavar="DIR", help="Instead of the project's own.")] = None,
    as_json: Json = False,
) -> None:
    """Make the references of scenes, or check those that are there: exact if possible, else converged."""
    from aliascope import places
    from aliascope.studies import selection, single
    from aliascope.studies.progress import progress_bar

    say_notes(scenes)
    if all_draws and shift is not None:
        raise InvalidInput("--draws has its own shifts: give it or --shift, not both")
    shifts = [draws.shift_of(draw) for draw in range(draws.MOST)] if all_draws else [shift_of(shift)]
    folder = out or places.REFERENCES if verify else places.kept_in(out, "-o")
    work = single.verify_reference if verify else single.make_reference
    with progress_bar() as tell:
        results = [
            work(scene, folder, size_of(size), filter_, samples, tell, each)
            for scene in selection.scenes_of(scenes)
            for each in shifts
        ]
    if as_json:
        print_json({"references": results})
    else:
        for result in results:
            typer.echo(result["text"])
    if not all(result["holds"] for result in results):
        raise typer.Exit(1)
