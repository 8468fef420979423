"""Metrics of what a viewer sees, from the packages of others."""

from __future__ import annotations

import numpy as np

from aliascope.metrics.base import Array, Measured, no_value

SSIM_SIGMA = 1.5
SSIM_WINDOW = 11
"""Pixels of a side of SSIM's window: the Gaussian is cut at int(3.5 sigma + 0.5) = 5 pixels from its middle."""

SSIM_LARGEST = 2.0**15
"""The largest value whose SSIM is told. Variances are differences of mean squares, wrong by some eps v^2 = 2e-7 for
this v, and stand beside the constant (0.03)^2 = 9e-4: brighter pictures of little contrast would get any number."""


def ssim(image: Array, reference: Array) -> Measured:
    """The mean structural similarity of 11 x 11 windows, 1 for equal pictures; none for smaller pictures.

    Wang, Bovik, Sheikh and Simoncelli 2004, "Image quality assessment: from error visibility to structural similarity":
    Gaussian weights of sigma 1.5, population covariance, K1 0.01, K2 0.03, data range 1, over the windows that lie in
    the picture whole; of each channel of the linear values, then their mean. In [-1, 1].
    """
    height, width, _ = image.shape
    if min(height, width) < SSIM_WINDOW:
        return no_value("ssim", f"its windows have {SSIM_WINDOW} x {SSIM_WINDOW} pixels, the picture is smaller")
    brightest = max(np.abs(image).max(), np.abs(reference).max())
    if brightest > SSIM_LARGEST:
        return no_value("ssim", f"values up to {brightest:.3g} leave no digits for a data range of 1")
    from skimage.metrics import structural_similarity  # takes a quarter of a second to load

    value = structural_similarity(  # type: ignore[no-untyped-call]
        image,
        reference,
        data_range=1.0,
        channel_axis=2,
        gaussian_weights=True,
        sigma=SSIM_SIGMA,
        use_sample_covariance=False,
    )
    return Measured(float(value))


def flip(image: Array, reference: Array) -> Measured:
    """The mean of LDR-FLIP's map, 0 (no visible difference) to 1, clipped to [0, 1]; none but for three channels.

    Andersson et al. 2020, "FLIP: a difference evaluator for alternating images", as their package computes it from
    linear Rec. 709 values, at its 67 pixels a degree of the viewer's field. Values outside [0, 1] are clipped, as a
    display does: what differs only there is no difference.
    """
    if image.shape[2] != 3:
        return no_value("flip", f"it needs red, green and blue, and the pictures have {image.shape[2]} channels")
    import flip_evaluator  # type: ignore[import-untyped]

    # It clips too, but its documentation asks for values in [0, 1]. It takes the reference first.
    shown = [np.clip(pixels, 0.0, 1.0).astype(np.float32) for pixels in (reference, image)]
    errors, _, _ = flip_evaluator.evaluate(*shown, "LDR", inputsRGB=False, applyMagma=False, computeMeanError=False)
    # Its own mean adds up in float, whose last digits go in large pictures.
    return Measured(float(np.asarray(errors).mean(dtype=np.float64)))
