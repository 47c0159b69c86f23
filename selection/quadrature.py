"""Nodes and weights for integrals over densities that are mixtures of very different widths."""

from __future__ import annotations

import numpy as np

REACH = 8.5
MOST_NODES = 4096
_BREAKS = np.array([-9.0, -6, -4, -3, -2, -1, 0, 1, 2, 3, 4, 6, 9])
_X8, _W8 = np.polynomial.legendre.leggauss(8)


def mixture_nodes(
    means: np.ndarray,
    sds: np.ndarray,
    per_sd: float = 4.0,
    reach: float = REACH,
    ends: np.ndarray | None = None,
) -> tuple[np.ndarray, np.ndarray]:
    """Return nodes and weights that integrate a mixture's density and its entropy.

    The trapezoid rule with step min(sds) / per_sd over means +- reach sds (spectrally accurate: about 1e-13
    at 4, 5e-10 at 2, 1e-5 at 1); where that takes more than 4096 nodes, Gauss-Legendre panels between
    breakpoints at means + sds {0, +-1, 2, 3, 4, 6, 9}.

    Args:
        means: centres of the components, shape (U,).
        sds: their widths, shape (U,), > 0.
        per_sd: steps per smallest width.
        reach: widths covered on both sides.
        ends: lowest and highest node instead, where the components are not Gaussian.

    Returns:
        Nodes and weights, each (N,).
    """
    low, high = float(np.min(means - reach * sds)), float(np.max(means + reach * sds))
    if ends is not None:
        low, high = float(ends[0]), float(ends[1])
    step = float(np.min(sds)) / per_sd
    count = (high - low) / step
    if count <= MOST_NODES:
        number = int(np.ceil(count)) + 1
        nodes = np.linspace(low, high, number)
        return nodes, np.full(number, (high - low) / (number - 1))
    return _panels(means, sds, low, high)


def _panels(means: np.ndarray, sds: np.ndarray, low: float, high: float) -> tuple[np.ndarray, np.ndarray]:
    points = np.clip((means[:, None] + sds[:, None] * _BREAKS).ravel(), low, high)
    points = np.concatenate([points, [low, high]])
    owners = np.concatenate([np.repeat(sds, len(_BREAKS)), [0.0, 0.0]])
    order = np.argsort(points, kind="stable")
    points, owners = points[order], owners[order]
    kept = [0]
    last = float(points[0])
    for i, (point, gap) in enumerate(zip(points.tolist(), (0.25 * owners).tolist(), strict=True)):
        if point - last >= gap:
            kept.append(i)
            last = point
    edges = points[kept] if kept[-1] == len(points) - 1 else np.append(points[kept], points[-1])
    edges = edges[np.append(True, np.diff(edges) > 0)]
    half = 0.5 * np.diff(edges)
    middle = 0.5 * (edges[1:] + edges[:-1])
    return (middle[:, None] + half[:, None] * _X8).ravel(), (half[:, None] * _W8).ravel()


def entropy(density: np.ndarray, weights: np.ndarray) -> float:
    """Return -sum q f ln f, the differential entropy in nats.

    Args:
        density: values f at the nodes, any shape.
        weights: quadrature weights q of the same shape.
    """
    safe = np.maximum(density, 1e-300)
    return -float(np.sum(weights * density * np.log(safe)))
