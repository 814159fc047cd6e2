# SPDX-License-Identifier: GPL-3.0-or-later
"""XXH3 of 64 bits (xxhash.com), of whole words of 8 bytes, without a seed: the checksums of the programs' files."""
from __future__ import annotations

import numpy as np
import numpy.typing as npt

_SECRET = bytes.fromhex(
    "b8fe6c3923a44bbe7c01812cf721ad1cded46de9839097db7240a4a4b7b3671fcb79e64eccc0e578825ad07dccff7221"
    "b8084674f743248ee03590e6813a264c3c2852bb91c300cb88d0658b1b532ea371644897a20df94e3819ef46a9deacd8"
    "a8fa763fe39c343ff9dcbbc7c70b4f1d8a51e04bcdb45931c89f7ec9d9787364eac5ac8334d3ebc3c581a0fffa1363eb"
    "170ddd51b7f0da49d316552629d4689e2b16be587d47a1fc8ff8b8d17ad031ce45cb3a8f95160428afd7fbcabb4b407e")
_WORDS = np.frombuffer(_SECRET, "<u8")
_KEYS = np.array([_WORDS[n:n + 8] for n in range(16)])  # of the 16 stripes of a block
_MASK = 2**64 - 1
_PRIME = 0x9E3779B185EBCA87
_START = np.array([0xC2B2AE3D, _PRIME, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9, 0x85EBCA77C2B2AE63, 0x85EBCA77, 0x27D4EB2F165667C5,
                   0x9E3779B1], np.uint64)
_MOST = 4096  # blocks at a time, 4 MB
Words = npt.NDArray[np.uint64]


def _secret(at: int) -> int:
    return int.from_bytes(_SECRET[at:at + 8], "little")


def _fold(a: int, b: int) -> int:
    return (a * b & _MASK) ^ (a * b >> 64)


def _avalanche(h: int) -> int:
    h = ((h ^ h >> 37) * 0x165667919E3779F9) & _MASK
    return h ^ h >> 32


def _stripes(data: Words, keys: Words) -> Words:
    """The sums that stripes (... x s x 8) add to the eight accumulators."""
    keyed = data ^ keys
    low = keyed & np.uint64(0xFFFFFFFF)
    total: Words = (low * (keyed >> np.uint64(32)) + data[..., [1, 0, 3, 2, 5, 4, 7, 6]]).sum(axis=-2, dtype=np.uint64)
    return total


def _long(data: Words) -> int:
    sums, n_blocks = _START.copy(), (len(data) - 1) // 128
    for first in range(0, n_blocks, _MOST):
        last = min(first + _MOST, n_blocks)
        for added in _stripes(data[128 * first:128 * last].reshape(-1, 16, 8), _KEYS):
            sums += added
            sums = (sums ^ sums >> np.uint64(47) ^ _WORDS[16:]) * np.uint64(0x9E3779B1)
    rest = data[128 * n_blocks:]
    n = (len(rest) - 1) // 8
    sums += _stripes(rest[:8 * n].reshape(n, 8), _KEYS[:n])
    sums += _stripes(data[None, -8:], np.frombuffer(_SECRET[121:185], "<u8")[None])
    at = [int(x) for x in sums]
    h = 8 * len(data) * _PRIME + sum(_fold(at[i] ^ _secret(11 + 8 * i), at[i + 1] ^ _secret(19 + 8 * i)) for i in range(0, 8, 2))
    return _avalanche(h & _MASK)


def xxh3(data: Words) -> int:
    """Of n words, as a number from 0 to 2^64 - 1.

    >>> hex(xxh3(np.zeros(0, np.uint64))), hex(xxh3(np.arange(1000, dtype=np.uint64)))
    ('0x2d06800538d394c2', '0x29462356e2d9061a')
    """
    n, size = len(data), 8 * len(data)
    if n > 30:
        with np.errstate(over="ignore"):
            return _long(data)
    word = [int(x) for x in data]

    def mix(i: int, at: int) -> int:
        return _fold(word[i] ^ _secret(at), word[i + 1] ^ _secret(at + 8))

    if n == 0:
        h = _secret(56) ^ _secret(64)
        h = ((h ^ h >> 33) * 0xC2B2AE3D27D4EB4F) & _MASK
        h = ((h ^ h >> 29) * 0x165667B19E3779F9) & _MASK
        return h ^ h >> 32
    if n == 1:
        h = ((word[0] >> 32) + (word[0] << 32 & _MASK)) ^ _secret(8) ^ _secret(16)
        h ^= (h << 49 | h >> 15) & _MASK ^ (h << 24 | h >> 40) & _MASK
        h = h * 0x9FB21C651E98DF25 & _MASK
        h = (h ^ (h >> 35) + size) * 0x9FB21C651E98DF25 & _MASK
        return h ^ h >> 28
    if n == 2:
        low, high = word[0] ^ _secret(24) ^ _secret(32), word[1] ^ _secret(40) ^ _secret(48)
        return _avalanche((size + int.from_bytes(low.to_bytes(8, "little"), "big") + high + _fold(low, high)) & _MASK)
    h = size * _PRIME
    if n <= 16:
        for i in range((n - 1) // 4 + 1):
            h += mix(2 * i, 32 * i) + mix(n - 2 - 2 * i, 32 * i + 16)
        return _avalanche(h & _MASK)
    h = _avalanche((h + sum(mix(2 * i, 16 * i) for i in range(8))) & _MASK)
    h += sum(mix(2 * i, 16 * (i - 8) + 3) for i in range(8, n // 2)) + mix(n - 2, 119)
    return _avalanche(h & _MASK)
