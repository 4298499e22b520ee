"""Before a run starts everything compiled has been called: no frame waits for the compiler."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]

RUN = """
import json, sys
from dataclasses import replace
from numba.core.registry import CPUDispatcher
from pipeline.live import run
from pipeline.readiness import ready_to_drive
from pipeline.rigs import connect
from pipeline.scenario import load_scenario
from pipeline.setup import make_setup
from tests.pipeline.runs import Keeper

def known():
    modules = [m for name, m in sys.modules.items() if name.startswith("vision.")]
    parts = {p for m in modules for p in vars(m).values() if isinstance(p, CPUDispatcher)}
    return {(p.py_func.__qualname__, str(s)) for p in parts for s in p.signatures}

scenario = load_scenario(sys.argv[1], sys.argv[2:])
setup, keeper = make_setup(scenario, ready_to_drive(scenario)), Keeper()
before, loaded = known(), set(sys.modules)
rig = replace(connect(scenario, "rendered", None, 0, True), observers=(keeper,))
run(setup, rig, setup.period)
scenes = [m.cycle.scene for m in keeper.moments if m.cycle.scene is not None]
reasons = {r.reason.split()[0].strip(":") for scene in scenes for r in scene.rejected}
print(json.dumps({
    "before": len(before),
    "late": sorted(known() - before),
    "modules": sorted(set(sys.modules) - loaded),
    "reasons": sorted(reasons),
}))
"""


@pytest.mark.parametrize(
    ("scenario", "reason"), [("hand", "covered"), ("dropped", "colours"), ("lamp-off", "")]
)
def test_nothing_is_compiled_or_loaded_while_robots_are_driven(scenario: str, reason: str) -> None:
    # A process of its own: here other tests have called everything already.
    command = (sys.executable, "-c", RUN, scenario)
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    told = json.loads(done.stdout)
    assert told["before"] > 10
    assert not reason or reason in told["reasons"]
    assert told["late"] == []
    assert told["modules"] == []
