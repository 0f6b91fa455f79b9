"""Gives a running treeline-agent a goal, carries it away, and tells the story.

Speaks the agent's HTTP interface (docs/reference/agent.md). Writes
summary.html and summary.json. Exit status 0 if the robot arrived and accepted
no wrong place.
"""

import argparse
import html
import json
import math
import pathlib
import random
import shutil
import subprocess
import sys
import time
import urllib.error
import urllib.request

SECONDS_TO_START = 120
SECONDS_TO_ARRIVE = 420
SECONDS_TO_CLOSE = 30
# Its picture is taken so long before it is carried away (s).
SHOWN_BEFORE_S = 2
MOST_KIDNAP_TRIES = 20
POLL_S = 0.1
# What counts as knowing one's place.
NEAR_M = 0.5
NEAR_DEG = 20
# So far away (m) it is carried.
FAR_M = 4
# So much room it has there (m): a robot turns in less. Of maps' pictures.
ROOM_M = 0.55
FREE = 254
LOST_MODES = ("lost", "relocalizing", "need_help")

HERE = pathlib.Path(__file__).resolve().parent
# Where build-page keeps what it has fetched.
PAGE_WORK = HERE.parent.parent / "build" / "page-work"


class Agent:
    """A treeline-agent by its HTTP interface."""

    def __init__(self, address, pid):
        self.address = address
        self.pid = pid

    def is_alive(self):
        if self.pid is None:
            return True
        # A child that ended and that nobody has waited for is dead, too.
        try:
            status = pathlib.Path(f"/proc/{self.pid}/stat").read_text()
        except OSError:
            return False
        return status.rsplit(")", 1)[1].split()[0] != "Z"

    def get(self, path):
        with urllib.request.urlopen(self.address + path, timeout=10) as reply:
            return reply.read()

    def get_json(self, path):
        return json.loads(self.get(path))

    def post(self, path, value, may_be_refused=False):
        """The reply; None if it may be refused and is."""
        request = urllib.request.Request(
            self.address + path, data=json.dumps(value).encode(),
            headers={"Content-Type": "application/json", "X-Treeline": "1"})
        try:
            with urllib.request.urlopen(request, timeout=10) as reply:
                return json.load(reply)
        except urllib.error.HTTPError as error:
            if may_be_refused:
                return None
            sys.exit(f"demo robot: the agent refused {path}: "
                     f"{error.read().decode(errors='replace')}")

    def wait_for_start(self):
        """Its info, when it has a pose."""
        until = time.monotonic() + SECONDS_TO_START
        while time.monotonic() < until:
            if not self.is_alive():
                sys.exit("demo robot: the agent ended before it began")
            try:
                info = self.get_json("/api/info")
                if self.get_json("/api/state").get("pose"):
                    return info
            except (OSError, ValueError):
                pass
            time.sleep(0.2)
        sys.exit(f"demo robot: no robot with a pose on {self.address} after "
                 f"{SECONDS_TO_START} s")


def read_trajectory(path):
    """(x, y, z, yaw) of each line of a TUM trajectory of the base."""
    poses = []
    for line in path.read_text().splitlines():
        if not line or line.startswith("#"):
            continue
        _, x, y, z, qx, qy, qz, qw = map(float, line.split()[:8])
        yaw = math.atan2(2 * (qw * qz + qx * qy), 1 - 2 * (qy * qy + qz * qz))
        poses.append((x, y, z, yaw))
    return poses


def highest_place(poses):
    """Where the drive was at its highest; of those, where it went furthest."""
    top = max(pose[2] for pose in poses)
    return max((pose for pose in poses if pose[2] > top - 0.05),
               key=lambda pose: math.hypot(pose[0], pose[1]))


class FreeGround:
    """A level's map_server picture: where a robot has room to turn."""

    def __init__(self, folder, level):
        stem = folder / "levels" / f"level-{level}"
        lines = dict(line.split(": ", 1) for line in
                     stem.with_suffix(".yaml").read_text().splitlines())
        self.cell_m = float(lines["resolution"])
        self.x, self.y, _ = json.loads(lines["origin"])
        _, size, _, self.cells = stem.with_suffix(".pgm").read_bytes().split(
            b"\n", 3)
        self.columns, self.rows = map(int, size.split())

    def is_free(self, x, y):
        column = math.floor((x - self.x) / self.cell_m)
        row = self.rows - 1 - math.floor((y - self.y) / self.cell_m)
        return (0 <= column < self.columns and 0 <= row < self.rows
                and self.cells[row * self.columns + column] == FREE)

    def has_room(self, x, y):
        steps = round(ROOM_M / self.cell_m)
        return all(self.is_free(x + i * self.cell_m, y + j * self.cell_m)
                   for i in range(-steps, steps + 1)
                   for j in range(-steps, steps + 1)
                   if math.hypot(i, j) <= steps)


def far_place(poses, robot, goal, seed, has_room):
    """Somewhere on the drive with room, in any heading, away from robot and
    goal; of a small map, where the drive was furthest from the robot."""
    def away(pose, place):
        return math.hypot(pose[0] - place["x"], pose[1] - place["y"])
    chance = random.Random(seed)
    far = [pose for pose in poses
           if away(pose, robot) > FAR_M and away(pose, goal) > FAR_M]
    chance.shuffle(far)
    x, y, z, _ = next((pose for pose in far if has_room(pose)),
                      max(poses, key=lambda pose: away(pose, robot)))
    return x, y, z, chance.uniform(-math.pi, math.pi)


def level_at(info, height_m):
    """The level whose heights hold this one; of several, the tightest."""
    levels = info["map"]["levels"]

    def misfit(level):
        low, high = level["min_height_m"], level["max_height_m"]
        beyond = max(low - height_m, height_m - high, 0)
        return (beyond > 0.1, beyond, high - low)
    return min(levels, key=misfit)["index"]


def place_of(info, pose):
    """What the agent's interface takes, of (x, y, z, yaw)."""
    x, y, z, yaw = pose
    return {"x": x, "y": y, "yaw": yaw, "level": level_at(info, z)}


def error_of(state):
    """(metres, degrees) between what the robot thinks and the truth."""
    pose, truth = state.get("pose"), state.get("truth")
    if not pose or not truth:
        return None
    turn = math.remainder(pose["yaw"] - truth["yaw"], 2 * math.pi)
    away = math.hypot(pose["x"] - truth["x"], pose["y"] - truth["y"])
    return away, abs(math.degrees(turn))


def is_wrong(error):
    return error is not None and (error[0] > NEAR_M or error[1] > NEAR_DEG)


class Story:
    """What happened, as it happens."""

    def __init__(self):
        self.start = time.monotonic()
        self.lines = []
        self.track = []      # (true x, true y, part of the story)
        self.part = 0
        self.mode = None

    def tell(self, text):
        seconds = time.monotonic() - self.start
        self.lines.append((seconds, text))
        print(f"{seconds:6.1f} s  {text}", flush=True)

    def see(self, state):
        truth = state.get("truth") or state.get("pose")
        if truth:
            self.track.append((truth["x"], truth["y"], self.part))
        if state["mode"] != self.mode:
            self.mode = state["mode"]
            cause = state.get("cause", "none")
            self.tell(self.mode.replace("_", " ") +
                      ("" if cause in ("none", "") else f" ({cause})"))


class PagePictures:
    """The page, open in a browser beside the story, and pictures of it; none
    without node, Chromium and the packages that build-page has fetched.
    """

    def __init__(self, address, folder):
        self.folder = folder
        self.asked = []    # (file, title)
        self.process = None
        if (shutil.which("node") and
                (PAGE_WORK / "node_modules" / "playwright-core").is_dir()):
            self.process = subprocess.Popen(
                ["node", str(HERE / "demo_page.mjs"), str(PAGE_WORK), address],
                stdin=subprocess.PIPE, stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL, text=True)

    def take(self, name, title):
        if self.process is None:
            return
        try:
            print(self.folder / name, file=self.process.stdin, flush=True)
            self.asked.append((name, title))
        except BrokenPipeError:
            self.process = None

    def taken(self):
        """(file, title) of each that came out, when all have."""
        if self.process is not None:
            self.process.stdin.close()
            try:
                self.process.wait(timeout=SECONDS_TO_CLOSE)
            except subprocess.TimeoutExpired:
                self.process.kill()
                self.process.wait()
        return [(name, title) for name, title in self.asked
                if (self.folder / name).is_file()]


def save(agent, path, file):
    try:
        file.write_bytes(agent.get(path))
        return True
    except (OSError, ValueError):
        return False


def drive(agent, goal, kidnap_after_s, elsewhere, out, story):
    """Goal, kidnap, recovery, arrival. What the summary says of it.

    elsewhere: of a robot's pose and the number of a try, where it is carried
    to.
    """
    result = {"arrived": False, "kidnapped": False, "recovered_s": None,
              "wrong_resumptions": 0}
    pictures = PagePictures(agent.address, out)
    agent.post("/api/goal", {"poses": [goal]})
    story.tell(f"goal: x {goal['x']:.2f} m, y {goal['y']:.2f} m, level "
               f"{goal['level']}, up the ramp")
    until = time.monotonic() + SECONDS_TO_ARRIVE
    driving_since = kidnapped_at = None
    was_lost = was_shown = False
    tries = 0
    while time.monotonic() < until:
        if not agent.is_alive():
            sys.exit("demo robot: the agent ended on its way")
        state = agent.get_json("/api/state")
        story.see(state)
        now = time.monotonic()
        drives = state["mode"] == "driving"
        if drives and driving_since is None:
            driving_since = now
        if (drives and not was_shown and
                now - driving_since > kidnap_after_s - SHOWN_BEFORE_S):
            was_shown = True
            pictures.take("page-driving.png", "On its way")
        if (drives and not result["kidnapped"] and
                now - driving_since > kidnap_after_s):
            if agent.post("/api/sim/kidnap", elsewhere(state["truth"], tries),
                          may_be_refused=True) is None:
                # Somebody stands there; another place will do.
                tries += 1
                if tries > MOST_KIDNAP_TRIES:
                    sys.exit("demo robot: there is no room to carry it to")
                continue
            story.part = 1
            result["kidnapped"] = True
            kidnapped_at = time.monotonic()
            story.tell("kidnapped: somebody carries it away, and it does not "
                       "feel that")
        if result["kidnapped"] and state["mode"] in LOST_MODES:
            if not was_lost:
                pictures.take("page-lost.png", "Carried away, it asks where it is")
            was_lost = True
        if was_lost and drives and result["recovered_s"] is None:
            result["recovered_s"] = now - kidnapped_at
            error = error_of(state)
            story.part = 2
            fix = state.get("fix") or {}
            if fix.get("localized"):
                result["fix"] = fix
                save(agent, "/api/query.jpg", out / "query.jpg")
            if error is not None:
                by = "the server" if "fix" in result else "the laser alone"
                story.tell(f"found by {by}: drives on, "
                           f"{result['recovered_s']:.1f} s after; it is "
                           f"{100 * error[0]:.1f} cm and {error[1]:.1f} "
                           "degrees off")
                result["error_m"], result["error_deg"] = error
                result["wrong_resumptions"] += is_wrong(error)
        goal_state = (state.get("goal") or {}).get("state")
        if goal_state == "succeeded":
            story.tell("arrived")
            result["arrived"] = True
            result["final_error"] = error_of(state)
            pictures.take("page-arrived.png", "Arrived")
            break
        if goal_state in ("failed", "cancelled"):
            why = state["goal"].get("why") or state.get("cause_text", "")
            story.tell(f"the goal {goal_state}: {why}")
            break
        time.sleep(POLL_S)
    else:
        story.tell(f"not there after {SECONDS_TO_ARRIVE} s")
    result["missed_deadlines"] = state.get("missed_deadlines")
    result["pictures"] = pictures.taken()
    return result


def track_picture(info, level, track):
    """An SVG: the level's picture with the way the robot truly went."""
    grid = info["map"]["levels"][level]
    width, height = grid["width"], grid["height"]
    x0, y0, _ = grid["origin"]
    step = grid["resolution_m"]
    colors = ("#2166ac", "#b2182b", "#1b7837")
    parts = [[], [], []]
    for x, y, part in track:
        parts[part].append(f"{(x - x0) / step:.1f},"
                           f"{height - (y - y0) / step:.1f}")
    lines = [f'<polyline points="{" ".join(points)}" fill="none" '
             f'stroke="{color}" stroke-width="2"/>'
             for points, color in zip(parts, colors) if points]
    if parts[0] and parts[1]:
        # Carried: from where to where.
        x, y = parts[1][0].split(",")
        lines.append(f'<polyline points="{parts[0][-1]} {parts[1][0]}" '
                     f'fill="none" stroke="{colors[1]}" stroke-width="1" '
                     'stroke-dasharray="4 4"/>'
                     f'<circle cx="{x}" cy="{y}" r="4" fill="{colors[1]}"/>')
    return (f'<svg viewBox="0 0 {width} {height}" '
            f'width="{min(900, 3 * width)}">'
            f'<image href="level-{level}.png" width="{width}" '
            f'height="{height}" style="image-rendering:pixelated"/>'
            + "".join(lines) + "</svg>")


def write_summary(out, info, level, story, result):
    figures = "".join(
        f'<figure><img src="{name}" alt=""><figcaption>{html.escape(title)}'
        "</figcaption></figure>" for name, title in result["pictures"])
    if (out / "query.jpg").is_file():
        fix = result.get("fix", {})
        figures += (
            '<figure><img src="query.jpg" alt=""><figcaption>What it asked the '
            f"server: {fix.get('inliers', 0)} inliers, confidence "
            f"{fix.get('confidence', 0):.2f}, answered in "
            f"{1000 * fix.get('round_trip_s', 0):.0f} ms</figcaption></figure>")
    rows = "".join(f"<tr><td>{seconds:.1f} s</td><td>{html.escape(text)}</td>"
                   "</tr>" for seconds, text in story.lines)
    (out / "summary.html").write_text(f"""<!doctype html>
<html lang="en"><meta charset="utf-8"><title>Treeline: a robot's story</title>
<meta name="viewport" content="width=device-width">
<style>
body {{ font: 16px/1.5 system-ui, sans-serif; max-width: 60rem; margin: 2rem
auto; padding: 0 1rem; color: #222; background: #fff }}
img, svg {{ max-width: 100%; height: auto; border: 1px solid #ccc }}
figure {{ margin: 1rem 0 }} figcaption {{ color: #555 }}
td {{ padding: 0 1rem 0 0; vertical-align: top }}
td:first-child {{ text-align: right; color: #555; white-space: nowrap }}
</style>
<h1>A robot that finds itself again</h1>
<p>{'It arrived.' if result['arrived'] else 'It did not arrive.'}
Mapped in one drive; kidnapped on its way
{'and driving again after %.1f s' % result['recovered_s']
 if result['recovered_s'] is not None else ''}.</p>
<h2>Where it went</h2>
<p>Blue: towards its goal. Red: carried, and looking for its place. Green: after
it knew its place again.</p>
{track_picture(info, level, story.track)}
<h2>What happened</h2><table>{rows}</table>
<h2>What was to be seen</h2>{figures}
<figure><img src="map/map.png" alt=""><figcaption>The map of the one drive
</figcaption></figure>
</html>
""", encoding="utf-8")
    kept = {key: value for key, value in result.items() if key != "pictures"}
    kept["events"] = [{"time_s": round(seconds, 2), "text": text}
                      for seconds, text in story.lines]
    (out / "summary.json").write_text(json.dumps(kept, indent=2) + "\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--agent", required=True, help="http://HOST:PORT")
    parser.add_argument("--agent-pid", type=int)
    parser.add_argument("--map", required=True, type=pathlib.Path)
    parser.add_argument("--out", required=True, type=pathlib.Path)
    parser.add_argument("--kidnap-after", type=float, default=12,
                        help="seconds of driving; default: 12")
    parser.add_argument("--seed", type=int, default=1,
                        help="of where it is carried; default: 1")
    arguments = parser.parse_args()
    agent = Agent(arguments.agent, arguments.agent_pid)
    info = agent.wait_for_start()
    poses = read_trajectory(arguments.map / "trajectory.txt")
    goal = place_of(info, highest_place(poses))
    out = arguments.out
    for old in ("page-driving.png", "page-lost.png", "page-arrived.png",
                "query.jpg"):
        (out / old).unlink(missing_ok=True)
    level = goal["level"]
    save(agent, f"/api/levels/{level}.png", out / f"level-{level}.png")
    story = Story()

    grounds = [FreeGround(arguments.map, one["index"])
               for one in info["map"]["levels"]]

    def has_room(pose):
        return grounds[place_of(info, pose)["level"]].has_room(*pose[:2])

    def elsewhere(robot, number):
        return place_of(info, far_place(poses, robot, goal,
                                        arguments.seed + number, has_room))
    result = drive(agent, goal, arguments.kidnap_after, elsewhere, out, story)
    write_summary(out, info, level, story, result)
    print(f"\nSummary: {out / 'summary.html'}")
    good = (result["arrived"] and result["recovered_s"] is not None
            and result["wrong_resumptions"] == 0)
    sys.exit(0 if good else 1)


if __name__ == "__main__":
    main()
