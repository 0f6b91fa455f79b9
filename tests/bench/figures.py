"""What was measured, and how it compares with an earlier run."""

import dataclasses
import statistics

# Below this nothing is called a change, however steady the repeats were.
LEAST_CHANGE = 0.10


@dataclasses.dataclass
class Figure:
    """One quantity, measured several times in one run.

    values: one a repeat. The figure is the best of them: what disturbs a
    measurement makes a time longer and a rate smaller, never the other way.
    yardstick: the name of another figure of the same run that this one is
    held against; a slow moment of the machine slows both.
    """

    name: str
    unit: str
    values: list[float]
    better: str = "less"
    yardstick: str | None = None

    def __post_init__(self):
        if self.better not in ("less", "more"):
            raise ValueError(f"{self.name}: better is less or more, "
                             f"not {self.better}")
        if not self.values:
            raise ValueError(f"{self.name} was not measured")

    @property
    def value(self):
        return min(self.values) if self.better == "less" else max(self.values)

    @property
    def spread(self):
        """Of the repeats, as a share of the figure; 0 of a single one."""
        middle = statistics.median(self.values)
        if middle == 0:
            return 0.0
        return abs(middle - self.value) / abs(middle)

    def as_json(self):
        return {**dataclasses.asdict(self), "value": self.value}

    @staticmethod
    def of_json(data):
        fields = {field.name for field in dataclasses.fields(Figure)}
        return Figure(**{k: v for k, v in data.items() if k in fields})


@dataclasses.dataclass
class Change:
    """A figure now and before."""

    figure: Figure
    before: Figure
    # Worse by this share of what was before; negative: better.
    worse: float
    # Beyond what the repeats of both runs scatter by.
    is_certain: bool

    @property
    def is_regression(self):
        return self.is_certain and self.worse > 0


def changes(now, before):
    """For each figure of `now` that `before` has, in the order of `now`.

    Both are dictionaries of figures by name. Where a figure and its yardstick
    were measured both times, what is compared is their ratio: the machine may
    have been slower one day.
    """
    compared = []
    for name, figure in now.items():
        earlier = before.get(name)
        if earlier is None or earlier.unit != figure.unit or not earlier.value:
            continue
        ratio = figure.value / earlier.value
        noise = figure.spread + earlier.spread
        stick = figure.yardstick
        if stick in now and stick in before and before[stick].value:
            ratio /= now[stick].value / before[stick].value
            noise += now[stick].spread + before[stick].spread
        if ratio <= 0:
            continue
        worse = ratio - 1 if figure.better == "less" else 1 / ratio - 1
        compared.append(Change(figure, earlier, worse,
                               abs(worse) > max(LEAST_CHANGE, 2 * noise)))
    return compared
