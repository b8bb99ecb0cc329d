# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds a text in a picture, as Blender's own font draws it, in any colour: by correlation."""

import numpy as np
from scipy.ndimage import shift, uniform_filter
from scipy.signal import fftconvolve

# Correlation from which a place shows the text. Seen: the text itself over 0.99, with one letter changed 0.92.
_ALIKE = 0.96
# Texts start anywhere within a pixel.
_STEPS = (0.0, 0.25, 0.5, 0.75)


def places(picture, template, alike=_ALIKE):
    """Where a picture shows a text.

    Parameters
    ----------
    picture : (height, width, 3) bytes
    template : (h, w) the text alone, bright on dark, with its margin
    alike : correlation from which a place shows it

    Returns
    -------
    (k, 2) middles, x and y in pixels from the top left, the topmost first
    """
    grey = picture.astype(float).mean(axis=2)
    height, width = template.shape
    if grey.shape[0] < height or grey.shape[1] < width:
        return np.zeros((0, 2))
    score = np.max([_correlation(grey, shift(template.astype(float), (0, step), order=1)) for step in _STEPS], axis=0)
    found = []
    while score.max() >= alike:
        row, column = np.unravel_index(score.argmax(), score.shape)
        found.append((column + width / 2, row + height / 2))
        score[max(row - height // 2, 0) : row + height // 2, max(column - width // 2, 0) : column + width // 2] = 0
    return np.array(sorted(found, key=lambda place: place[1])).reshape(-1, 2)


def _correlation(grey, template):
    """Normalized correlation of the template with every window of the picture that it fits into."""
    count = template.size
    flat = template - template.mean()
    product = fftconvolve(grey, flat[::-1, ::-1], mode="valid")
    inside = tuple(
        slice(side // 2, side // 2 + length) for side, length in zip(template.shape, product.shape, strict=True)
    )
    mean = uniform_filter(grey, template.shape)[inside]
    variance = uniform_filter(grey**2, template.shape)[inside] - mean**2
    return product / np.sqrt(np.maximum(variance, 1.0) * count * (flat**2).sum())
