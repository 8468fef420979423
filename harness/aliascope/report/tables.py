"""results.csv: every figure of the report, and every cell without one with its reason."""

from __future__ import annotations

import csv
import io

from aliascope.records import Estimate, ReportData
from aliascope.report.document import number
from aliascope.report.pool import curve_of, efficiency

HEAD = ["scene", "renderer", "mode", "label", "family", "status", "reason", "pictures", "samples_per_pixel"]


def results_csv(data: ReportData) -> str:
    """The text of results.csv: RFC 4180 but for its line ends, one row a scene, renderer and mode; empty where unknown.

    `status` is "measured", "empty" (the renderer cannot draw the scene) or "failed".
    """
    metrics = list(dict.fromkeys(m for scene in data.scenes for row in scene.rows for m in row.metrics))
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    figures = ["cpu_seconds", *metrics]
    writer.writerow([*HEAD, *(x for f in figures for x in (f, f"{f}_standard_error")), "efficiency", "output_quantum"])
    for scene in data.scenes:
        for row in scene.rows:
            estimates = [row.cpu_seconds, *(row.metrics.get(m, Estimate(None)) for m in metrics)]
            writer.writerow(
                [scene.name, row.renderer, row.mode, row.label, row.family, "measured", "", row.pictures]
                + [number(row.samples_per_pixel)]
                + [number(x) for e in estimates for x in (e.value, e.standard_error)]
                + [number(efficiency(curve_of(row))), number(row.quantum)]
            )
        for cell in scene.empty:
            writer.writerow(_without(scene.name, cell.renderer, cell.mode, "empty", cell.reason, len(figures)))
    for cell in data.undrawn:
        writer.writerow(_without(cell.scene, cell.renderer, cell.mode, "empty", cell.reason, len(figures)))
    for failure in data.failures:
        name, message = failure.scene, failure.message
        writer.writerow(_without(name, failure.renderer, failure.mode, "failed", message, len(figures)))
    return out.getvalue()


def _without(scene: str, renderer: str, mode: str, status: str, reason: str, figures: int) -> list[object]:
    head: list[object] = [scene, renderer, mode, "", "", status, " ".join(reason.split()), "", ""]
    return head + [None] * (2 * figures + 2)
