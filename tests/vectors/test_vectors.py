"""The committed vectors are those that this library gives, now."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from safetensors.numpy import load_file

from tests.vectors.generate import FOLDER, make_vectors
from tests.vectors.warps import write_warps
from touchwarp.warp.file import read

VECTORS = load_file(FOLDER / "vectors.safetensors")
LIMIT = 200_000


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder of warps, made anew."""
    folder = tmp_path_factory.mktemp("vectors")
    write_warps(folder)
    return folder


def differences(vectors: dict[str, NDArray[np.float64]]) -> dict[str, float]:
    return {
        name: float(np.nanmax(np.abs(vectors[name] - VECTORS[name]), initial=0.0))
        if np.array_equal(np.isnan(vectors[name]), np.isnan(VECTORS[name]))
        else np.inf
        for name in VECTORS
    }


def test_the_committed_warps_give_the_committed_numbers() -> None:
    assert {name: d for name, d in differences(make_vectors(FOLDER)).items() if d > 1e-9} == {}


def test_that_claim_rejects_warps_whose_axes_are_swapped(
    made: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    import tests.vectors.generate as generate

    real = generate.load_warp

    def spoilt(path: Path) -> object:
        warp = real(path)
        if path.stem == "levels":
            warp._lookup.values[:] = warp.bricks.values.swapaxes(1, 3).reshape(-1)  # type: ignore[union-attr]
        return warp

    monkeypatch.setattr(generate, "load_warp", spoilt)
    wrong = differences(make_vectors(made))
    assert wrong["levels.displacement"] > 1e-4


def test_the_committed_warps_are_what_the_generator_makes(made: Path) -> None:
    names = sorted(path.name for path in FOLDER.glob("*.warp"))
    assert names == sorted(path.name for path in made.glob("*.warp"))
    for name in names:
        document, tensors = read(FOLDER / name)
        fresh_document, fresh = read(made / name)
        for stored in ("storage_error_mm", "storage_jump"):
            assert document.pop(stored) == pytest.approx(fresh_document.pop(stored), rel=0.1)
        assert document == fresh_document
        assert set(tensors) == set(fresh)
        for key, tensor in tensors.items():
            # closed forms may differ by the last bit between C libraries
            np.testing.assert_allclose(tensor, fresh[key], rtol=2**-10, atol=1e-7, err_msg=key)
            assert tensor.dtype == fresh[key].dtype


def test_they_are_small() -> None:
    files = [path for path in FOLDER.iterdir() if path.suffix in (".warp", ".safetensors")]
    assert sum(path.stat().st_size for path in files) < LIMIT
