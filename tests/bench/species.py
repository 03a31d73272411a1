"""What a frame of each demo genome of the other species costs, and what expression.json has of the 18-node expression.

    species.py FOLDER DREAMS GENOMES

Leaves species.json in FOLDER and prints it. Processor seconds of a frame of 1280x720 with motion blur, on one thread: the
least of three. Exit status: 0 every bound is kept; 1 one is not.
"""

import json
import pathlib
import subprocess
import sys
import tempfile

ROUNDS = 3
# Seconds of agents and plants. Expressions cost what their authors write: those of the demo are told, not judged.
MOST_S = 2.0
JUDGED = (".agents", ".plant")


def seconds(dreams, genome, picture):
    """The least processor seconds of a frame."""
    words = [dreams, "still", genome, "--size", "1280x720", "--frame", "20", "--frames", "160", "--threads", "1"]
    run = [*words, "--out", picture, "--json"]
    return min(
        json.loads(subprocess.run(run, check=True, capture_output=True).stdout)["cpu_s"] for _ in range(ROUNDS)
    )


def main():
    folder, dreams, genomes = pathlib.Path(sys.argv[1]), sys.argv[2], pathlib.Path(sys.argv[3])
    expression = folder / "expression.json"
    others = sorted(path for ending in (".expr", *JUDGED) for path in genomes.glob(f"*{ending}"))
    with tempfile.TemporaryDirectory() as scratch:
        frames = {path.name: seconds(dreams, path, f"{scratch}/a.png") for path in others}
    figures = {"expression": json.loads(expression.read_text()), "frame_cpu_s": frames, "most_frame_cpu_s": MOST_S}
    expression.unlink()
    text = json.dumps(figures, indent=2)
    (folder / "species.json").write_text(text + "\n")
    print(text)
    return any(frames[path.name] > MOST_S for path in others if path.suffix in JUDGED)


sys.exit(main())
