"""Normal equations, solved accurately for columns of very different size."""

from __future__ import annotations

import numpy as np

from ...checks import TINY

RIDGE = 1e-10  # relative; keeps the coefficients of dependent columns finite


def solve(xx: np.ndarray, xy: np.ndarray) -> np.ndarray:
    """Solve normal equations, with columns scaled to one norm first.

    Parameters
    ----------
    xx : ndarray of shape (..., p, p)
        Inner products of the columns.
    xy : ndarray of shape (..., p)
        Inner products with the target.

    Returns
    -------
    ndarray of shape (..., p)
    """
    return solve_many(xx, xy[..., None])[..., 0]


def solve_many(xx: np.ndarray, xy: np.ndarray) -> np.ndarray:
    """Solve normal equations for several targets, with columns scaled to one norm first.

    Parameters
    ----------
    xx : ndarray of shape (..., p, p)
        Inner products of the columns.
    xy : ndarray of shape (..., p, n_targets)
        Inner products with the targets.

    Returns
    -------
    ndarray of shape (..., p, n_targets)
    """
    square = np.diagonal(xx, axis1=-2, axis2=-1)[..., None]
    size = np.sqrt(np.where(square > TINY, square, 1.0))
    scaled = xx / (size * np.swapaxes(size, -1, -2)) + RIDGE * np.eye(xx.shape[-1])
    return np.asarray(np.linalg.solve(scaled, xy / size) / size)


def solve_gram(gram: np.ndarray) -> np.ndarray:
    """Return the coefficients that fit the last column of a Gram matrix by the others.

    Parameters
    ----------
    gram : ndarray of shape (p + 1, p + 1)
        Inner products of the columns and, last, the target.

    Returns
    -------
    ndarray of shape (p,)
    """
    return solve(gram[:-1, :-1], gram[:-1, -1])


def errors_of(trained: np.ndarray, judged: np.ndarray, models: np.ndarray) -> np.ndarray:
    """Fit many models to parts of the data, and evaluate each fit on another part.

    The leading columns that all models share are projected out once.

    Parameters
    ----------
    trained, judged : ndarray of shape (n_parts, p + 1, p + 1)
        Inner products of columns and, last, target: of the data to fit, and to evaluate on.
    models : ndarray of int of shape (n_models, n_columns)
        Columns of each model.

    Returns
    -------
    ndarray of shape (n_models, n_parts)
        Sum of squared errors.
    """
    models = np.asarray(models, dtype=int)
    n_shared = int(np.argmin([*np.all(models == models[0], axis=0), False]))
    shared, further = models[0, :n_shared], models[:, n_shared:]
    others, places = np.unique(
        np.insert(further, further.shape[1], -1, axis=1), return_inverse=True
    )
    index = places.reshape(len(models), -1)
    size = np.maximum(np.diagonal(trained, axis1=1, axis2=2), TINY / RIDGE)
    size[:, -1] = 0.0  # the target is no column
    ridged, diagonal = trained.copy(), np.arange(trained.shape[1])
    ridged[:, diagonal, diagonal] += RIDGE * size
    fits = solve_many(trained[:, shared[:, None], shared], trained[:, shared[:, None], others])
    fitted, held = (_projected(grams, shared, others, fits, index) for grams in (ridged, judged))
    coef = solve(fitted[..., :-1, :-1], fitted[..., :-1, -1])
    contrast = np.concatenate([coef, np.full((*coef.shape[:-1], 1), -1.0)], axis=-1)
    return np.asarray(np.einsum("fmi,fmij,fmj->mf", contrast, held, contrast))


def _projected(
    grams: np.ndarray, shared: np.ndarray, others: np.ndarray, fits: np.ndarray, index: np.ndarray
) -> np.ndarray:
    """Project shared columns out of the inner products of each model (Frisch and Waugh).

    `index`, (n_models, k), holds the places of each model's columns in `others`; the result has
    the shape (n_parts, n_models, k, k).
    """
    cross = grams[:, shared[:, None], others]
    moved = grams[:, shared[:, None], shared] @ fits - cross
    rows, columns = index[:, :, None], index[:, None, :]
    if index.shape[1] > 2:  # the same pairs recur in many models
        turned = np.swapaxes(fits, 1, 2) @ moved - np.swapaxes(cross, 1, 2) @ fits
        return (grams[:, others[:, None], others] + turned)[:, rows, columns]
    turned = fits[:, :, rows] * moved[:, :, columns] - cross[:, :, rows] * fits[:, :, columns]
    return grams[:, others[rows], others[columns]] + turned.sum(axis=1)


def log_ratio(before: float, after: float) -> float:
    """Return log(before / after) of two errors; finite where one of them is zero."""
    return float(np.log(max(before, TINY) / max(after, TINY)))


def square_of(gram: np.ndarray, coef: np.ndarray) -> float:
    """Return the squared residual of coefficients, from a Gram matrix with the target last."""
    contrast = np.append(coef, -1.0)
    return float(contrast @ gram @ contrast)


def summed(grams: np.ndarray, labels: np.ndarray) -> np.ndarray:
    """Return the sum of the matrices (n, p, p) of each label; labels count from zero."""
    return np.array([grams[labels == k].sum(axis=0) for k in range(int(labels.max()) + 1)])
