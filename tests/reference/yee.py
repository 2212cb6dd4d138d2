"""Yee's perceptual metric of two small pictures, straight from the formulas in crates/metrics/src/yee: direct sums with numpy in
double precision, no blurring level by level. Prints what crates/metrics/src/yee/tests.rs expects."""

import numpy as np

W, H = 48, 32
FIELD_OF_VIEW, WHITE = 2.0, 100.0
E = np.exp
XYZ = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])


def picture(shift):
    y, x, c = np.mgrid[0:H, 0:W, 0:3]
    codes = (x // 3 * 7 + y // 2 * 13 + c * 29 + shift * ((x // 8 + y // 8) % 3)) % 64 * 4
    encoded = codes / 255.0
    linear = np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)
    return linear.astype(np.float32).astype(float)


def tvi(luminance):
    l = np.log10(luminance)
    pieces = [l < -3.94, l < -1.44, l < -0.0184, l < 1.9]
    with np.errstate(invalid="ignore"):
        values = [-2.86 + 0 * l, (0.405 * l + 1.6) ** 2.18 - 2.86, l - 0.395, (0.249 * l + 0.65) ** 2.7 - 0.72]
    return 10 ** np.select(pieces, values, l - 1.255)


def csf(frequency, luminance):
    a, b = 440 * (1 + 0.7 / luminance) ** -0.2, 0.3 * (1 + 100 / luminance) ** 0.15
    return a * frequency * E(-b * frequency) * np.sqrt(1 + 0.06 * E(b * frequency))


def mask(seen):
    k1, k2 = 6 ** (1 - 1 / 0.3), 6 ** (1 / 0.3)
    return (1 + (k1 * (k2 * seen) ** 0.7) ** 4) ** 0.25


def pyramid_matrix(n, level):
    """The Gaussian pyramid's level as a matrix on a row of n pixels that is mirrored at its ends."""
    whole = np.eye(n)
    for k in range(level):
        step = np.zeros((n, n))
        for i in range(n):
            for tap, weight in zip(range(-2, 3), [0.05, 0.25, 0.4, 0.25, 0.05]):
                j = (i + tap * 2**k) % (2 * n)
                step[i, min(j, 2 * n - 1 - j)] += weight
        whole = step @ whole
    return whole


def level(plane, k):
    return pyramid_matrix(H, k) @ plane @ pyramid_matrix(W, k).T


def chroma(rgb):
    t = rgb @ XYZ.T / XYZ.sum(axis=1)
    f = np.where(t > (6 / 29) ** 3, np.cbrt(t), t / (3 * (6 / 29) ** 2) + 4 / 29)
    return 500 * (f[..., 0] - f[..., 1]), 200 * (f[..., 1] - f[..., 2])


test, reference = picture(5), picture(0)
ys = [WHITE * rgb @ XYZ[1] for rgb in (test, reference)]
density = W * np.pi / 180 / (2 * np.tan(np.radians(FIELD_OF_VIEW) / 2))
reach = round((density - 1) / 2)
both = (ys[0] + ys[1]) / 2
adapted = np.array([[both[max(0, y - reach) : y + reach + 1, max(0, x - reach) : x + reach + 1].mean() for x in range(W)] for y in range(H)])
grid = np.linspace(0.01, 60, 60000)
best = np.array([[csf(grid, l).max() for l in row] for row in adapted])
contrasts, raised = 1 / best, 1 / best
frequency, k = density / 2, 0
while frequency >= 0.5:
    bands = [abs(level(y, k) - level(y, k + 1)) / np.maximum(level(y, k + 2), 10**-3.94) for y in ys]
    sensitivity = csf(frequency, adapted)
    weight = np.maximum(*bands)
    contrasts = contrasts + weight
    raised = raised + weight * best / sensitivity * mask(np.minimum(*bands) * sensitivity)
    frequency, k = frequency / 2, k + 1
elevation = raised / contrasts
(a1, b1), (a2, b2) = chroma(test), chroma(reference)
colour = np.clip((np.log10(adapted) + 2) / 3, 0, 1) * np.hypot(a1 - a2, b1 - b2) / elevation
times = np.maximum(abs(ys[0] - ys[1]) / (elevation * tvi(adapted)), colour)
print("bands", k, "pixels", int((times > 1).sum()), "at the places", [float(times[i // W, i % W]) for i in (9, 505, 1535)], "sum", times.sum())
print("near the threshold:", np.sort(abs(times - 1).ravel())[:3])
