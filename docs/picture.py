"""Takes the picture of the running view that the README shows: `make picture`.

Needs a Vulkan driver; without a graphics card a software one will do (Debian: mesa-vulkan-drivers).
"""

import subprocess
import sys
import time
from pathlib import Path

from rerun.experimental import ViewerClient

OUT = Path(__file__).parent / "view.png"
PORT = 9876  # where `--view rerun` looks for a viewer
START, MOMENT = 60.0, 7.0  # longest start of a run, and how long it then drives [s]


def main() -> None:
    """Run the paper's experiment into a viewer without a window, and take its picture."""
    rerun = Path(sys.executable).with_name("rerun")
    viewer = ViewerClient.spawn(headless=True, port=PORT, executable_path=str(rerun))
    time.sleep(3.0)
    command = [sys.executable, "-m", "pipeline", "live", "paper", "--view", "rerun"]
    session = OUT.parent.parent / "build" / "picture.mcap"
    session.parent.mkdir(exist_ok=True)
    run = subprocess.Popen([*command, "--record", str(session)])
    deadline = time.monotonic() + START
    while time.monotonic() < deadline and not (session.exists() and session.stat().st_size > 1e5):
        time.sleep(0.02)
    time.sleep(MOMENT)
    viewer.save_screenshot(str(OUT))
    run.wait()
    viewer.quit()


main()
