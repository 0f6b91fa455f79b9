"""Treeline's client: tells where a camera is.

    import treeline

    with treeline.Client("127.0.0.1:50051") as client:
        answer = client.localize("frame.jpg", scene="room")
        if answer:
            print(answer.world_from_camera)

Client asks, Query says what about, Answer is what comes back. errors has the
exceptions, cameras the intrinsics of other systems, geometry poses and axes,
geodesy the Earth, tracing the traces that calls belong to.
"""

from treeline import cameras, errors, geodesy, geometry, tracing
from treeline.answer import (Answer, Calibration, Correspondences, Model,
                             Scene, SceneCandidate, StreamAnswer, Timings)
from treeline.cameras import Camera
from treeline.client import Client
from treeline.errors import TreelineError
from treeline.geodesy import GeoAnchor, GeoPose
from treeline.options import Tls
from treeline.query import (Depth, HeightBand, PosePrior, PositionPrior,
                            Query)

__all__ = [
    "Answer", "Calibration", "Camera", "Client", "Correspondences", "Depth",
    "GeoAnchor", "GeoPose", "HeightBand", "Model", "PosePrior",
    "PositionPrior", "Query", "Scene", "SceneCandidate", "StreamAnswer",
    "Timings", "Tls", "TreelineError", "cameras", "errors", "geodesy",
    "geometry", "tracing",
]
