"""Run exports with cluster workers that lie at random, and check that no export trusts them.

    python tests/fuzz/lying_workers.py --exports 20 --seed 7

Each export ends with exit code 2 in a sentence, or with all frames as one machine makes them.
"""

import argparse
import os
import sys
import tempfile
from collections import Counter
from pathlib import Path

if __name__ == "__main__":
    sys.path[:0] = [str(Path(__file__).parents[1])]
from heatlens.media.documents.shot_file import write_shot
from support.command_line import start_heatlens
from support.dask_cluster import dask_cluster
from support.exports import files_in, shot_of, write_plates

PATIENCE_S = 120.0


def export_with_liars(folder: Path, exports: int, seed: int) -> Counter[str]:
    """Export with a lying worker, alone or beside an honest one. Return counts of exit codes."""
    shot, counts = folder / "s.heatlens.json", Counter[str]()
    write_shot(shot, shot_of(write_plates(folder / "plates")))
    whole = start_heatlens("export", shot, "-o", folder / "whole" / "n.####.exr")
    whole.communicate(timeout=PATIENCE_S)
    assert whole.returncode == 0
    with dask_cluster(folder / "cluster", workers=0) as cluster:
        for number in range(seed, seed + exports):
            out = folder / f"out{number}"
            cluster.lie("liar", f"seed {number}", folder / "ran")
            if number % 3 == 0:
                cluster.work("honest")
            words = ["--fetch"] if number % 2 else []
            export = cluster.export("export", shot, "-o", out / "n.####.exr", "--chunk", 2, *words)
            code = export.wait(PATIENCE_S)
            message = cluster.said("export")
            assert code in (0, 2) and "Traceback" not in message and "\x1b" not in message, message
            assert code == 2 or files_in(out) == files_in(folder / "whole"), message
            foreign_runs = {it.name for it in folder.glob("ran.*")} - {
                f"ran.{cluster.process('liar')}"
            }
            assert not foreign_runs, message  # a worker unpickles its own errors
            counts[f"exit code {code}"] += 1
            cluster.stop(but=("scheduler", "export"))
    return counts


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--exports", type=int, default=10)
    parser.add_argument("--seed", type=int, default=os.getpid())
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        print(f"seed {args.seed}:", dict(export_with_liars(Path(folder), args.exports, args.seed)))


if __name__ == "__main__":
    main()
