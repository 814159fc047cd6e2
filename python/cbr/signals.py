# SPDX-License-Identifier: GPL-3.0-or-later
"""Filters and spectra of time series. Values are n, or n x m with a series in each column."""
from __future__ import annotations

import numpy as np
import numpy.typing as npt

from cbr.superelement import Array

CFC = (60, 180, 600, 1000)


def _step(time: npt.ArrayLike, values: npt.ArrayLike) -> tuple[float, Array]:
    """The time between samples, and the values as n x m."""
    t, x = np.asarray(time, float), np.asarray(values, float)
    if t.ndim != 1 or len(t) < 2 or x.ndim not in (1, 2) or len(x) != len(t):
        raise ValueError(f"{t.shape} times and {x.shape} values: give n times, from 2, and n or n x m values")
    if not (np.isfinite(t).all() and np.isfinite(x).all()):
        raise ValueError("a time or a value is not finite")
    step = (t[-1] - t[0]) / (len(t) - 1)
    if not step > 0 or np.abs(np.diff(t) - step).max() > 1e-3 * step:
        raise ValueError("the times are not evenly spaced: give output.every in the scene")
    return float(step), x.reshape(len(t), -1)


def _both_ways(values: npt.ArrayLike, x: Array, step: float, corner_hz: float, order: int, above: bool) -> Array:
    """A digital Butterworth filter of `order`, forward and then backward: its squared gain, which has no phase,
    on the spectrum. Before and after the samples the series goes on as its point reflection about its ends, until
    the filter has forgotten what follows."""
    n, corner = len(x), np.tan(np.pi * corner_hz * step)
    slowest = 2 * np.arctan(corner) / step * np.sin(np.pi / (2 * order))  # of the filter's decay rates, 1/s
    pad = int(np.ceil(40 / (slowest * step)))
    index = np.minimum(np.arange(1, pad + 1), n - 1)
    longer = np.concatenate([(2 * x[0] - x[index])[::-1], x, 2 * x[-1] - x[n - 1 - index]])
    ratio = np.tan(np.pi * np.minimum(np.fft.rfftfreq(len(longer), 1.0), 0.4999999999)) / corner
    gain = 1 / (1 + ratio**(2 * order))
    filtered = np.fft.irfft((1 - gain if above else gain)[:, None] * np.fft.rfft(longer, axis=0), len(longer), axis=0)
    return np.asarray(filtered[pad:pad + n].reshape(np.shape(values)))


def cfc(time: npt.ArrayLike, values: npt.ArrayLike, channel: float) -> Array:
    """SAE J211-1's filter of a channel frequency class, without phase: its Butterworth filter of order 2 with the
    corner 2.0775 Hz times the class (Appendix C), forward and backward, so that -3 dB are at 5/3 of the class.

    time: n, s, evenly spaced, at least 10 samples a period of the class. values: n or n x m. channel: 60, 180, 600
    or 1000. Returns the shape of the values. ValueError: other shapes, times or classes, fewer samples.

    >>> t = np.arange(2000) / 1e4
    >>> x = np.sin(2 * np.pi * 100 * t)
    >>> print(round(float(cfc(t, x, 60)[1000:1200].max()), 3))
    0.707
    """
    step, x = _step(time, values)
    if channel not in CFC:
        raise ValueError(f"no class {channel}: SAE J211 has {', '.join(map(str, CFC))}")
    if step * channel > 0.1 * (1 + 1e-9):
        raise ValueError(f"{1 / step:.6g} samples a second: class {channel} needs 10 times its number (SAE J211): lower output.every")
    return _both_ways(values, x, step, 2.0775 * channel, 2, False)


def butterworth(time: npt.ArrayLike, values: npt.ArrayLike, cutoff_hz: float, order: int = 2, above: bool = False) -> Array:
    """A digital Butterworth filter of `order`, forward and backward, so that it has no phase and 2 `order` poles.
    It keeps frequencies below cutoff_hz, or those `above` it. The gain of both passes is 1/sqrt(2) at cutoff_hz:
    1 / (1 + c r^(2 order)), c = sqrt(2) - 1, with r = tan(pi f step) / tan(pi cutoff_hz step), above it 1/r.

    time: n, s, evenly spaced. values: n or n x m. cutoff_hz: between 0 and half the samples a second. Returns the
    shape of the values. ValueError: other shapes or times, a cutoff or an order (from 1 to 20) out of range.
    """
    step, x = _step(time, values)
    if not 0 < cutoff_hz * step < 0.5:
        raise ValueError(f"a cutoff of {cutoff_hz} Hz: give one between 0 and {0.5 / step:.6g} Hz, half the samples a second")
    if order not in range(1, 21):
        raise ValueError(f"order {order}: give a whole number from 1 to 20")
    # the gain of both passes at the corner is 1/2
    share = (np.sqrt(2) - 1)**((0.5 if above else -0.5) / order)
    return _both_ways(values, x, step, float(np.arctan(share * np.tan(np.pi * cutoff_hz * step)) / (np.pi * step)), order, above)


def psd(time: npt.ArrayLike, values: npt.ArrayLike, segment: int | None = None) -> tuple[Array, Array]:
    """Power spectral density, one-sided, by Welch's method: the mean over segments that overlap by half, each less its
    mean and under a Hann window.

    time: n, s, evenly spaced. values: n or n x m, of any unit U. segment: its samples, from 4 to n; the default is
    n // 4 (7 segments). Returns the frequencies (f = segment // 2 + 1, Hz) and the densities (f or f x m, U^2/Hz), whose
    integral over the frequency is the mean square of what varies. ValueError: other shapes, times or segments.

    >>> t = np.arange(4000) / 1000
    >>> hz, density = psd(t, 3 * np.sin(2 * np.pi * 50 * t))
    >>> print(hz[density.argmax()], round(float(density.sum() * hz[1]), 6))
    50.0 4.5
    """
    step, x = _step(time, values)
    n = max(len(x) // 4, 4) if segment is None else segment
    if not 4 <= n <= len(x):
        raise ValueError(f"segments of {n} of {len(x)} samples: give from 4 to {len(x)}")
    starts = range(0, len(x) - n + 1, n - n // 2)
    window = np.sin(np.pi * np.arange(n) / n)[:, None]**2
    power = np.zeros((n // 2 + 1, x.shape[1]))
    for start in starts:
        part = x[start:start + n]
        power += np.abs(np.fft.rfft(window * (part - part.mean(axis=0)), axis=0))**2
    power *= 2 * step / (len(starts) * (window**2).sum())
    power[0] /= 2
    if n % 2 == 0:
        power[-1] /= 2
    return np.fft.rfftfreq(n, step), power.reshape(-1, *np.shape(values)[1:])
