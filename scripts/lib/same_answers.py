"""Compares what two machines answered for the same frames with the same model.

Usage: same_answers.py EXPECTED.json OTHER.json, both of `treeline evaluate`.

Sums of floats round differently with other vector instructions and other C
libraries. A pose that rests on hundreds of samples moves by micrometres for
that; where a sample changes sides, by more, but not by what an answer's own
uncertainty is. Exits with 1 where an outcome differs, or where a pose differs
by more than the bounds below.
"""

import json
import statistics
import sys

import demo_table

MOST_APART_M = 1e-4
MOST_APART_DEG = 0.01
# So many in a hundred may have another outcome or a pose beyond the bounds: of
# two equally good hypotheses, rounding chooses.
MOST_OTHERS_PERCENT = 2


def frames_of(path):
    """The frames of the file's only method, by stem."""
    with open(path, encoding="utf-8") as file:
        return {frame["stem"]: frame for frame in json.load(file)["per_frame"]}


def compare(expected, other):
    """(sentences on frames that are not the same, (m, degrees) of those whose
    poses can be compared)."""
    found, apart = [], []
    for stem, frame in expected.items():
        answer = other.get(stem)
        if answer is None:
            found.append(f"{stem}: not answered")
            continue
        if answer["outcome"] != frame["outcome"]:
            found.append(f"{stem}: {frame['outcome']} here, "
                         f"{answer['outcome']} there")
            continue
        if frame["outcome"] != "LOCALIZED":
            continue
        pose, its = frame["world_from_camera"], answer["world_from_camera"]
        metres = demo_table.distance_m(pose, its)
        degrees = demo_table.angle_between_deg(pose, its)
        apart.append((metres, degrees))
        if metres > MOST_APART_M or degrees > MOST_APART_DEG:
            found.append(f"{stem}: the poses are {1000 * metres:.3f} mm and "
                         f"{degrees:.4f} degrees apart")
    found += [f"{stem}: answered there alone"
              for stem in other if stem not in expected]
    return found, apart


def report(expected, other):
    """Prints what was found; whether the answers are the same."""
    found, apart = compare(expected, other)
    print(f"{len(expected)} frames, {len(apart)} localized by both")
    if apart:
        metres = [m for m, _ in apart]
        degrees = [d for _, d in apart]
        identical = sum(m == 0 and d == 0 for m, d in apart)
        print(f"poses apart: median {1000 * statistics.median(metres):.6f} mm "
              f"and {statistics.median(degrees):.7f} degrees, at most "
              f"{1000 * max(metres):.4f} mm and {max(degrees):.5f} degrees; "
              f"{identical} the same bit for bit")
    for sentence in found[:10]:
        print(f"  {sentence}")
    if len(found) > 10:
        print(f"  and {len(found) - 10} more")
    return bool(apart) and (100 * len(found) <=
                            MOST_OTHERS_PERCENT * len(expected))


def main(arguments):
    if len(arguments) != 2:
        sys.exit(__doc__.strip())
    if report(*map(frames_of, arguments)):
        return 0
    print("the answers are not the same", file=sys.stderr)
    return 1


if __name__ == "__main__":
    try:
        sys.exit(main(sys.argv[1:]))
    except (OSError, json.JSONDecodeError) as error:
        sys.exit(f"same_answers: {error}")
    except KeyError as error:
        sys.exit(f"same_answers: the files do not have {error} where expected")
