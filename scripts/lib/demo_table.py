"""The demonstration's table: what came back from the server, against what the
same frames gave offline and against the truth.

Reads the JSON of `treeline evaluate` and the JSON lines of `treeline-client
localize --json`. Exits with 1 if an answer of the server is not, bit for bit,
the offline one, or is missing.
"""

import argparse
import json
import math
import statistics
import sys

POSE_KEYS = ("qw", "qx", "qy", "qz", "tx", "ty", "tz")


class DataError(Exception):
    """The files cannot be compared."""


def read_served(text):
    """Answers by stem, in the order they came."""
    answers = {}
    for number, line in enumerate(text.splitlines(), 1):
        if not line.strip():
            continue
        try:
            answer = json.loads(line)
        except json.JSONDecodeError as error:
            raise DataError(f"line {number} of the client's output is not "
                            f"JSON ({error}): {line[:200]}") from error
        if "stem" not in answer:
            raise DataError(f"line {number} of the client's output names no "
                            f"frame: {line[:200]}")
        if answer["stem"] in answers:
            raise DataError(f"{answer['stem']} was answered twice")
        answers[answer["stem"]] = answer
    return answers


def differences(offline_frames, served):
    """One sentence for each frame on which both do not agree exactly."""
    found = []
    for frame in offline_frames:
        stem = frame["stem"]
        answer = served.get(stem)
        if answer is None:
            found.append(f"{stem}: the server's answer is missing")
        elif answer["outcome"] == "ERROR":
            found.append(f"{stem}: the query failed: {answer['code']}: "
                         f"{answer['reason']}")
        elif answer["outcome"] != frame["outcome"]:
            found.append(f"{stem}: {frame['outcome']} offline, "
                         f"{answer['outcome']} through the server")
        elif answer["inliers"] != frame["inliers"]:
            found.append(f"{stem}: {frame['inliers']} inliers offline, "
                         f"{answer['inliers']} through the server")
        elif answer["world_from_camera"] != frame["world_from_camera"]:
            found.append(f"{stem}: the poses differ")
    stems = {frame["stem"] for frame in offline_frames}
    found += [f"{stem}: not among the offline frames"
              for stem in served if stem not in stems]
    return found


def angle_between_deg(a, b):
    """The angle of the rotation from pose a to pose b, in [0, 180]."""
    # |a - b| and |a + b| of unit quaternions are 2 sin(angle / 4) and
    # 2 cos(angle / 4), or the other way round for q and -q; accurate for small
    # angles, which the arc cosine is not.
    def norm(sign):
        return math.sqrt(sum((a[k] + sign * b[k]) ** 2
                             for k in ("qw", "qx", "qy", "qz")))
    apart, together = sorted((norm(-1), norm(1)))
    return math.degrees(4 * math.atan2(apart, together))


def distance_m(a, b):
    return math.dist([a[k] for k in ("tx", "ty", "tz")],
                     [b[k] for k in ("tx", "ty", "tz")])


def percentile(values, percent):
    """Interpolated linearly between the two nearest ranks."""
    values = sorted(values)
    if not values:
        return math.nan
    place = (len(values) - 1) * percent / 100
    below = math.floor(place)
    above = min(below + 1, len(values) - 1)
    return values[below] + (place - below) * (values[above] - values[below])


def errors_of(served, offline_frames):
    """(translation m, rotation deg) of each localized frame with a truth."""
    errors = []
    for frame in offline_frames:
        truth = frame["true_world_from_camera"]
        estimate = served.get(frame["stem"], {}).get("world_from_camera")
        if truth and estimate:
            errors.append((distance_m(estimate, truth),
                           angle_between_deg(estimate, truth)))
    return errors


def percent_within(errors, scored, translation_m, rotation_deg):
    right = sum(t < translation_m and r < rotation_deg for t, r in errors)
    return 100 * right / scored if scored else math.nan


def rows_of(offline, served):
    """(what, value) for each line of the table."""
    frames = offline["per_frame"]
    scored = sum(1 for frame in frames if frame["true_world_from_camera"])
    errors = errors_of(served, frames)
    localized = sum(answer.get("outcome") == "LOCALIZED"
                    for answer in served.values())
    round_trips = [answer["round_trip_ms"] for answer in served.values()
                   if "round_trip_ms" in answer]
    localizing = [answer["server"]["localize_ms"]
                  for answer in served.values() if "server" in answer]
    decoding = [answer["server"]["decode_ms"]
                for answer in served.values() if "server" in answer]

    def median(values):
        return statistics.median(values) if values else math.nan

    def milliseconds(values):
        return (f"{percentile(values, 50):.1f} / "
                f"{percentile(values, 99):.1f} ms")

    model = offline["model"]
    training = model["training"]
    return [
        ("held-out frames", f"{len(frames)}"),
        ("localized", f"{localized}"),
        ("within 5 cm and 5 degrees",
         f"{percent_within(errors, scored, 0.05, 5):.1f} %"),
        ("within 2 cm and 2 degrees",
         f"{percent_within(errors, scored, 0.02, 2):.1f} %"),
        ("median error",
         f"{100 * median([t for t, _ in errors]):.2f} cm, "
         f"{median([r for _, r in errors]):.2f} degrees"),
        ("round trip, p50 / p99", milliseconds(round_trips)),
        ("of which decoding images", milliseconds(decoding)),
        ("of which localizing", milliseconds(localizing)),
        ("training",
         f"{training['seconds']:.1f} s on {training['frames']} frames"),
        ("model", f"{model['file_bytes'] / 1e6:.1f} MB, "
                  f"{model['trees']} trees, {model['leaves']} leaves"),
    ]


def print_table(rows):
    width = max(len(what) for what, _ in rows)
    for what, value in rows:
        print(f"  {what:<{width}}  {value}")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--offline", required=True, metavar="JSON")
    parser.add_argument("--served", required=True, metavar="JSONL")
    arguments = parser.parse_args()
    with open(arguments.offline, encoding="utf-8") as file:
        offline = json.load(file)
    with open(arguments.served, encoding="utf-8") as file:
        served = read_served(file.read())
    print_table(rows_of(offline, served))
    print()
    found = differences(offline["per_frame"], served)
    if not found:
        print(f"All {len(served)} answers of the server are bit for bit those "
              f"of the offline evaluation.")
        return 0
    print(f"{len(found)} of the server's answers are not those of the offline "
          f"evaluation:", file=sys.stderr)
    for sentence in found[:10]:
        print(f"  {sentence}", file=sys.stderr)
    if len(found) > 10:
        print(f"  and {len(found) - 10} more", file=sys.stderr)
    return 1


if __name__ == "__main__":
    try:
        sys.exit(main())
    except (DataError, OSError, json.JSONDecodeError) as error:
        sys.exit(f"demo_table: {error}")
    except KeyError as error:
        sys.exit(f"demo_table: the files do not have {error} where expected")
