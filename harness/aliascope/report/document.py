"""What the page's scripts read: the report as JSON, its pictures by number."""

from __future__ import annotations

import json
import math
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from aliascope.records import Estimate, ModeRow, ReportData, SceneSection
from aliascope.report.encode import (
    PictureStore,
    counts_picture,
    error_map,
    error_scale,
    surprise_picture,
    to_text,
    worst_pixel,
)
from aliascope.report.packing import Known
from aliascope.report.pool import Curve, curve_of, in_common, pool, rounded, under_one_filter
from aliascope.report.relations import find_relations
from aliascope.report.spectra import SceneSpectra, check_size, spectra_json
from aliascope.report.trade import trade_json
from aliascope.trade import Trade

Json = Any


def document(
    data: ReportData, pictures: PictureStore, spectra: Sequence[SceneSpectra], trade: Trade
) -> dict[str, Json]:
    """The report for the page's scripts; its pictures go to `pictures`. No NaN or Infinity in it: null.

    `spectra` are those of the scenes, in their order, `trade` is what was analysed of them.

    Raises InvalidInput where a picture and its reference differ in size.
    """
    renderers = dict.fromkeys(row.renderer for scene in data.scenes for row in scene.rows)
    common = in_common(data.scenes)
    families: dict[str, None] = {}
    for scene in data.scenes:
        families.update(dict.fromkeys(f"{row.renderer}\n{row.family}" for row in scene.rows))
    return {
        "metrics": {m: asdict(data.metrics[m]) for scene in data.scenes for row in scene.rows for m in row.metrics},
        "renderers": list(renderers),
        "families": [family.split("\n", 1) for family in families],
        "scenes": [_scene(scene, data, pictures, s) for scene, s in zip(data.scenes, spectra, strict=True)],
        "pooledScenes": [scene.name for scene in common],
        "countedScenes": [scene.name for scene in under_one_filter(data.scenes)],
        "pooled": [_curve(curve) for curve in pool(common)],
        "trade": trade_json(trade),
    }


def json_text(value: Json) -> str:
    """JSON, deflated, as the text that pictures stand in too."""
    data = json.dumps(value, allow_nan=False, ensure_ascii=False, separators=(",", ":")).encode()
    return to_text(zlib.compress(data, 9))


def script_json(value: Json) -> str:
    """JSON that can stand within <script>: nothing in it ends the element or opens a comment (HTML, 13.2.5.4)."""
    text = json.dumps(value, allow_nan=False, ensure_ascii=False, separators=(",", ":"))
    for character in "<>&\u2028\u2029":
        text = text.replace(character, f"\\u{ord(character):04x}")
    return text


def _scene(scene: SceneSection, data: ReportData, pictures: PictureStore, spectra: SceneSpectra) -> dict[str, Json]:
    for row in scene.rows:
        check_size(row, scene)
    errors = [error_map(row.pixels, scene.reference) for row in scene.rows]
    relations = find_relations([scene.reference, *(row.pixels for row in scene.rows)])
    known = Known(scene.reference, relations)
    return {
        "name": scene.name,
        "title": scene.title,
        "shows": scene.shows,
        "width": scene.reference.shape[1],
        "height": scene.reference.shape[0],
        "relations": {"lines": relations.lines.tolist(), "planes": relations.planes.tolist()},
        "reference": pictures.add(scene.reference, Known(None, relations)),
        "scale": error_scale(errors),
        "mostSamples": max((int(row.counts.max()) for row in scene.rows if row.counts is not None), default=None),
        "rows": [
            {**_curve(curve_of(row)), **_picture(row, worst_pixel(error), pictures, known)}
            for row, error in zip(scene.rows, errors, strict=True)
        ],
        "spectra": spectra_json(spectra),
        "lacking": _lacking(scene, data),
    }


def _picture(row: ModeRow, worst: tuple[int, int], pictures: PictureStore, known: Known) -> dict[str, Json]:
    return {
        "picture": pictures.add(row.pixels, known, row.quantum),
        "counts": pictures.add(counts_picture(row.counts)) if row.counts is not None else None,
        "surprise": pictures.add(surprise_picture(row.p_values)) if row.p_values is not None else None,
        "worst": list(worst),
        "notFinite": int((~np.isfinite(row.pixels)).any(axis=2).sum()),
    }


def _lacking(scene: SceneSection, data: ReportData) -> list[dict[str, Json]]:
    """What has no row in this scene, one entry a renderer and reason."""
    found: dict[tuple[str, str, str], list[str]] = {}
    for failure in data.failures:
        if failure.scene == scene.name:
            found.setdefault(("failed", failure.renderer, failure.message), []).append(failure.mode)
    for cell in scene.empty:
        found.setdefault(("empty", cell.renderer, cell.reason), []).append(cell.mode)
    return [
        {"kind": kind, "renderer": renderer, "reason": reason, "modes": modes}
        for (kind, renderer, reason), modes in found.items()
    ]


def _curve(curve: Curve) -> dict[str, Json]:
    return {
        "renderer": curve.renderer,
        "mode": curve.mode,
        "label": curve.label,
        "family": curve.family,
        "spp": number(curve.samples_per_pixel),
        "rays": rounded(curve.rays_per_pixel),
        "instructions": rounded(curve.instructions),
        "cpu": _estimate(curve.cpu_seconds),
        "metrics": _estimates(curve.metrics),
        "pictures": curve.pictures,
        "missing": list(curve.missing),
    }


def _estimates(metrics: Mapping[str, Estimate]) -> dict[str, Json]:
    return {name: _estimate(estimate) for name, estimate in metrics.items()}


def _estimate(estimate: Estimate) -> list[float | None]:
    """[value, standard error], and the ends of its interval where it has one of its own."""
    found = [rounded(estimate.value, 9), rounded(estimate.standard_error)]
    return [*found, *(rounded(end) for end in estimate.interval)] if estimate.interval else found


def number(value: float | None) -> float | None:
    """A figure for JSON and CSV: None where there is none or it is not finite."""
    return float(value) if value is not None and math.isfinite(value) else None
