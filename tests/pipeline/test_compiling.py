"""Who compiles says so, once; who has compiled says nothing."""

from pathlib import Path

import numba
import pytest

from pipeline.compiling import told_of_compiling


def doubled(number: float) -> float:
    return 2.0 * number


def test_compiling_is_told_once(capsys: pytest.CaptureFixture[str]) -> None:
    fast = numba.njit(doubled)
    with told_of_compiling("a sum", "no time"):
        assert (fast(1.5), fast(2)) == (3.0, 4)  # two signatures
    assert (
        capsys.readouterr().err
        == "echelon: compiling a sum for this processor, this once (no time)\n"
    )
    with told_of_compiling("a sum", "no time"):
        fast(2.5)
    assert capsys.readouterr().err == ""
    fast(1j)
    assert capsys.readouterr().err == ""


def test_what_is_kept_on_disk_is_loaded_without_a_word(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path))
    for told in (1, 0):
        fast = numba.njit(cache=True)(doubled)
        with told_of_compiling("a sum", "no time"):
            assert fast(1.5) == 3.0
        assert capsys.readouterr().err.count("\n") == told
