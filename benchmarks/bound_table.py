"""The table of errors beside the Cramer-Rao bound: `python -m benchmarks bound [--quick]`."""

import sys
from collections.abc import Sequence
from itertools import groupby, pairwise
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from benchmarks.cases import CODECS, PLATES_PX, cases
from benchmarks.spread import Spread, Trials, run, summed

TARGETS = {"444": 1.3, "420": 2.0, "420 jpeg 85": 2.0}  # rms to bound
_HEADINGS_DEG = np.arange(0, 91, 15)  # every quarter turn shows the pixels the same square


def measure(quick: bool) -> list[Spread]:
    """Measure all cases and print them.

    Args:
        quick: only some sizes and blurs at noise 3.

    Returns:
        One row per case.
    """
    every, rows, start = [], [], perf_counter()
    wanted = cases(quick)
    for n, case in enumerate(wanted, 1):
        every.append(run(case))
        rows.append(summed(every[-1]))
        print(f"\rbound: case {n} of {len(wanted)}", end="", file=sys.stderr, flush=True)
    print(f", {perf_counter() - start:.0f} s", file=sys.stderr)
    _print_ratios(rows)
    _print_parts(rows)
    _print_places(every)
    _print_verdict(rows)
    return rows


def _print_ratios(rows: Sequence[Spread]) -> None:
    sizes = [px for px in PLATES_PX if any(row.plate_px == px for row in rows)]
    print("\nrms error / Cramer-Rao bound of the tracked fit: position / heading, by plate size\n")
    print(f"{'picture':12} {'blur':>5} {'noise':>5}  " + " ".join(f"{px:>8} px" for px in sizes))
    for (codec, blur, noise), same in groupby(sorted(rows, key=_order), _order):
        texts = (f"{row.ratio:5.2f}/{row.heading_ratio:5.2f}" for row in same)
        print(f"{CODECS[codec]:12} {blur:5.1f} {noise:5.0f}  " + " ".join(texts))


def _print_parts(rows: Sequence[Spread]) -> None:
    print(
        "\nnoise 3, blur 0.6; bias: the part that depends on the pose, and the part that does not\n"
    )
    print(
        f"{'picture':12} {'plate':>6} {'rms mm':>7} {'bound':>7} {'bias':>6} {'common':>7}   "
        f"{'rms deg':>7} {'bound':>7} {'bias':>6} {'NEES':>6} {'found':>7} "
        f"{'astray':>7} {'exact':>12}"
    )
    for r in sorted(rows, key=_order):
        if (r.noise, r.blur_px) == (3.0, 0.6):
            print(
                f"{r.codec:12} {r.plate_px:3} px {r.rms_mm:7.3f} {r.bound_mm:7.3f} "
                f"{r.bias_mm:6.3f} {r.common_mm:7.3f}   {r.rms_deg:7.3f} {r.bound_deg:7.3f} "
                f"{r.bias_deg:6.3f} {r.nees:6.1f} {r.recall:7.1%} {r.astray:7.2%} "
                f"{r.exact_ratio:6.2f}/{r.exact_heading_ratio:5.2f}"
            )
    print("NEES: squared error in units of the fit's own covariance; 3 is honest.")
    print(
        "astray: more than a pixel off. exact: what the renderer's own model reaches, rms / bound."
    )


def _print_places(every: Sequence[Trials]) -> None:
    print("\nwhere in all cases: position / heading ratio by heading and by place in the pixel\n")
    steps = [f"{a} to {b} deg" for a, b in pairwise(_HEADINGS_DEG)]
    phases = ["middle of a pixel", "edge of a pixel", "corner of pixels"]
    print(f"{'picture':12} " + " ".join(f"{text:>17}" for text in (*steps, *phases)))
    for codec in CODECS:
        chosen = [trials for trials in every if trials.case.codec == codec]
        turns = np.concatenate([np.degrees(trials.poses[:, 2]) % 90.0 for trials in chosen])
        off = np.abs(np.concatenate([t.places - np.rint(t.places) for t in chosen])) > 0.25
        groups = [*(np.searchsorted(_HEADINGS_DEG, turns, "right") == k + 1 for k in range(6))]
        groups += [off.sum(axis=1) == k for k in range(3)]
        place, turn = np.concatenate([_normalised(trials) for trials in chosen], axis=1)
        texts = (f"{place[g].mean() ** 0.5:.2f}/{turn[g].mean() ** 0.5:.2f}" for g in groups)
        print(f"{codec:12} " + " ".join(f"{text:>17}" for text in texts))


def _print_verdict(rows: Sequence[Spread]) -> None:
    print()
    for codec, target in TARGETS.items():
        ratios = np.array([(r.ratio, r.heading_ratio) for r in rows if r.codec == codec])
        within = np.count_nonzero((ratios <= target).all(axis=1))
        print(
            f"{codec:12} target {target}: {within} of {len(ratios)} cases within it; "
            f"median {np.median(ratios[:, 0]):.2f} / {np.median(ratios[:, 1]):.2f}, "
            f"worst {ratios[:, 0].max():.2f} / {ratios[:, 1].max():.2f}"
        )


def _order(row: Spread) -> tuple[int, float, float]:
    return CODECS.index(row.codec), row.blur_px, row.noise


def _normalised(trials: Trials) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Squared errors of position and heading, each (T,), in units of the bound."""
    variances = np.diagonal(trials.bounds, axis1=1, axis2=2)
    squares = trials.errors**2
    return squares[:, :2].sum(axis=1) / variances[:, :2].sum(axis=1), squares[:, 2] / variances[
        :, 2
    ]
