"""The peers: each picks columns of a problem. Imports happen inside, as the packages are optional."""

from __future__ import annotations

import re
import warnings
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from bench.proof.peers.candidates import Problem

Picked = NDArray[np.int64]
Method = Callable[[Problem], Picked]
_FOLDS = 4
#: Least relative rise of the held-out RMSE without a group that keeps the group in.
_PRUNE = 0.002
_ROWS = 4000
_ROWS_OF_PROGRAMS = 1000


def relaxed_lasso(problem: Problem) -> Picked:
    """Lasso (scikit-learn) at the sparsest penalty within one standard error of the best, refitted by least squares."""
    from sklearn.linear_model import lasso_path

    x, y, folds = _training(problem)
    alphas = np.geomspace(np.abs(x.T @ y).max() / y.size, 1e-4 * np.abs(x.T @ y).max() / y.size, 30)
    errors = np.empty((_FOLDS, alphas.size))
    for k in range(_FOLDS):
        inside, outside = folds != k, folds == k
        _alphas, path, _gaps = lasso_path(x[inside], y[inside], alphas=alphas)
        errors[k] = np.mean((y[outside, None] - x[outside] @ path) ** 2, axis=0)
    mean = errors.mean(axis=0)
    limit = mean.min() + errors[:, mean.argmin()].std() / np.sqrt(_FOLDS)
    at = int(np.flatnonzero(mean <= limit)[0])
    _alphas, path, _gaps = lasso_path(x, y, alphas=alphas[: at + 1])
    return np.flatnonzero(path[:, -1])


def frols(problem: Problem) -> Picked:
    """Forward regression with BIC as SysIdentPy does it (FROLS on a linear basis without lags)."""
    from sysidentpy.basis_function import Polynomial
    from sysidentpy.model_structure_selection import FROLS

    x, y, _folds = _training(problem)
    lags = [[1]] * x.shape[1]
    model = FROLS(
        order_selection=True,
        n_info_values=min(12, x.shape[1]),
        info_criteria="bic",
        ylag=1,
        xlag=lags if x.shape[1] > 1 else [1],
        model_type="NFIR",
        basis_function=Polynomial(degree=1),
    )
    shifted = np.roll(x, -1, axis=0)
    model.fit(X=shifted[:-1], y=y[:-1, None])
    codes = np.asarray(model.final_model)[:, 0]
    return np.unique(np.array([int(code) // 1000 - 2 for code in codes if code >= 2000], dtype=np.int64))


def stlsq(problem: Problem) -> Picked:
    """Sequentially thresholded least squares (pysindy) with the threshold of the least error over recordings."""
    from pysindy import STLSQ

    x, y, folds = _training(problem)
    best: tuple[float, Picked] = (np.inf, np.array([], dtype=np.int64))
    for threshold in y.std() * np.geomspace(0.02, 1.0, 8):
        error = 0.0
        for k in range(_FOLDS):
            found = _fit_stlsq(STLSQ, x[folds != k], y[folds != k], threshold)
            error += float(np.mean((y[folds == k] - x[folds == k] @ found) ** 2))
        if error < best[0]:
            best = error, np.flatnonzero(_fit_stlsq(STLSQ, x, y, threshold))
    return best[1]


def symbolic(problem: Problem) -> Picked:
    """Genetic programming (gplearn) over the same columns as its variables; those in the best program are picked."""
    from gplearn.genetic import SymbolicRegressor

    x, y = _few(problem)
    model = SymbolicRegressor(
        population_size=200,
        generations=8,
        function_set=("add", "sub", "mul"),
        parsimony_coefficient=0.02,
        random_state=0,
    )
    model.fit(x, y)
    return np.unique(np.array([node for node in model._program.program if isinstance(node, int)], dtype=np.int64))


def operon(problem: Problem) -> Picked:
    """Genetic programming (pyoperon) over the same columns as its variables; those in the best program are picked."""
    from pyoperon.sklearn import SymbolicRegressor

    x, y = _few(problem)
    model = SymbolicRegressor(
        allowed_symbols="add,sub,mul,constant,variable",
        population_size=200,
        generations=60,
        max_evaluations=20_000,
        max_length=30,
        n_threads=1,
        random_state=0,
    )
    model.fit(x, y)
    program = model.get_model_string(model.model_, 3)
    return np.array(sorted({int(number) - 1 for number in re.findall(r"X(\d+)", program)}), dtype=np.int64)


#: Name of each peer as the table shows it.
METHODS: dict[str, Method] = {
    "relaxed lasso, 1-SE (scikit-learn)": relaxed_lasso,
    "FROLS + BIC (SysIdentPy)": frols,
    "STLSQ, min CV (pysindy)": stlsq,
    "gplearn": symbolic,
    "pyoperon": operon,
}


def pick(method: Method, problem: Problem) -> Picked:
    """Run a peer on a problem and prune its picks group by group over held-out recordings."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        chosen = method(problem)
    while chosen.size:
        groups = sorted({(problem.effects[i]) for i in chosen})
        whole = cross_validated(problem, chosen)
        rises = []
        for group in groups:
            rest = np.array([i for i in chosen if problem.effects[i] != group], dtype=np.int64)
            rises.append((cross_validated(problem, rest) / whole - 1.0, group))
        rise, group = min(rises)
        if rise >= _PRUNE:
            return chosen
        chosen = np.array([i for i in chosen if problem.effects[i] != group], dtype=np.int64)
    return chosen


def cross_validated(problem: Problem, chosen: Picked) -> float:
    """RMSE over folds of training recordings with the chosen columns fitted by least squares."""
    x, y, folds = _training(problem)
    square = 0.0
    for k in range(_FOLDS):
        inside, outside = folds != k, folds == k
        fitted = x[outside][:, chosen] @ np.linalg.lstsq(x[inside][:, chosen], y[inside], rcond=None)[0]
        square += float(np.sum((y[outside] - fitted) ** 2))
    return float(np.sqrt(square / y.size))


def held_out(problem: Problem, chosen: Picked) -> float:
    """RMSE on the recordings that fitted nothing."""
    train = problem.train
    x = problem.columns[:, chosen]
    fitted = x[~train] @ np.linalg.lstsq(x[train], problem.y[train], rcond=None)[0]
    return float(np.sqrt(np.mean((problem.y[~train] - fitted) ** 2)))


def _training(problem: Problem) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.int64]]:
    index = np.flatnonzero(problem.train)
    if index.size > _ROWS:
        index = np.sort(np.random.default_rng(1).choice(index, _ROWS, replace=False))
    return problem.columns[index], problem.y[index], problem.recording[index] % _FOLDS


def _few(problem: Problem) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Rows that genetic programming gets, of a target of size one."""
    x, y, _folds = _training(problem)
    few = np.random.default_rng(0).choice(y.size, min(_ROWS_OF_PROGRAMS, y.size), replace=False)
    return x[few], y[few] / y.std()


def _fit_stlsq(kind: type, x: NDArray[np.float64], y: NDArray[np.float64], threshold: float) -> NDArray[np.float64]:
    model = kind(threshold=threshold, alpha=1e-6)
    model.fit(x, y[:, None])
    return np.asarray(model.coef_, dtype=np.float64).ravel()
