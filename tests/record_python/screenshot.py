"""Opens a recording in the Rerun viewer without a display, and saves what it shows: screenshot.py RUN.rrd PICTURE.png [SECONDS]"""

import os
import subprocess
import sys
import time
from pathlib import Path

import rerun.experimental as rerun

source, picture = Path(sys.argv[1]), Path(sys.argv[2]).resolve()
wait = float(sys.argv[3]) if len(sys.argv) > 3 else 8.0
# The binary itself: the script of that name starts it as a child, and ending the script would leave the child.
viewer = Path(rerun.__file__).parents[2] / "rerun_cli" / "rerun"
port = 9876 + os.getpid() % 1000
process = subprocess.Popen(
    [viewer, source, "--headless", "--bind", "127.0.0.1", "--port", str(port), "--window-size", "1200x760"],
    stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, env=dict(os.environ, XDG_RUNTIME_DIR="/tmp"),
)
try:
    time.sleep(wait)
    with rerun.ViewerClient.connect(f"rerun+http://127.0.0.1:{port}/proxy") as client:
        client.save_screenshot(str(picture))
    end = time.monotonic() + 20
    while not picture.exists() and time.monotonic() < end:
        time.sleep(0.2)
    time.sleep(0.5)
finally:
    process.terminate()
    process.wait(10)
if not picture.exists():
    sys.exit(f"the viewer saved nothing to {picture}")
