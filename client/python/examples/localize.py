"""Asks a server where one image was taken.

    localize.py SERVER SCENE IMAGE [DEPTH]

DEPTH is a 16-bit PNG in millimetres, of the depth camera that the scene was
recorded with.
"""

import sys

import treeline


def main():
    server, scene, image, *depth = sys.argv[1:]
    with treeline.Client(server) as client:
        answer = client.localize(image, *depth, scene=scene)
    if not answer:
        print(f"NOT LOCALIZED: {answer.reason}")
        return 3
    x, y, z = answer.position_in_world_m
    print(f"{answer.pose_sensor} camera at {x:.4f} {y:.4f} {z:.4f} m,"
          f" confidence {answer.confidence:.2f}, {answer.inliers} of"
          f" {answer.samples} samples, {answer.round_trip_ms:.0f} ms")
    return 0


if __name__ == "__main__":
    sys.exit(main())
