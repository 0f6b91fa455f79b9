"""Lays held-out frames of 7-Scenes red kitchen out like a recording of TUM.

    kitchen_recording.py KITCHEN OUTPUT

Writes OUTPUT/train.txt (every third training frame) and OUTPUT/recording with
test.txt, groundtruth.txt (camera to world, by poses-sfm.txt) and rgb/.
"""

import pathlib
import shutil
import sys


def product(a, b):
    """Of quaternions w, x, y, z."""
    aw, ax, ay, az = a
    bw, bx, by, bz = b
    return (aw * bw - ax * bx - ay * by - az * bz,
            aw * bx + ax * bw + ay * bz - az * by,
            aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw)


def main():
    kitchen, output = map(pathlib.Path, sys.argv[1:])
    train = (kitchen / "train.txt").read_text().split()
    (output / "train.txt").write_text("\n".join(train[::3]) + "\n")
    poses = {}
    for line in (kitchen / "poses-sfm.txt").read_text().splitlines():
        if line.startswith("#"):
            continue
        stem, *numbers = line.split()
        poses[pathlib.Path(stem).name] = [float(n) for n in numbers]
    recording = output / "recording"
    (recording / "rgb").mkdir(parents=True)
    names, truths = [], []
    for entry in (kitchen / "test.txt").read_text().split():
        name = pathlib.Path(entry).name
        w, x, y, z, *t = poses[name][:7]
        inverse = (w, -x, -y, -z)
        _, *turned = product(product(inverse, (0, *t)), (w, x, y, z))
        names.append(name)
        truths.append(" ".join([name, *(str(-v) for v in turned),
                                *(str(v) for v in (-x, -y, -z, w))]))
        shutil.copy(kitchen / f"{entry}.color.jpg",
                    recording / "rgb" / f"{name}.jpg")
    (recording / "test.txt").write_text("\n".join(names) + "\n")
    (recording / "groundtruth.txt").write_text("\n".join(truths) + "\n")


if __name__ == "__main__":
    main()
