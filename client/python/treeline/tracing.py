"""The distributed trace that calls belong to:
https://www.w3.org/TR/trace-context

The client makes no spans itself. The server's become children of the span that
a call names; see docs/how-to/trace-queries.md of Treeline.
"""

from __future__ import annotations

import re
import secrets
import sys

_TRACEPARENT = re.compile(
    r"00-(?!0{32})[0-9a-f]{32}-(?!0{16})[0-9a-f]{16}-[0-9a-f]{2}")


def is_traceparent(text: str) -> bool:
    """Whether it is one of version 00."""
    return _TRACEPARENT.fullmatch(text) is not None


def new_traceparent(sampled: bool = True) -> str:
    """Of a new trace, for programs that record no spans of their own. sampled:
    whether the server is asked to record its."""
    # 0 is no id; of 16 bytes it never comes, and of 8 hardly.
    span_id = "0" * 16
    while span_id == "0" * 16:
        span_id = secrets.token_hex(8)
    return f"00-{secrets.token_hex(16)}-{span_id}-{'01' if sampled else '00'}"


def current_traceparent() -> str | None:
    """OpenTelemetry's current span, by the propagator that the program has set;
    None: it has none, or does not use OpenTelemetry."""
    # Whoever uses it has imported it: it is no dependency of this package.
    propagate = sys.modules.get("opentelemetry.propagate")
    if propagate is None:
        return None
    carrier: dict[str, str] = {}
    propagate.inject(carrier)
    return carrier.get("traceparent")
