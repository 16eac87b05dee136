"""Factors of sparse block matrices against dense ones."""

import numpy as np
import pytest

from touchwarp.goals.maps.block_cholesky import BlockCholesky
from touchwarp.scene.shapes import sphere

LIFT = 0.3


def pattern(links, n):
    """Start and column of a symmetric pattern with these links (l, 2) and its diagonal."""
    both = np.concatenate([links, links[:, ::-1], np.repeat(np.arange(n)[:, None], 2, axis=1)])
    row, column = np.unique(both, axis=0).T
    return np.searchsorted(row, np.arange(n + 1)), column, row


def of_a_mesh():
    faces = sphere(1.0, 200).faces
    return np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])


def arrow():
    return np.stack([np.zeros(30, np.int64), np.arange(1, 31)], axis=1)


def in_two_parts():
    return np.array([(0, 5), (5, 2), (2, 0), (1, 3), (3, 4)])


def system(links, seed=0):
    """Start, column, blocks of a positive matrix with these links, and the matrix itself, dense."""
    rng = np.random.default_rng(seed)
    n = int(links.max()) + 1
    start, column, row = pattern(links, n)
    dense = np.zeros((2 * n, 2 * n))
    for i, j in links:
        term = np.zeros((3, 2 * n))
        term[:, 2 * i : 2 * i + 2] = rng.normal(size=(3, 2))
        term[:, 2 * j : 2 * j + 2] = rng.normal(size=(3, 2))
        dense += term.T @ term
    blocks = dense.reshape(n, 2, n, 2).transpose(0, 2, 1, 3)[row, column]
    return start, column, blocks, dense


@pytest.mark.parametrize("links", [of_a_mesh(), arrow(), in_two_parts()])
def test_it_solves_as_dense_factors_do(links):
    start, column, blocks, dense = system(links)
    right = np.random.default_rng(1).normal(size=(len(start) - 1, 2))
    found = BlockCholesky(start, column).solve(blocks, LIFT, right)
    lifted = dense + LIFT * np.eye(len(dense))
    assert found.ravel() == pytest.approx(np.linalg.solve(lifted, right.ravel()), abs=1e-9)
    assert lifted @ found.ravel() == pytest.approx(right.ravel(), abs=1e-10)


def test_the_comparison_tells_a_block_that_was_left_out():
    start, column, blocks, dense = system(of_a_mesh())
    right = np.random.default_rng(1).normal(size=(len(start) - 1, 2))
    row = np.repeat(np.arange(len(start) - 1), np.diff(start))
    blocks[(row == column[1]) & (column == row[1])] = 0.0
    blocks[1] = 0.0
    found = BlockCholesky(start, column).solve(blocks, LIFT, right)
    lifted = dense + LIFT * np.eye(len(dense))
    assert np.abs(lifted @ found.ravel() - right.ravel()).max() > 1e-3


def test_one_analysis_serves_all_matrices_of_a_pattern():
    start, column, blocks, _ = system(of_a_mesh())
    cholesky = BlockCholesky(start, column)
    right = np.ones((len(start) - 1, 2))
    cholesky.solve(blocks, LIFT, right)
    _, _, others, other = system(of_a_mesh(), seed=5)
    found = cholesky.solve(others, LIFT, right)
    assert (other + LIFT * np.eye(len(other))) @ found.ravel() == pytest.approx(1.0, abs=1e-10)


def test_a_matrix_that_is_not_positive_is_lifted_until_it_is():
    start, column, blocks, dense = system(in_two_parts())
    sunk = dense - np.eye(len(dense)) * (np.linalg.eigvalsh(dense).min() + 0.5)
    diagonal = column == np.repeat(np.arange(len(start) - 1), np.diff(start))
    blocks[diagonal] -= (dense[0, 0] - sunk[0, 0]) * np.eye(2)
    right = np.ones((len(start) - 1, 2))
    found = BlockCholesky(start, column).solve(blocks, 0.3, right)  # 0.3 is too little, 3 is not
    assert (sunk + 3.0 * np.eye(len(sunk))) @ found.ravel() == pytest.approx(1.0, abs=1e-9)
