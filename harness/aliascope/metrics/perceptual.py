"""Metrics of what a viewer sees, from the packages of others."""

from __future__ import annotations

import numpy as np

from aliascope.metrics.base import Array, Measured, no_value

SSIM_SIGMA = 1.5
SSIM_WINDOW = 11
"""Pixels of a side of SSIM's window: the Gaussian is cut at int(3.5 sigma + 0.5) = 5 pixels from its middle."""

SSIM_CONSTANTS = (0.01**2, 0.03**2)
"""(K1 L)^2 and (K2 L)^2, of K1 0.01, K2 0.03 and the data range L 1."""

SSIM_PLAIN = 4.0
"""Up to this value variances are differences of mean squares, wrong by some eps 4^2 = 4e-15, which is 4e-12 of the
constant (0.03)^2 beside which they stand. Of brighter pictures they are those of differences from each window's middle,
which takes some times as long."""


def ssim(image: Array, reference: Array) -> Measured:
    """The mean structural similarity of 11 x 11 windows, 1 for equal pictures; none for smaller pictures.

    Wang, Bovik, Sheikh and Simoncelli 2004, "Image quality assessment: from error visibility to structural similarity":
    Gaussian weights of sigma 1.5, population covariance, K1 0.01, K2 0.03, data range 1, over the windows that lie in
    the picture whole; of each channel of the linear values, then their mean. In [-1, 1].
    """
    height, width, _ = image.shape
    if min(height, width) < SSIM_WINDOW:
        return no_value("ssim", f"its windows have {SSIM_WINDOW} x {SSIM_WINDOW} pixels, the picture is smaller")
    if max(np.abs(image).max(), np.abs(reference).max()) > SSIM_PLAIN:
        return Measured(_ssim_of_bright(image, reference))
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


def _ssim_of_bright(image: Array, reference: Array) -> float:
    """The same as `ssim` says, whatever the values.

    With d the differences from the middle of a window, whose own weight is w, the mean of d^2 is at most 1 / w = 14
    times the variance: little cancels in mean(d^2) - mean(d)^2.
    """
    reach = SSIM_WINDOW // 2
    profile = np.exp(-0.5 * (np.arange(-reach, reach + 1) / SSIM_SIGMA) ** 2)
    profile /= profile.sum()
    height, width, _ = image.shape
    middles = [each[reach : height - reach, reach : width - reach] for each in (image, reference)]
    first, second = np.zeros((2, *middles[0].shape)), np.zeros((3, *middles[0].shape))
    for y, down in enumerate(profile):
        for x, across in enumerate(profile):
            rows, columns = slice(y, height - 2 * reach + y), slice(x, width - 2 * reach + x)
            a, r = image[rows, columns] - middles[0], reference[rows, columns] - middles[1]
            weight = down * across
            first += weight * np.stack([a, r])
            second += weight * np.stack([a * a, r * r, a * r])
    variances = second - np.stack([first[0] ** 2, first[1] ** 2, first[0] * first[1]])
    mean_a, mean_r = middles[0] + first[0], middles[1] + first[1]
    c1, c2 = SSIM_CONSTANTS
    luminance = (2.0 * mean_a * mean_r + c1) / (mean_a**2 + mean_r**2 + c1)
    structure = (2.0 * variances[2] + c2) / (variances[0] + variances[1] + c2)
    return float((luminance * structure).mean())


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
