# SPDX-FileCopyrightText: 2026 Synch Fields contributors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Finds a text in a picture, as Blender's own font draws it, in any colour: by correlation."""

import numpy as np
from scipy.fft import irfft2, next_fast_len, rfft2
from scipy.ndimage import shift, uniform_filter

# Correlation from which a place shows the text. Seen: the text itself over 0.99, with one letter changed 0.92.
_ALIKE = 0.96
# Correlation below which there is nothing like it, wherever it starts within a pixel.
_SOMEWHAT_ALIKE = 0.6
# Texts start anywhere within a pixel.
_STEPS, _BETWEEN = (0.0, 0.25, 0.5, 0.75), 0.375


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
    correlation = _Correlation(grey, (height, width))
    if correlation.of(template, _BETWEEN).max() < _SOMEWHAT_ALIKE:
        return np.zeros((0, 2))
    score = np.max([correlation.of(template, step) for step in _STEPS], axis=0)
    found = []
    while score.max() >= alike:
        row, column = np.unravel_index(score.argmax(), score.shape)
        found.append((column + width / 2, row + height / 2))
        score[max(row - height // 2, 0) : row + height // 2, max(column - width // 2, 0) : column + width // 2] = 0
    return np.array(sorted(found, key=lambda place: place[1])).reshape(-1, 2)


class _Correlation:
    """Normalized correlation of templates of a size with every window of a picture that they fit into."""

    def __init__(self, grey, size):
        self._size, self._valid = size, tuple(side - part + 1 for side, part in zip(grey.shape, size, strict=True))
        self._shape = [next_fast_len(side, real=True) for side in grey.shape]
        self._transformed = rfft2(grey - grey.mean(), self._shape)
        inside = tuple(slice(part // 2, part // 2 + length) for part, length in zip(size, self._valid, strict=True))
        mean = uniform_filter(grey, size)[inside]
        self._variance = np.maximum(uniform_filter(grey**2, size)[inside] - mean**2, 1.0)

    def of(self, template, step):
        """That of a template which is moved to the right by a part of a pixel."""
        flat = shift(template.astype(float), (0, step), order=1)
        flat = flat - flat.mean()
        product = irfft2(self._transformed * rfft2(flat, self._shape).conj(), self._shape)
        product = product[: self._valid[0], : self._valid[1]]
        return product / np.sqrt(self._variance * flat.size * (flat**2).sum())
